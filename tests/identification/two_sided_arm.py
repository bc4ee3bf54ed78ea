"""A hanging arm whose friction differs between directions, in open loop: what a published direct-drive model is
compared in.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import entry_point
from gimbal_hil.knowledge.identification import LugreFriction


@entry_point
def _swing(
    torque: np.ndarray,
    step_s: float,
    steps: int,
    arm: np.ndarray,
    forward: np.ndarray,
    backward: np.ndarray,
    out: np.ndarray,
) -> None:
    q, v, z = arm[2], 0.0, 0.0
    h = step_s / steps
    for k in range(torque.shape[0]):
        out[k] = q
        for _ in range(steps):
            f = forward if v >= 0.0 else backward
            level = f[1] + (f[0] - f[1]) * math.exp(-min((abs(v) / f[2]) ** f[4], 50.0))
            relaxation = f[5] * abs(v) / level * h
            settled = level / f[5] * (1.0 if v > 0.0 else -1.0)
            after = settled + (z - settled) * math.exp(-relaxation)
            opposing = 0.5 * f[5] * (z + after) + f[6] * (after - z) / h + f[3] * v
            z = after
            v += h * (torque[k] - arm[1] * math.sin(q) - opposing) / arm[0]
            q += h * v


def swing(
    torque: np.ndarray,
    step_s: float,
    inertia: float,
    gravity: float,
    start: float,
    forward: LugreFriction,
    backward: LugreFriction,
) -> np.ndarray:
    """Positions (n,), rad, from rest under held torque (n,): `inertia q'' = torque - gravity sin(q) - friction of the
    direction`.
    """
    out = np.zeros(len(torque))
    steps = max(1, int(round(step_s / 3e-4)))
    _swing(torque, step_s, steps, np.array([inertia, gravity, start]), forward.values(), backward.values(), out)
    return out
