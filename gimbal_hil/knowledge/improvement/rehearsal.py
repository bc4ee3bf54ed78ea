"""An experiment tried on the model first: what torque and travel it needs, and what it would measure if the model were
right.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from firmware_protocol.errors import SafetyStopError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.experiments import Experiment, LockstepAntenna, Signals
from gimbal_hil.loop.settings import DaemonSettings
from sim_backend.firmware_run import FirmwareRun
from sim_backend.model import AntennaModel

#: signals that a rehearsal's table carries
_KEPT = ("torque", "position", "rate", "temperature")
#: the encoder's noise and the overshoot of another rehearsal stay below this, rad
_SAME_RAD = 1e-6


@dataclass(frozen=True)
class Rehearsal:
    """Largest torque (N m) and travel (rad) by axis, and the signals from the first step to the last."""

    torque_nm: Mapping[str, float]
    travel_rad: Mapping[str, tuple[float, float]]
    table: SignalsTable | None
    #: why it came to no end, where a guard or the supervisor stopped it
    stopped: str | None = None


def rehearse(experiment: Experiment, settings: DaemonSettings, model: AntennaModel, seed: int = 0) -> Rehearsal:
    """Run an experiment on a virtual antenna made from `model`, in lockstep and without a log."""
    if experiment.base is not None:
        model = model.with_base(experiment.base)
    antenna = LockstepAntenna(settings, model, seed, log_every=1000, firmware=FirmwareRun.VIRTUAL)
    parts: list[Signals] = []
    stopped = None
    try:
        antenna.connect()
        for step in experiment.steps:
            parts.append(antenna.follow(step, lambda ticks: None).signals)
    except SafetyStopError as stop:
        stopped = str(stop)
    if not parts:
        return Rehearsal(dict.fromkeys(model.axes, 0.0), dict.fromkeys(model.axes, (0.0, 0.0)), None, stopped)
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    torque = {axis: float(np.max(np.abs(columns[f"{axis}.torque"]))) for axis in model.axes}
    travel = {
        axis: (
            float(np.min(columns[f"{axis}.position"])) + _SAME_RAD,
            float(np.max(columns[f"{axis}.position"])) - _SAME_RAD,
        )
        for axis in model.axes
    }
    kept = {f"{axis}.{name}": columns[f"{axis}.{name}"] for axis in model.axes for name in _KEPT}
    kept = {name: values for name, values in kept.items() if np.isfinite(values).all()}
    time_s = np.arange(len(columns["time_s"])) / settings.rate_hz
    return Rehearsal(
        torque, travel, SignalsTable.of(model.axes, time_s, kept, source=f"rehearsal of {experiment.name}"), stopped
    )
