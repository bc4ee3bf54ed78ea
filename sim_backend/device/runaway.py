"""The drive's own guard against a motor that does not do as it is told: momentum that an axis gains against the impulse
of its torque.

It knows the heaviest that the antenna can pull on any base, and no more: a coarse guard behind the host's, for a motor
that turns the wrong way at full torque. The gyro is its sensor, because torque makes inertial acceleration whatever the
base does.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.layout import (
    APPLIED_TORQUE,
    AXIS_J,
    AXIS_J_SIZE,
    BRAKE_STATE,
    EFFORT,
    GYRO,
    IMPULSE_OF_RATE,
    MOMENTUM,
    MOMENTUM_KEPT,
    PEAK_TORQUE,
    RAN_AWAY,
    SCALE_BITS,
    SET_ENABLE,
    SHORTED,
    STATE,
    STRANGE_IMPULSE,
)

#: ticks that a torque may act late
_LATE_TICKS = 3


@compiled
def watch_momentum(J: np.ndarray, j: int, gyro_before: int) -> None:
    """Take in the sample just taken; the verdict stays until the drive is without power."""
    state = J[STATE]
    running = state == m.DRIVE_STATE_OPERATION_ENABLED and J[j + SET_ENABLE] == 1
    stopping = state == m.DRIVE_STATE_QUICK_STOP_ACTIVE or state == m.DRIVE_STATE_FAULT_REACTION_ACTIVE
    if not running and not stopping:
        J[j + RAN_AWAY] = 0
    # what a shorted winding and a brake do to the axis is not the torque's
    free = J[j + SHORTED] == 0 and J[j + BRAKE_STATE] != m.BRAKE_STATE_ENGAGED
    if J[j + STRANGE_IMPULSE] == 0 or not (running or stopping) or not free:
        J[j + MOMENTUM] = J[j + EFFORT] = J[j + PEAK_TORQUE] = 0
        return
    torque, kept = J[j + APPLIED_TORQUE], J[MOMENTUM_KEPT]
    gained = (J[j + GYRO] - gyro_before) * J[j + IMPULSE_OF_RATE] - (torque << SCALE_BITS)
    J[j + MOMENTUM] = (J[j + MOMENTUM] * kept >> SCALE_BITS) + gained
    J[j + EFFORT] = (J[j + EFFORT] * kept >> SCALE_BITS) + (abs(torque) << SCALE_BITS)
    J[j + PEAK_TORQUE] = max(J[j + PEAK_TORQUE] * kept >> SCALE_BITS, abs(torque))
    allowed = J[j + STRANGE_IMPULSE] + (J[j + EFFORT] >> 1) + _LATE_TICKS * (J[j + PEAK_TORQUE] << SCALE_BITS)
    if abs(J[j + MOMENTUM]) > allowed:
        J[j + RAN_AWAY] = 1


@compiled
def runs_away(J: np.ndarray, axis: int) -> bool:
    """Whether an axis moved as its torque cannot have moved it since the drive got power."""
    return bool(J[AXIS_J + axis * AXIS_J_SIZE + RAN_AWAY] == 1)
