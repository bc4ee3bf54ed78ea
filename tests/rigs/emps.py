"""The EMPS servo axis: one carriage on a ball screw, two files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import yaml

from sim_backend.model import shipped_model_path
from tests.rigs.data import data_folder
from tests.rigs.rig import Rig, write_log, write_model

AXIS = "carriage"
FILES = ("DATA_EMPS", "DATA_EMPS_PULSES")
#: samples of one lap of the reference
LAP = 6240


def emps_signals(name: str = "DATA_EMPS") -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time (s), position (m), commanded force (N) and position reference (m) of a file."""
    from scipy.io import loadmat

    data = loadmat(data_folder("emps") / f"{name}.mat")
    time, position, volts, reference = (data[key].ravel().astype(np.float64) for key in ("t", "qm", "vir", "qg"))
    return time, position, volts * float(data["gtau"].item()), reference


def write_emps(folder: Path, scaled: Mapping[str, float] | None = None) -> Rig:
    """Both files (keys as in `FILES`) and the model that is shipped, or one with numbers scaled (`{"body.mass":
    0.5}`).
    """
    folder.mkdir(parents=True, exist_ok=True)
    logs = {}
    for name in FILES:
        time, position, force, reference = emps_signals(name)
        columns = {
            "time_s": time,
            f"{AXIS}.torque": force,
            f"{AXIS}.position": position,
            f"{AXIS}.position_ref": reference,
        }
        logs[name] = write_log(folder / f"{name}.csv", columns)
    document = yaml.safe_load(shipped_model_path("emps").read_text())
    return Rig(write_model(folder / "emps.yaml", document, scaled), logs)
