"""The drive's guards: what makes a fault at this tick, and what the limits leave of a torque."""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.layout import (
    AXIS_J,
    AXIS_J_SIZE,
    CONTROL_AGE,
    CONTROL_SILENCE_TICKS,
    ENCODER,
    GYRO,
    JOINT_RATE,
    LIMITS,
    MARGIN,
    MAX_DISAGREEMENT,
    MAX_WINDING,
    MIN_SUPPLY,
    OVERSPEED,
    RATE_LIMIT,
    SENSOR_FAULT,
    STATE,
    SUPPLY,
    TORQUE_LIMIT,
    TRAVEL_CLEARED,
    TRAVEL_HIGH,
    TRAVEL_LOW,
    TRAVEL_REACTION,
    WINDING,
)
from sim_backend.device.runaway import runs_away
from sim_backend.device.settings import TravelReaction
from sim_backend.layout import AXES

_FAULT_BEYOND_TRAVEL = int(TravelReaction.FAULT)


@compiled
def has_power(state: int) -> bool:
    """Whether torque may be applied on the host's or the quick stop's behalf."""
    return bool(state == m.DRIVE_STATE_OPERATION_ENABLED or state == m.DRIVE_STATE_QUICK_STOP_ACTIVE)


@compiled
def find_fault(K: np.ndarray, J: np.ndarray) -> tuple[int, int]:
    """FaultCode that holds now, and the axis it is about; sensors and temperature count in every state, the rest with
    power on.
    """
    fault, about = _fault_of_hardware(K, J)
    if fault != m.FAULT_CODE_NONE or not has_power(J[STATE]):
        return fault, about
    for axis in range(K[AXES]):
        j = AXIS_J + axis * AXIS_J_SIZE
        if max(abs(J[j + JOINT_RATE]), abs(J[j + GYRO])) > J[j + OVERSPEED]:
            return m.FAULT_CODE_OVERSPEED, axis
    for axis in range(K[AXES]):
        if disagreement(J, axis) > J[MAX_DISAGREEMENT]:
            return m.FAULT_CODE_SENSORS_DISAGREE, axis
    for axis in range(K[AXES]):
        if runs_away(J, axis):
            return m.FAULT_CODE_RUNAWAY, axis
    for axis in range(K[AXES]):
        if (
            J[TRAVEL_REACTION] == _FAULT_BEYOND_TRAVEL
            and J[TRAVEL_CLEARED] == 0
            and _beyond_travel(J, AXIS_J + axis * AXIS_J_SIZE) != 0
        ):
            return m.FAULT_CODE_TRAVEL_LIMIT, axis
    if J[MARGIN] == 0:
        return m.FAULT_CODE_DEADMAN, 0
    if J[CONTROL_SILENCE_TICKS] > 0 and J[CONTROL_AGE] > J[CONTROL_SILENCE_TICKS]:
        return m.FAULT_CODE_COMMUNICATION, 0
    return m.FAULT_CODE_NONE, 0


@compiled
def disagreement(J: np.ndarray, axis: int) -> int:
    """By how much encoder and gyro differ on an axis' rate, raw; the gyro sees the base turn too."""
    j = AXIS_J + axis * AXIS_J_SIZE
    return int(abs(J[j + JOINT_RATE] - J[j + GYRO]))


@compiled
def supply_serves(K: np.ndarray, J: np.ndarray) -> bool:
    """Whether a stop may use torque: not without supply or with a hot winding."""
    return bool(_fault_of_power(K, J)[0] == m.FAULT_CODE_NONE)


@compiled
def _fault_of_hardware(K: np.ndarray, J: np.ndarray) -> tuple[int, int]:
    for axis in range(K[AXES]):
        fault = J[AXIS_J + axis * AXIS_J_SIZE + SENSOR_FAULT]
        if fault != m.FAULT_CODE_NONE:
            return fault, axis
    return _fault_of_power(K, J)


@compiled
def _fault_of_power(K: np.ndarray, J: np.ndarray) -> tuple[int, int]:
    for axis in range(K[AXES]):
        j = AXIS_J + axis * AXIS_J_SIZE
        if J[j + WINDING] > J[j + MAX_WINDING]:
            return m.FAULT_CODE_OVERTEMPERATURE, axis
    # below SWITCHED_ON the power stage needs no supply
    if J[SUPPLY] < J[MIN_SUPPLY] and J[STATE] >= m.DRIVE_STATE_SWITCHED_ON:
        return m.FAULT_CODE_UNDERVOLTAGE, 0
    return m.FAULT_CODE_NONE, 0


@compiled
def _beyond_travel(J: np.ndarray, j: int) -> int:
    """1 beyond the upper travel limit, -1 beyond the lower one, 0 between them."""
    if J[j + ENCODER] >= J[j + TRAVEL_HIGH]:
        return 1
    return -1 if J[j + ENCODER] <= J[j + TRAVEL_LOW] else 0


@compiled
def beyond_any_travel(K: np.ndarray, J: np.ndarray) -> bool:
    """Whether an axis is beyond a travel limit."""
    beyond = False
    for axis in range(K[AXES]):
        beyond = beyond or _beyond_travel(J, AXIS_J + axis * AXIS_J_SIZE) != 0
    return beyond


@compiled
def within_torque_limit(J: np.ndarray, axis: int, torque: int) -> int:
    """Raw torque held within the axis' limit; says so in the limit flags."""
    limit = J[AXIS_J + axis * AXIS_J_SIZE + TORQUE_LIMIT]
    held = min(max(torque, -limit), limit)
    if held != torque:
        J[LIMITS] |= m.LIMIT_FLAGS_OUTER_TORQUE << axis
    return held


@compiled
def without_outward(J: np.ndarray, axis: int, torque: int) -> int:
    """Zero in place of a torque that leads further out of travel, or that drives on an axis that is too fast."""
    j = AXIS_J + axis * AXIS_J_SIZE
    side = _beyond_travel(J, j)
    if side * torque > 0:
        return 0
    too_fast = abs(J[j + JOINT_RATE]) > J[j + RATE_LIMIT]
    return 0 if too_fast and (torque > 0) == (J[j + JOINT_RATE] > 0) else torque


@compiled
def flag_travel_and_rate(K: np.ndarray, J: np.ndarray) -> None:
    """Add the flags of travel and rate limits as of the sample just taken."""
    for axis in range(K[AXES]):
        j = AXIS_J + axis * AXIS_J_SIZE
        side = _beyond_travel(J, j)
        if side != 0:
            J[LIMITS] |= (m.LIMIT_FLAGS_OUTER_TRAVEL_HIGH if side > 0 else m.LIMIT_FLAGS_OUTER_TRAVEL_LOW) << (2 * axis)
        if abs(J[j + JOINT_RATE]) > J[j + RATE_LIMIT]:
            J[LIMITS] |= m.LIMIT_FLAGS_OUTER_RATE << axis
