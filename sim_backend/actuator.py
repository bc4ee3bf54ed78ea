"""Torque actuator: from the commanded torque to the torque at the joint."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.layout import GAIN_ERROR, LAG_DECAY, LAG_MEAN, LAGGED, LIMIT, OFFSET


@compiled
def actuate(P: np.ndarray, block: int, X: np.ndarray, axis: int, command: float) -> float:
    """Torque (N m) for a command (N m) held over this step: gain and offset, first-order lag (exact mean over the step), limit."""
    torque = (1.0 + P[block + GAIN_ERROR]) * command + P[block + OFFSET]
    if P[block + LAG_DECAY] > 0.0:
        behind = X[LAGGED + axis] - torque
        X[LAGGED + axis] = torque + behind * P[block + LAG_DECAY]
        torque += behind * P[block + LAG_MEAN]
    limit = P[block + LIMIT]
    if limit > 0.0:
        torque = min(max(torque, -limit), limit)
    return torque
