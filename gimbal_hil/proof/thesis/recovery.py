"""Tables 4.7 to 4.10: the friction that the thesis' own fit found again, beside what this project's identification
finds on the same antenna.

Both start from the numbers of tables 4.1 to 4.6. The thesis simulates them and fits its simulation; here the virtual
antenna, with its sensors and its gravity, runs the short sliding and presliding sequences, and identification starts
from priors that are half as large again.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from gimbal_hil.knowledge.experiments import conduct
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
from gimbal_hil.knowledge.identification import Log, identify_axis, read_logs
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.proof.thesis.printed import FRICTION, FRICTION_RECOVERED
from sim_backend.model import AntennaModel, shipped_model

#: in the order of `printed.FRICTION`
NAMES = ("breakaway", "coulomb", "stribeck_velocity", "viscous", "shape", "sigma0", "sigma1")
SYMBOLS = ("Ts", "Tc", "vs", "sigma2", "delta", "sigma0", "sigma1")
_SEED = 1


@dataclass(frozen=True)
class Recovered:
    """One friction number found again: the true one, what the thesis found, and what is found here, 95 % interval."""

    axis: str
    symbol: str
    unit: str
    true: float
    thesis: float
    here: float
    low: float
    high: float

    @property
    def thesis_error_percent(self) -> float:
        """Of the thesis' own recovery."""
        return 100.0 * (self.thesis / self.true - 1.0)

    @property
    def error_percent(self) -> float:
        """Of this project's."""
        return 100.0 * (self.here / self.true - 1.0)


def recover(axis: str) -> tuple[Recovered, ...]:
    """Run both sequences on one axis of the shipped antenna in lockstep and identify its seven friction numbers."""
    model, settings = shipped_model(), shipped_settings()
    options = SequenceOptions(settings.rate_hz, (axis,), short=True, breakaway_nm=breakaway_torques(model))
    logs: list[Log] = []
    with tempfile.TemporaryDirectory() as folder:
        for place, name in enumerate(("sliding", "presliding")):
            experiment = build_experiment(name, options)
            outcome = conduct(experiment, settings, model, _SEED + place, Path(folder) / name)
            logs += read_logs(outcome.folder, model.axes)
        found = {estimate.name: estimate for estimate in identify_axis(logs, _doubtful(model, axis), axis).estimates}
    return tuple(
        Recovered(
            axis,
            symbol,
            found[name].unit,
            true,
            recovered,
            found[name].value,
            found[name].interval.low,
            found[name].interval.high,
        )
        for name, symbol, true, recovered in zip(NAMES, SYMBOLS, FRICTION[axis], FRICTION_RECOVERED[axis], strict=True)
    )


def _doubtful(model: AntennaModel, axis: str) -> AntennaModel:
    """A prior that does not know the answer: every friction number half as large again."""
    return model.with_numbers(
        axis, {f"friction.{name}": 1.5 * model.number(axis, f"friction.{name}") for name in NAMES}
    )
