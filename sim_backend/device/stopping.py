"""How the drive stops by itself: coast, short the motor, or follow a ramp down to rest and hold there."""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.guards import sensors_and_supply_serve
from sim_backend.device.layout import (
    ACTIVE_REACTION,
    AXIS_J,
    AXIS_J_SIZE,
    BRAKE_GAIN,
    COUNT_OF_RATE,
    ENCODER,
    HOLD_TICKS,
    JOINT_RATE,
    REACTION_TICKS,
    REST_COUNT,
    REST_RATE,
    REST_TICKS,
    SCALE_BITS,
    STATE_AGE,
    STOP_INTEGRAL,
    STOP_INTEGRAL_GAIN,
    STOP_POSITION,
    STOP_POSITION_GAIN,
    STOP_RATE,
    STOP_RATE_GAIN,
    STOP_RATE_PER_TICK,
    TORQUE_LIMIT,
)
from sim_backend.layout import AXES

_COAST, _BRAKE, _HOLD = m.DEADMAN_REACTION_COAST, m.DEADMAN_REACTION_BRAKE, m.DEADMAN_REACTION_DECELERATE_AND_HOLD


@compiled
def begin_stop(K: np.ndarray, J: np.ndarray) -> None:
    """Take the motion as it is for the start of the ramp."""
    J[REST_COUNT] = 0
    for axis in range(K[AXES]):
        j = AXIS_J + axis * AXIS_J_SIZE
        J[j + STOP_RATE], J[j + STOP_POSITION], J[j + STOP_INTEGRAL] = J[j + JOINT_RATE], J[j + ENCODER] << SCALE_BITS, 0


@compiled
def ramp_torque(J: np.ndarray, axis: int) -> int:
    """Raw torque that keeps an axis on a ramp to rest and then where it came to rest; PID with the integral held at the torque limit."""
    j = AXIS_J + axis * AXIS_J_SIZE
    rate, step = J[j + STOP_RATE], J[j + STOP_RATE_PER_TICK]
    rate = max(rate - step, 0) if rate > 0 else min(rate + step, 0)
    J[j + STOP_RATE] = rate
    J[j + STOP_POSITION] += rate * J[COUNT_OF_RATE]
    error = (J[j + STOP_POSITION] >> SCALE_BITS) - J[j + ENCODER]
    most = J[j + TORQUE_LIMIT] << SCALE_BITS
    J[j + STOP_INTEGRAL] = min(max(J[j + STOP_INTEGRAL] + error * J[j + STOP_INTEGRAL_GAIN], -most), most)
    fraction = J[j + STOP_RATE_GAIN] * (rate - J[j + JOINT_RATE]) + J[j + STOP_POSITION_GAIN] * error + J[j + STOP_INTEGRAL]
    return int(fraction >> SCALE_BITS)


@compiled
def brake_torque(J: np.ndarray, axis: int) -> int:
    """Raw torque of a shorted motor: against the joint rate, in proportion to it."""
    j = AXIS_J + axis * AXIS_J_SIZE
    return int(-(J[j + BRAKE_GAIN] * J[j + JOINT_RATE] >> SCALE_BITS))


@compiled
def reaction_torque(K: np.ndarray, J: np.ndarray, axis: int) -> int:
    """Raw torque of the fault reaction in force."""
    reaction = J[ACTIVE_REACTION]
    if reaction == _COAST:
        return 0
    if reaction == _BRAKE or not sensors_and_supply_serve(K, J):
        return brake_torque(J, axis)
    return ramp_torque(J, axis)


@compiled
def count_rest(K: np.ndarray, J: np.ndarray) -> None:
    """Count the ticks in a row in which every axis was at rest."""
    for axis in range(K[AXES]):
        if abs(J[AXIS_J + axis * AXIS_J_SIZE + JOINT_RATE]) > J[REST_RATE]:
            J[REST_COUNT] = 0
            return
    J[REST_COUNT] += 1


@compiled
def reaction_over(J: np.ndarray) -> bool:
    """Whether the fault reaction has done what it can: at rest, held for its time, or out of time."""
    if J[ACTIVE_REACTION] == _COAST:
        return True
    hold = J[HOLD_TICKS] if J[ACTIVE_REACTION] == _HOLD else 0
    return bool(J[REST_COUNT] >= J[REST_TICKS] + hold or J[STATE_AGE] >= J[REACTION_TICKS] + hold)
