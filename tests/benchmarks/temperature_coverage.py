"""Do the intervals of `identify --over-temperature` hold what is true from -40 to 85 degC? Hidden antennas say it.

    python -m tests.benchmarks.temperature_coverage [--antennas 6] [--first 8100] [--presliding] [--out FILE]

Every antenna has friction of its own, up to 40 % off the shipped one at 20 degC, and laws over temperature of its own
that the workflow does not know: viscosity after Vogel, Fulcher and Tammann, a Coulomb level with a kink, a Stribeck
velocity and a bristle stiffness that go their own ways, and a ripple over the position on one axis. It is moved by the
short sequences at five temperatures that are drawn around -40, -10, 20, 50 and 85 degC, from a prior that is one
temperature's and up to 25 % off. The shipped command gets the run folders and a model without a table.

An interval of 95 % should hold the truth in 90 to 98 of 100, and its error should be half a half width rms (0.51 where
errors are normal).
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import math
import tempfile
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gimbal_hil.knowledge.experiments.conducting import conduct
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
from gimbal_hil.knowledge.identification import LUGRE_NAMES
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.surface.cli.app import run
from sim_backend.model import AntennaModel, shipped_model
from tests.benchmarks.interval_coverage import DRAWN_WITHIN, PRIOR_OFF_BY, said, scaled

#: about these the temperatures of the runs are drawn, and how far off (degC)
ABOUT_DEGC, OFF_BY_DEGC = (-40.0, -10.0, 20.0, 50.0, 85.0), 4.0
_ROOM_DEGC = 20.0
#: of the ripple: share of the Coulomb level, and orders a turn
_RIPPLE, _ORDERS = 0.1, (5, 40)


@dataclass(frozen=True)
class HiddenGrease:
    """How one axis' friction goes over temperature, as factors of its numbers at 20 degC.

    Viscosity: exp(b / (T - t0) - b / (20 - t0)), T in degC (Vogel 1921). Coulomb and break-away: one slope below a kink
    and another above it (1/K). Stribeck velocity: viscosity to a power. Stiffness: a slope.
    """

    vogel_k: float
    vogel_degc: float
    kink_degc: float
    cold_per_k: float
    warm_per_k: float
    power: float
    stiffness_per_k: float

    @staticmethod
    def drawn(rng: np.random.Generator) -> HiddenGrease:
        """Viscosity 3 to 12 times as large at -40 degC as at 20 degC."""
        vogel_degc = float(rng.uniform(-170.0, -110.0))
        thicker = float(rng.uniform(3.0, 12.0))
        vogel_k = math.log(thicker) / (1.0 / (-40.0 - vogel_degc) - 1.0 / (_ROOM_DEGC - vogel_degc))
        cold, warm = float(rng.uniform(-0.006, -0.001)), float(rng.uniform(-0.003, 0.002))
        kink, power = float(rng.uniform(-20.0, 30.0)), float(rng.uniform(-0.6, -0.2))
        return HiddenGrease(vogel_k, vogel_degc, kink, cold, warm, power, float(rng.uniform(-0.002, 0.002)))

    def factors(self, degc: float) -> dict[str, float]:
        """Of each friction number."""
        thicker = math.exp(self.vogel_k / (degc - self.vogel_degc) - self.vogel_k / (_ROOM_DEGC - self.vogel_degc))
        level = self._level(degc) / self._level(_ROOM_DEGC)
        return {
            "breakaway": level,
            "coulomb": level,
            "stribeck_velocity": thicker**self.power,
            "sigma0": 1.0 + self.stiffness_per_k * (degc - _ROOM_DEGC),
            "viscous": thicker,
        }

    def _level(self, degc: float) -> float:
        slope = self.cold_per_k if degc < self.kink_degc else self.warm_per_k
        return 1.0 + slope * (degc - self.kink_degc)


def at(room: AntennaModel, greases: dict[str, HiddenGrease], degc: float) -> AntennaModel:
    """The hidden antenna as it is at a temperature."""
    for axis, grease in greases.items():
        factors = grease.factors(degc)
        numbers = {f"friction.{n}": room.number(axis, f"friction.{n}") * factor for n, factor in factors.items()}
        room = room.with_numbers(axis, numbers | {"thermal.ambient": degc})
    return room


def rippled(model: AntennaModel, rng: np.random.Generator) -> AntennaModel:
    """The model with a ripple on one of its axes."""
    axis = str(rng.choice(model.axes))
    size = _RIPPLE * rng.uniform(0.0, 1.0) * model.number(axis, "friction.coulomb")
    ripple = {"amplitude": size, "order": float(rng.integers(*_ORDERS)), "phase": float(rng.uniform(-3.0, 3.0))}
    return model.with_effect("cogging", axis, ripple)


def errors_of(seed: int, sequences: tuple[str, ...], folder: Path) -> list[tuple[str, float, str, float]]:
    """Number, temperature (degC), verdict and error in half widths of every row and axis of one hidden antenna."""
    rng = np.random.default_rng(seed)
    room = scaled(shipped_model(), DRAWN_WITHIN, rng)
    prior = scaled(room, PRIOR_OFF_BY, rng)
    greases = {axis: HiddenGrease.drawn(rng) for axis in room.axes}
    hidden = rippled(room, rng)
    settings, runs, truths = shipped_settings(), [], []
    options = SequenceOptions(settings.rate_hz, room.axes, short=True, breakaway_nm=breakaway_torques(prior))
    for place, about in enumerate(ABOUT_DEGC):
        truths.append(at(hidden, greases, about + float(rng.uniform(-OFF_BY_DEGC, OFF_BY_DEGC))))
        for name in sequences:
            out = folder / f"{name}{place}"
            conduct(build_experiment(name, options), settings, truths[-1], 100 * seed + len(runs), out)
            runs.append(str(out))
    file = folder / "prior.yaml"
    file.write_text(prior.to_yaml())
    words = [*runs, "--over-temperature", "--model", str(file), "--out", str(folder / "found"), "--json"]
    with contextlib.redirect_stdout(io.StringIO()) as told:
        run("identify", [*words, "--workers", "1"])
    errors = []
    for row in json.loads(told.getvalue())["over_temperature"]:
        degc, axis = row["temperature_degc"], row["axis"]
        truth = min(truths, key=lambda one: abs(one.number(axis, "thermal.ambient") - degc))
        for name, one in row["numbers"].items():
            if one["low"] is None or one["high"] is None:
                errors.append((name, degc, one["verdict"], math.nan))
                continue
            true = truth.number(axis, f"friction.{name}")
            half = one["high"] - one["value"] if true > one["value"] else one["value"] - one["low"]
            errors.append((name, degc, one["verdict"], (true - one["value"]) / half if half > 0.0 else math.inf))
    return errors


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--antennas", type=int, default=6)
    parser.add_argument("--first", type=int, default=8100, help="seed of the first antenna")
    parser.add_argument("--presliding", action="store_true", help="presliding runs too: sigma0 and sigma1")
    parser.add_argument("--out", type=Path, help="every error, a JSON line for each; adds to the file")
    asked = parser.parse_args()
    sequences = ("sliding", "presliding") if asked.presliding else ("sliding",)
    by_name, by_degc = defaultdict[str, list[float]](list), defaultdict[float, list[float]](list)
    open_ones = 0
    for seed in range(asked.first, asked.first + asked.antennas):
        with tempfile.TemporaryDirectory() as folder:
            own = errors_of(seed, sequences, Path(folder))
        if asked.out:
            with asked.out.open("a") as file:
                file.writelines(json.dumps([seed, *one]) + "\n" for one in own)
        sure = [one for one in own if one[2] == "identified"]
        open_ones += len(own) - len(sure)
        for name, degc, _, error in sure:
            by_name[name].append(error)
            by_degc[min(ABOUT_DEGC, key=lambda about: abs(about - degc))].append(error)
        missed = [f"{name} at {degc:.0f} degC {error:+.2f}" for name, degc, _, error in sure if abs(error) > 1.0]
        print(f"seed {seed}: {len(sure)} of {len(own)} identified; missed: {', '.join(missed) or 'none'}", flush=True)
    for name in LUGRE_NAMES:
        if by_name[name]:
            print(said(name, by_name[name]))
    for degc, errors in sorted(by_degc.items()):
        print(said(f"about {degc:.0f} degC", errors))
    print(said("all", [error for errors in by_name.values() for error in errors]))
    print(f"{open_ones} numbers weakly or not identified")


if __name__ == "__main__":
    main()
