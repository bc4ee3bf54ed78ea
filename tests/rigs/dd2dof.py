"""The first axis of a direct-drive arm in the vertical plane: break-away ramps, constant speeds, presliding, one
open-loop run.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tests.rigs.data import data_folder
from tests.rigs.rig import Rig, write_log, write_model

AXIS = "shoulder"
#: encoder step (rad), gravity torque amplitude (N m) and inertia (kg m2) of the published model, second axis straight
STEP = float(np.deg2rad(3.515e-4))
GRAVITY = 9.81 * (3.921 + 0.186)
INERTIA = 2.351 + 0.168


def arm_signals(position_file: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (s), position (rad) and commanded torque (N m) of one run, from its position file."""
    torque_file = position_file.with_name(position_file.name.replace("pos1", "tau1"))
    if not torque_file.exists():
        torque_file = torque_file.with_name(torque_file.name.replace("GAN", "gan"))
    position, torque = np.loadtxt(position_file), np.loadtxt(torque_file)
    rows = min(len(position), len(torque))
    return position[:rows, 0], np.deg2rad(position[:rows, 1]), torque[:rows, 1]


def sliding_rows(position: np.ndarray) -> int:
    """Number of rows of a constant-speed run up to the one where the axis stops or turns back."""
    return int(np.argmax(np.abs(position) > np.abs(position).max() - 1e-3)) + 1


def write_dd2dof(folder: Path, scaled: Mapping[str, float] | None = None) -> Rig:
    """The runs of three experiments and the published model with one Coulomb and one viscous number for both
    directions.

    Keys are the names of the position files without `pos1_`, `_gan` and ending: `est_05_exp` (ramps), `cin_n10_exp`
    (constant speeds, deg/s, up to where the axis stops), `sig0_6_exp1` (presliding).
    """
    folder.mkdir(parents=True, exist_ok=True)
    logs = {}
    for file in sorted(data_folder("dd2dof").glob("test_*/*pos1_*.t")):
        time, position, torque = arm_signals(file)
        rows = sliding_rows(position) if file.name.startswith("cin") else len(time)
        # two runs have a second recording of another period behind the first
        steps = np.flatnonzero(np.abs(np.diff(time[:rows]) - 0.015) > 1e-3)
        rows = int(steps[0]) + 1 if len(steps) else rows
        name = file.stem.replace("pos1_", "").removesuffix("_gan").removesuffix("_GAN")
        columns = {
            "time_s": time[:rows] - time[0],
            f"{AXIS}.torque": torque[:rows],
            f"{AXIS}.position": position[:rows],
        }
        logs[name] = write_log(folder / f"{name}.csv", columns)
    return Rig(write_model(folder / "dd2dof.yaml", _model(), scaled), logs)


def _model() -> dict:
    axis = {
        "body": {
            "mass": {"value": 1.0, "unit": "kg", "source": "assumed, only its product with the distance counts"},
            "cog": {"y": {"value": -GRAVITY / 9.81, "unit": "m", "source": "published"}},
            "inertia": {"zz": {"value": INERTIA, "unit": "kg m2", "source": "published"}},
        },
        "friction": {
            "coulomb": {"value": 11.69, "unit": "N m", "source": "published, mean of both directions"},
            "breakaway": {"value": 11.69, "unit": "N m", "source": "assumed, no bump"},
            "viscous": {"value": 3.12, "unit": "N m s/rad", "source": "published, mean of both directions"},
        },
        "encoder": {"step": {"value": STEP, "unit": "rad", "source": "published"}},
    }
    return {"schema": 1, "name": "arm", "kind": "rotary", "incline_sine": 1.0, "axes": {AXIS: axis}}
