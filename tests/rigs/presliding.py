"""A joint that never slides: torque below break-away moves it on its bristles alone (Canudas de Wit's LuGre, stepped
here by itself), and the logs and the first models of a stranger.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numba import njit

from tests.rigs.rig import Rig, measured, write_log, write_model

AXIS = "joint"
RATE_HZ, LOG_S, SUBSTEPS = 500.0, 30.0, 40
INERTIA, COULOMB, BREAKAWAY, STRIBECK_RAD_S, VISCOUS = 0.01, 0.5, 0.7, 0.01, 0.05
SIGMA0, SIGMA1 = 500.0, 2.0
STEP = 2.0 * np.pi / 2**22


@njit
def _positions(torque: np.ndarray, period: float) -> np.ndarray:
    out, q, v, z = np.zeros(len(torque)), 0.0, 0.0, 0.0
    step = period / SUBSTEPS
    for k in range(len(torque)):
        out[k] = q
        for _ in range(SUBSTEPS):
            level = COULOMB + (BREAKAWAY - COULOMB) * np.exp(-((v / STRIBECK_RAD_S) ** 2))
            rate = v - SIGMA0 * abs(v) / level * z
            v += step * (torque[k] - SIGMA0 * z - SIGMA1 * rate - VISCOUS * v) / INERTIA
            q += step * v
            z += step * rate
    return out


def log(seed: int) -> dict[str, np.ndarray]:
    """Columns of a log: slow ramps between random levels, two thirds of break-away at most."""
    dice = np.random.default_rng(seed)
    time = np.arange(int(LOG_S * RATE_HZ)) / RATE_HZ
    ends = np.arange(0.0, LOG_S + 2.0, 2.0)
    levels = np.append(0.0, 0.45 * dice.uniform(-1.0, 1.0, len(ends) - 1))
    torque = np.interp(time, ends, levels)
    position = np.round(_positions(torque, 1.0 / RATE_HZ) / STEP) * STEP
    return {"time_s": time, f"{AXIS}.torque": torque, f"{AXIS}.position": position}


def write_presliding(folder: Path, factors: Mapping[str, float], bristle: bool = True) -> Rig:
    """Two logs, and a model with numbers off by these factors, with its bristle or without one."""

    friction = {
        "coulomb": measured(COULOMB, "N m", "5%"),
        "breakaway": measured(BREAKAWAY if bristle else COULOMB, "N m", "5%"),
        "viscous": measured(VISCOUS, "N m s/rad", "20%"),
    }
    if bristle:
        friction["stribeck_velocity"] = measured(STRIBECK_RAD_S, "rad/s", "20%")
        friction["sigma0"] = measured(SIGMA0, "N m/rad", "5%")
        friction["sigma1"] = measured(SIGMA1, "N m s/rad", "20%")
    axis = {
        "body": {"mass": measured(1.0, "kg", "5%"), "inertia": {"zz": measured(INERTIA, "kg m2", "5%")}},
        "friction": friction,
        "encoder": {"step": {"value": STEP, "unit": "rad", "source": "printed"}},
    }
    document = {"schema": 1, "name": "presliding", "kind": "rotary", "incline_sine": 1.0, "axes": {AXIS: axis}}
    folder.mkdir(parents=True, exist_ok=True)
    logs = {name: write_log(folder / f"{name}.csv", log(seed)) for seed, name in ((1, "first"), (2, "second"))}
    return Rig(write_model(folder / "model.yaml", document, factors), logs)
