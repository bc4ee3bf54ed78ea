"""Models and logs of the two measured rigs, for the workflow; what the data are is in their SOURCE.md."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gimbal_hil.discrepancy.fit import refit, residual_of
from gimbal_hil.discrepancy.hypothesis import Hypothesis
from gimbal_hil.discrepancy.record import record_of
from gimbal_hil.discrepancy.twin import Twin
from gimbal_hil.signals import SignalsTable
from sim_backend.model import AntennaModel, model_from_document
from tests.identification.measured_data import emps
from tests.rigs.data import data_folder
from tests.rigs.dd2dof import GRAVITY, INERTIA, STEP, sliding_rows
from tests.rigs.emps import LAP as EMPS_LAP

#: a plateau of the arm: commanded speeds (deg/s) that are fitted, and those that judge
ARM_FITTED = ("1", "3", "5", "15", "30", "n1", "n3", "n5", "n15", "n30")
ARM_RAMPS = ("05_exp", "05_exp1", "05_exp2", "05_exp3", "n05_exp1", "n05_exp4")
ARM_JUDGED = ("2", "4", "10", "20", "35", "n2", "n4", "n10", "n20", "n35")


def emps_model(coulomb_n: float) -> AntennaModel:
    """The published symmetric model without a bristle; Coulomb friction as given."""
    friction = {"coulomb": coulomb_n, "breakaway": coulomb_n, "stribeck_velocity": 0.01, "viscous": 203.5034}
    axis = {
        "body": {"mass": 95.1089},
        "friction": friction,
        "actuator": {"limit": 351.5, "offset": 3.1648},
        "encoder": {"step": 5e-8},
    }
    return _model("emps", "linear", "carriage", axis)


def emps_logs(name: str) -> tuple[SignalsTable, SignalsTable]:
    """The first two laps, and what comes after them."""
    time, position, force = emps(name)
    parts = (slice(0, 2 * EMPS_LAP), slice(2 * EMPS_LAP, len(time)))
    one, other = (
        SignalsTable.of(
            ("carriage",), time[p], {"carriage.torque": force[p], "carriage.position": position[p]}, source=name
        )
        for p in parts
    )
    return one, other


def left_over(
    model: AntennaModel,
    hypothesis: Hypothesis,
    fitted: Sequence[SignalsTable],
    judged: Sequence[SignalsTable],
    hz: float,
    floor: float,
) -> float:
    """Rms that a hypothesis, refitted to some logs, leaves of the first axis' torque in others, N or N m, in a band
    that ends at `hz`.
    """
    here, there = (
        Twin(model, tuple(record_of(one, model, hz, one.source) for one in logs)) for logs in (fitted, judged)
    )
    refitted = refit(here, hypothesis, np.array([floor]), rounds=8, spread=2.0).hypothesis
    return float(np.sqrt(np.mean(residual_of(there, refitted, np.ones(1)) ** 2)))


def with_free(hypothesis: Hypothesis, parameter: str) -> Hypothesis:
    """The same with one parameter of its causes left free and all others held where they are."""
    causes = []
    for cause in hypothesis.causes:
        knobs = tuple(
            knob if parameter in knob.parameters else replace(knob, low=x, high=x)
            for knob, x in zip(cause.family.knobs, cause.x, strict=True)
        )
        causes.append(replace(cause, family=replace(cause.family, knobs=knobs)))
    return replace(hypothesis, causes=tuple(causes))


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


def emps_laps() -> tuple[SignalsTable, ...]:
    """The three whole laps of the first file and the last, which is cut short, each as a log of its own."""
    time, position, force = emps("DATA_EMPS")
    parts = [slice(k * EMPS_LAP, min((k + 1) * EMPS_LAP, len(time))) for k in range(4)]
    return tuple(
        SignalsTable.of(
            ("carriage",),
            time[p],
            {"carriage.torque": force[p], "carriage.position": position[p]},
            source=f"lap {k + 1}",
        )
        for k, p in enumerate(parts)
    )


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
