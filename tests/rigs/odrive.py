"""A brushless motor on an ODrive that turns slowly: encoder counts and motor current, polled unevenly over USB."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tests.rigs.data import data_folder
from tests.rigs.rig import Rig, write_log, write_model

AXIS = "motor"
COUNTS = 8192
#: N m/A, from the author's acceleration tests; no data sheet
TORQUE_CONSTANT = 0.0094
#: a run begins with a transient of the position loop
_TRANSIENT_S = 0.5
#: folders whose runs share an encoder zero among themselves, without those in which the neighbouring motor moved
FOLDERS = ("slow2", "slow2_slower", "slow_goodgains_2")


def write_odrive(folder: Path, scaled: Mapping[str, float] | None = None) -> Rig:
    """The runs as `FOLDER/RUN.csv` (keys `slow2/nocomp_0`), times as polled, and a model of inertia and a little
    friction.
    """
    logs = {}
    for name in FOLDERS:
        (folder / name).mkdir(parents=True, exist_ok=True)
        for file in sorted((data_folder("odrive") / name).glob("*comp_*.npy")):
            time, counts, current = np.load(file)
            kept = time >= _TRANSIENT_S
            columns = {
                "time_s": time[kept] - time[kept][0],
                f"{AXIS}.torque": TORQUE_CONSTANT * current[kept],
                f"{AXIS}.position": 2.0 * np.pi / COUNTS * counts[kept],
            }
            logs[f"{name}/{file.stem}"] = write_log(folder / name / f"{file.stem}.csv", columns)
    return Rig(write_model(folder / "odrive.yaml", _model(), scaled), logs)


def _model() -> dict:
    axis = {
        "body": {"inertia": {"zz": {"value": 2.5e-4, "unit": "kg m2", "source": "measured by the author, unloaded"}}},
        "friction": {
            "coulomb": {"value": 0.003, "unit": "N m", "source": "inferred from slow turns"},
            "breakaway": {"value": 0.003, "unit": "N m", "source": "assumed, no bump"},
            "viscous": {"value": 1e-5, "unit": "N m s/rad", "source": "assumed, a little"},
        },
        "encoder": {
            "step": {"value": 2.0 * float(np.pi) / COUNTS, "unit": "rad", "source": "printed, 8192 counts a turn"}
        },
    }
    return {"schema": 1, "name": "odrive", "kind": "rotary", "axes": {AXIS: axis}}
