"""Torque actuator: from the commanded torque to the torque at the joint."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.layout import GAIN_ERROR, LAG_DECAY, LAG_MEAN, LIMIT, OFFSET


@compiled
def actuate(P: np.ndarray, block: int, lagged: float, command: float) -> tuple[float, float]:
    """Torque (N m) for a command (N m) held over this step: gain and offset, first-order lag (exact mean over the
    step), limit.

    `lagged` is the lag's state before the step; answers the torque and the state after it.
    """
    torque = (1.0 + P[block + GAIN_ERROR]) * command + P[block + OFFSET]
    if P[block + LAG_DECAY] > 0.0:
        behind = lagged - torque
        lagged = torque + behind * P[block + LAG_DECAY]
        torque += behind * P[block + LAG_MEAN]
    limit = P[block + LIMIT]
    if limit > 0.0:
        torque = min(max(torque, -limit), limit)
    return torque, lagged
