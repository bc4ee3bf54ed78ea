"""A case as files that any tool can read, its truth apart.

    CASE/case.json       axes, step, numbers of the known model, names that may be told (docs/reference/effects.md)
    CASE/measured_0.csv  commanded torque, encoder position, gyro rate, ... (docs/reference/signals-table.md), and
    CASE/measured_1.csv    AXIS.torque_model: what the known model says of this motion, filtered; AXIS.torque_filtered
    CASE/challenge.csv   another trajectory without its torque: AXIS.torque_filtered is to be predicted

and what a tool leaves:

    ANSWER/answer.json   {"effects": [{"name", "axis", "probability"}], "something_else": probability that none is it}
    ANSWER/torque.csv    a column AXIS.torque for each axis, a row for each of challenge.csv; may be left out
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.naming.cases import Task
from tests.benchmarks.naming.known import known_torque
from tests.benchmarks.naming.tables import BAND_HZ, smooth, write_csv
from tests.blind.causes import catalogue
from tests.blind.rig import Axes, Rig

LOGS = ("measured_0", "measured_1", "challenge")


def write_case(task: Task, seed: int, folder: Path, truth: Path) -> None:
    """Draw a case into `folder`, what only the scorer may see into `truth` (json and npy beside it)."""
    case = task.drawn(seed)
    folder.mkdir(parents=True, exist_ok=True)
    truth.parent.mkdir(parents=True, exist_ok=True)
    step_s = case.rig.step_s
    for name, columns in zip(LOGS, (*case.measured, *case.holdout), strict=True):
        needed = known_torque(columns, case.rig, step_s)
        shown = dict(columns)
        for k, axis in enumerate(case.axes):
            shown[f"{axis}.torque_model"] = needed[:, k]
            shown[f"{axis}.torque_filtered"] = smooth(_at_rows(np.asarray(columns[f"{axis}.torque"])), step_s)
        if name == "challenge":
            hidden = np.stack([shown.pop(f"{axis}.torque_filtered") for axis in case.axes], axis=1)
            shown = {key: column for key, column in shown.items() if not key.endswith(".torque")}
            np.save(truth.with_suffix(".npy"), hidden)
        write_csv(folder / f"{name}.csv", shown)
    (folder / "case.json").write_text(json.dumps(_case(case.rig), indent=1))
    truth.write_text(json.dumps(case.truth | {"task": task.name}, indent=1, default=float))


def _at_rows(held: np.ndarray) -> np.ndarray:
    """Torque at the instants of positions: row k acts from there to the next, so half of it and half of the row before.
    Taken as it stands, every tool would find a delay.
    """
    return 0.5 * (held + np.concatenate([held[:1], held[:-1]]))


def _case(rig: Rig) -> dict[str, Any]:
    friction = {axis: rig.friction[("outer", "inner")[k]] for k, axis in enumerate(rig.names)}
    bodies = {axis: rig.bodies[("outer", "inner")[k]].tolist() for k, axis in enumerate(rig.names)}
    names = sorted({cause.name for cause in catalogue(np.random.default_rng(0), "outer", Axes.GIMBAL.value)})
    return {
        "axes": list(rig.names),
        "step_s": rig.step_s,
        "band_hz": BAND_HZ,
        "friction": friction,
        "bodies": bodies,
        "inertia": rig.inertia.tolist(),
        "torque_limits": list(rig.limits),
        "encoder_step": rig.encoder_step,
        "names": names,
    }
