"""Readers of the measured data sets that lie beside the project; what they are is in their SOURCE.md."""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.identification import Plateau, PreslidingRun, find_steady_window
from gimbal_hil.knowledge.identification.axis_motion import centred_torque
from tests.rigs.data import data_folder
from tests.rigs.dd2dof import GRAVITY, INERTIA, arm_signals, sliding_rows
from tests.rigs.emps import emps_signals


def dd2dof_plateaus(fastest_deg_s: float = 100.0) -> list[Plateau]:
    """Constant-speed runs up to the row where the axis stops or turns back, each run once (some files are copies of
    others).
    """
    plateaus, seen = [], set()
    for file in sorted((data_folder("dd2dof") / "test_2").glob("cin_pos1_*.t")):
        time, position, torque = arm_signals(file)
        key = position.tobytes()
        digits = file.name.split("pos1_")[1].split("_exp")[0].lstrip("n")
        commanded = float(digits) / 10.0 if digits.startswith("0") else float(digits)
        if key in seen or commanded > fastest_deg_s:
            continue
        seen.add(key)
        stop = sliding_rows(position)
        friction = centred_torque(torque) - GRAVITY * np.sin(position)
        plateaus.append(Plateau(file.name, time[:stop], position[:stop], friction[:stop], INERTIA))
    return plateaus


def dd2dof_gravity(fastest_deg_s: float = 65.0) -> tuple[float, float]:
    """Gravity torque amplitude (N m) and its standard error as the sliding runs themselves say it: each run has a level
    of its own.
    """
    columns, torques = [], []
    for plateau in dd2dof_plateaus(fastest_deg_s):
        window = find_steady_window(plateau.time_s, plateau.position)
        if window is None or np.ptp(plateau.position[window.start : window.stop]) < 0.1:
            continue
        rows = np.linspace(window.start, window.stop - 1, 200).astype(np.int64)
        angle = plateau.position[rows]
        columns.append(
            np.stack([np.sin(angle), np.cos(angle)]) - np.array([[np.sin(angle).mean()], [np.cos(angle).mean()]])
        )
        torque = plateau.friction[rows] + GRAVITY * np.sin(angle)
        torques.append(torque - torque.mean())
    design, target = np.concatenate(columns, axis=1).T, np.concatenate(torques)
    found = np.linalg.lstsq(design, target, rcond=None)[0]
    # rows of one run are no independent measurements: a run counts as one
    misfit = target - design @ found
    covariance = np.linalg.inv(design.T @ design) * float(misfit @ misfit) / len(torques)
    return float(found[0]), float(np.sqrt(covariance[0, 0]))


def dd2dof_ramps() -> list[PreslidingRun]:
    """Break-away ramps of both signs, up to the largest torque."""
    ramps = []
    for file in sorted((data_folder("dd2dof") / "test_1").glob("est_pos1_*.t")):
        time, position, torque = arm_signals(file)
        stop = int(np.argmax(np.abs(torque) >= np.abs(torque).max() - 1e-9))
        friction = torque - GRAVITY * np.sin(position)
        ramps.append(PreslidingRun(file.name, time[:stop], position[:stop], friction[:stop]))
    return ramps


def dd2dof_presliding() -> list[PreslidingRun]:
    """Slow sinusoidal torque of 6 N m."""
    runs = []
    for file in sorted((data_folder("dd2dof") / "test_3").glob("sig0_pos1_*.t")):
        time, position, torque = arm_signals(file)
        runs.append(PreslidingRun(file.name, time, position, torque - GRAVITY * np.sin(position)))
    return runs


def emps(name: str = "DATA_EMPS") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (s), position (m) and commanded force (N) of the EMPS axis."""
    return emps_signals(name)[:3]


def dd2dof_validation() -> tuple[np.ndarray, np.ndarray]:
    """Time (s) and measured position (rad) of the open-loop run under 20 sin(2 pi 0.1 t) N m; the second axis moved
    too.
    """
    rows = np.loadtxt(data_folder("dd2dof") / "comparacion" / "pos1_20_exp2_gan.t")
    return rows[:, 0], np.deg2rad(rows[:, 1])
