"""The row that a tick leaves behind, written by compiled code: first word for word what `gimbal_hil.data.runs.TICK_ROW`
packs, then what was measured, so that lockstep runs need not read their own frames.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control import TORQUE, Mode
from gimbal_hil.loop.host.layout import (
    AXES,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    BASE_ANGLES,
    BASE_RATE,
    LINK_STATUS,
    MEASURED_POSITION,
    MEASURED_RATE,
    MODE,
    MOTOR_TEMPERATURE,
    MOTOR_TORQUE,
    POINTING_STATE,
    REFERENCE,
    SKIPPED,
    SLOPE,
    STATE,
    TICK_SEGMENT,
    TOWARDS,
    TOWARDS_RATES,
)
from gimbal_hil.loop.host.states import PointingState, number

#: 64-bit words of a TICK_ROW; the last two hold wall-clock readings and the check, filled in by others
ROW_WORDS = 12
#: behind it, as float64: position, rate, torque measured, temperature (two axes each), base roll, pitch, yaw, p, q, r
MEASURED = ROW_WORDS
MEASURED_COLUMNS = 14
LOG_WORDS = ROW_WORDS + MEASURED_COLUMNS
_POSITION_REF, _RATE_REF, _TORQUE, _SEGMENT, _STATES = 2, 4, 6, 8, 9
_POSITION, _RATE, _INERTIAL_RATE = number(Mode.POSITION), number(Mode.RATE), number(Mode.INERTIAL_RATE)
_NOT_POINTING = number(PointingState.OFF)
_LOW_HALF = 0xFFFFFFFF


@compiled
def joint_references(H: np.ndarray, G: np.ndarray, axis: int) -> tuple[float, float]:
    """Joint reference of an axis' loop: position (rad) and rate (rad/s), before prefilter and position loop; NaN where
    there is none.
    """
    h = AXIS_H + axis * AXIS_H_SIZE
    mode = G[AXIS_G + axis * AXIS_G_SIZE + MODE]
    if G[POINTING_STATE] != _NOT_POINTING and mode == _POSITION:
        # what looks in the direction, whatever limits, cable and zenith make of it
        return float(H[TOWARDS + axis]), float(H[TOWARDS_RATES + axis])
    if mode == _POSITION:
        return float(H[h + REFERENCE]), float(H[h + SLOPE])
    if mode == _RATE:
        return math.nan, float(H[h + REFERENCE])
    if mode == _INERTIAL_RATE:
        return math.nan, float(H[h + REFERENCE] - H[h + BASE_RATE])
    return math.nan, math.nan


@compiled
def write_row(
    words: np.ndarray, floats: np.ndarray, H: np.ndarray, G: np.ndarray, tick: int, time_ns: int, rejected: int
) -> None:
    """Fill one row; `words` (int64) and `floats` (float64), shape (LOG_WORDS,), are views of the same memory."""
    words[0], words[1] = tick, time_ns
    for axis in range(AXES):
        position, rate = joint_references(H, G, axis)
        floats[_POSITION_REF + axis], floats[_RATE_REF + axis] = position, rate
        floats[_TORQUE + axis] = H[AXIS_H + axis * AXIS_H_SIZE + TORQUE]
    words[_SEGMENT] = (G[TICK_SEGMENT] & _LOW_HALF) | (G[SKIPPED] << 32)
    words[_STATES] = (
        G[STATE]
        | (G[AXIS_G + MODE] << 8)
        | (G[AXIS_G + AXIS_G_SIZE + MODE] << 16)
        | (G[LINK_STATUS] << 24)
        | (rejected << 32)
    )
    words[10] = words[11] = 0
    for axis in range(AXES):
        h = AXIS_H + axis * AXIS_H_SIZE
        floats[MEASURED + axis], floats[MEASURED + 2 + axis] = H[h + MEASURED_POSITION], H[h + MEASURED_RATE]
        floats[MEASURED + 4 + axis], floats[MEASURED + 6 + axis] = H[h + MOTOR_TORQUE], H[h + MOTOR_TEMPERATURE]
    for k in range(6):
        floats[MEASURED + 8 + k] = H[BASE_ANGLES + k]
