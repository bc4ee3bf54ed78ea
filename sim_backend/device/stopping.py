"""How the drive stops by itself: coast, short the winding, torque against the gyro's rate, or a ramp down to rest where
it then holds.

Only the last two need a sensor, one each: a stop is chosen so that it never uses the sensor that is suspected.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.guards import disagreement, supply_serves
from sim_backend.device.layout import (
    ACTIVE_REACTION,
    AXIS_J,
    AXIS_J_SIZE,
    COUNT_OF_RATE,
    ENCODER,
    GYRO,
    HOLD_TICKS,
    JOINT_RATE,
    REACTION_TICKS,
    REST_COUNT,
    REST_RATE,
    REST_TICKS,
    SCALE_BITS,
    SENSOR_FAULT,
    STATE,
    STATE_AGE,
    STOP_DISAGREEMENT,
    STOP_INTEGRAL,
    STOP_INTEGRAL_GAIN,
    STOP_POSITION,
    STOP_POSITION_GAIN,
    STOP_RATE,
    STOP_RATE_GAIN,
    STOP_RATE_PER_TICK,
    TORQUE_LIMIT,
)
from sim_backend.device.runaway import runs_away
from sim_backend.layout import AXES

_COAST, _BRAKE = m.STOP_REACTION_COAST, m.STOP_REACTION_BRAKE
_HOLD, _BY_GYRO = m.STOP_REACTION_DECELERATE_AND_HOLD, m.STOP_REACTION_GYRO_STOP


@compiled
def begin_stop(K: np.ndarray, J: np.ndarray) -> None:
    """Take the motion as it is for the start of the ramp."""
    J[REST_COUNT] = 0
    for axis in range(K[AXES]):
        j = AXIS_J + axis * AXIS_J_SIZE
        J[j + STOP_RATE], J[j + STOP_POSITION], J[j + STOP_INTEGRAL] = (
            J[j + JOINT_RATE],
            J[j + ENCODER] << SCALE_BITS,
            0,
        )


@compiled
def ramp_torque(J: np.ndarray, axis: int) -> int:
    """Raw torque that keeps an axis on a ramp to rest and then where it came to rest; PID with the integral held at the
    torque limit.
    """
    j = AXIS_J + axis * AXIS_J_SIZE
    rate, step = J[j + STOP_RATE], J[j + STOP_RATE_PER_TICK]
    rate = max(rate - step, 0) if rate > 0 else min(rate + step, 0)
    J[j + STOP_RATE] = rate
    J[j + STOP_POSITION] += rate * J[COUNT_OF_RATE]
    error = (J[j + STOP_POSITION] >> SCALE_BITS) - J[j + ENCODER]
    most = J[j + TORQUE_LIMIT] << SCALE_BITS
    J[j + STOP_INTEGRAL] = min(max(J[j + STOP_INTEGRAL] + error * J[j + STOP_INTEGRAL_GAIN], -most), most)
    fraction = (
        J[j + STOP_RATE_GAIN] * (rate - J[j + JOINT_RATE]) + J[j + STOP_POSITION_GAIN] * error + J[j + STOP_INTEGRAL]
    )
    return int(fraction >> SCALE_BITS)


@compiled
def gyro_torque(J: np.ndarray, axis: int) -> int:
    """Raw torque against the inertial rate that the gyro reads."""
    j = AXIS_J + axis * AXIS_J_SIZE
    return int(-(J[j + STOP_RATE_GAIN] * J[j + GYRO]) >> SCALE_BITS)


@compiled
def stop_in_force(K: np.ndarray, J: np.ndarray) -> int:
    """The stop that acts now: the one chosen while what it needs serves, else the shorted winding, which needs
    nothing.
    """
    reaction = int(J[ACTIVE_REACTION])
    if reaction != _HOLD and reaction != _BY_GYRO:
        return reaction
    if not supply_serves(K, J):
        return _BRAKE
    broken = m.FAULT_CODE_ENCODER if reaction == _HOLD else m.FAULT_CODE_GYRO
    for axis in range(K[AXES]):
        if runs_away(J, axis):
            return _BRAKE
        fault = J[AXIS_J + axis * AXIS_J_SIZE + SENSOR_FAULT]
        if fault == broken or fault == m.FAULT_CODE_INTERNAL or disagreement(J, axis) > J[STOP_DISAGREEMENT]:
            return _BRAKE
    return reaction


@compiled
def stop_torque(K: np.ndarray, J: np.ndarray, axis: int) -> int:
    """Raw torque of the stop in force; a coasting axis and a shorted winding get none."""
    stop = stop_in_force(K, J)
    if stop == _HOLD:
        return ramp_torque(J, axis)
    return gyro_torque(J, axis) if stop == _BY_GYRO else 0


@compiled
def stops_by_itself(J: np.ndarray) -> bool:
    """Whether the drive is stopping: its quick stop or its fault reaction."""
    return bool(J[STATE] == m.DRIVE_STATE_QUICK_STOP_ACTIVE or J[STATE] == m.DRIVE_STATE_FAULT_REACTION_ACTIVE)


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
