"""Models and logs of the two measured rigs, for the workflow; what the data are is in their SOURCE.md."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel, model_from_document
from tests.rigs.data import data_folder
from tests.rigs.dd2dof import GRAVITY, INERTIA, STEP, sliding_rows

#: a plateau of the arm: commanded speeds (deg/s) that are fitted, and those that judge
ARM_FITTED = ("1", "3", "5", "15", "30", "n1", "n3", "n5", "n15", "n30")
ARM_RAMPS = ("05_exp", "05_exp1", "05_exp2", "05_exp3", "n05_exp1", "n05_exp4")
ARM_JUDGED = ("2", "4", "10", "20", "35", "n2", "n4", "n10", "n20", "n35")


def arm_model() -> AntennaModel:
    """The arm's first axis with symmetric Coulomb and viscous friction, the mean of the published directions."""
    friction = {"coulomb": 11.69, "breakaway": 11.69, "stribeck_velocity": 0.01, "viscous": 3.12}
    body = {"mass": 1.0, "cog": {"x": 0.0, "y": -GRAVITY / 9.81}, "inertia": {"zz": INERTIA}}
    return _model("arm", "rotary", "shoulder", {"body": body, "friction": friction, "encoder": {"step": STEP}})


def arm_logs(speeds: tuple[str, ...]) -> tuple[SignalsTable, ...]:
    """Constant-speed runs, each up to the row where the axis stops or turns back."""
    folder = data_folder("dd2dof") / "test_2"
    return tuple(_arm_log(folder / f"cin_pos1_{speed}_exp_gan.t") for speed in speeds)


def arm_ramps() -> tuple[SignalsTable, ...]:
    """Break-away ramps of both signs; the other files go on with something else after the ramp."""
    folder = data_folder("dd2dof") / "test_1"
    return tuple(_arm_log(folder / f"est_pos1_{name}_gan.t", whole=True) for name in ARM_RAMPS)


def _arm_log(file: Path, whole: bool = False) -> SignalsTable:
    position, torque = np.loadtxt(file), np.loadtxt(file.with_name(file.name.replace("pos1", "tau1")))
    rows = min(len(position), len(torque))
    angle = np.deg2rad(position[:rows, 1])
    stop = rows if whole else sliding_rows(angle)
    time = 0.015 * np.arange(stop)
    return SignalsTable.of(
        ("shoulder",), time, {"shoulder.torque": torque[:stop, 1], "shoulder.position": angle[:stop]}, source=file.name
    )


def _model(name: str, kind: str, axis: str, document: dict[str, Any]) -> AntennaModel:
    extra = {"incline_sine": 1.0} if kind == "rotary" else {}
    return model_from_document({"schema": 1, "name": name, "kind": kind, **extra, "axes": {axis: document}}, name)
