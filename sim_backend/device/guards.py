"""The drive's guards: what makes a fault at this tick, and what the limits leave of a torque."""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.records import Drive, Joint
from sim_backend.device.runaway import runs_away
from sim_backend.device.settings import TravelReaction
from sim_backend.layout import AXES

_FAULT_BEYOND_TRAVEL = int(TravelReaction.FAULT)


@compiled
def has_power(state: int) -> bool:
    """Whether torque may be applied on the host's or the quick stop's behalf."""
    return bool(state == m.DRIVE_STATE_OPERATION_ENABLED or state == m.DRIVE_STATE_QUICK_STOP_ACTIVE)


@compiled
def find_fault(K: np.ndarray, drive: Drive) -> tuple[int, int]:
    """FaultCode that holds now, and the axis it is about; sensors and temperature count in every state, the rest with
    power on.
    """
    fault, about = _fault_of_hardware(K, drive)
    if fault != m.FAULT_CODE_NONE or not has_power(drive.state):
        return fault, about
    for axis in range(K[AXES]):
        joint = drive.joints[axis]
        if max(abs(joint.joint_rate), abs(joint.gyro)) > joint.overspeed:
            return m.FAULT_CODE_OVERSPEED, axis
    for axis in range(K[AXES]):
        if disagreement(drive, axis) > drive.max_disagreement:
            return m.FAULT_CODE_SENSORS_DISAGREE, axis
    for axis in range(K[AXES]):
        if runs_away(drive, axis):
            return m.FAULT_CODE_RUNAWAY, axis
    for axis in range(K[AXES]):
        if (
            drive.travel_reaction == _FAULT_BEYOND_TRAVEL
            and drive.travel_cleared == 0
            and _beyond_travel(drive.joints[axis]) != 0
        ):
            return m.FAULT_CODE_TRAVEL_LIMIT, axis
    if drive.margin == 0:
        return m.FAULT_CODE_DEADMAN, 0
    if drive.control_silence_ticks > 0 and drive.control_age > drive.control_silence_ticks:
        return m.FAULT_CODE_COMMUNICATION, 0
    return m.FAULT_CODE_NONE, 0


@compiled
def disagreement(drive: Drive, axis: int) -> int:
    """By how much encoder and gyro differ on an axis' rate, raw; the gyro sees the base turn too."""
    joint = drive.joints[axis]
    return int(abs(joint.joint_rate - joint.gyro))


@compiled
def supply_serves(K: np.ndarray, drive: Drive) -> bool:
    """Whether a stop may use torque: not without supply or with a hot winding."""
    return bool(_fault_of_power(K, drive)[0] == m.FAULT_CODE_NONE)


@compiled
def _fault_of_hardware(K: np.ndarray, drive: Drive) -> tuple[int, int]:
    for axis in range(K[AXES]):
        fault = drive.joints[axis].sensor_fault
        if fault != m.FAULT_CODE_NONE:
            return fault, axis
    return _fault_of_power(K, drive)


@compiled
def _fault_of_power(K: np.ndarray, drive: Drive) -> tuple[int, int]:
    for axis in range(K[AXES]):
        joint = drive.joints[axis]
        if joint.winding > joint.max_winding:
            return m.FAULT_CODE_OVERTEMPERATURE, axis
    # below SWITCHED_ON the power stage needs no supply
    if drive.supply < drive.min_supply and drive.state >= m.DRIVE_STATE_SWITCHED_ON:
        return m.FAULT_CODE_UNDERVOLTAGE, 0
    return m.FAULT_CODE_NONE, 0


@compiled
def _beyond_travel(joint: Joint) -> int:
    """1 beyond the upper travel limit, -1 beyond the lower one, 0 between them."""
    if joint.encoder >= joint.travel_high:
        return 1
    return -1 if joint.encoder <= joint.travel_low else 0


@compiled
def beyond_any_travel(K: np.ndarray, drive: Drive) -> bool:
    """Whether an axis is beyond a travel limit."""
    beyond = False
    for axis in range(K[AXES]):
        beyond = beyond or _beyond_travel(drive.joints[axis]) != 0
    return beyond


@compiled
def within_torque_limit(drive: Drive, axis: int, torque: int) -> int:
    """Raw torque held within the axis' limit; says so in the limit flags."""
    limit = drive.joints[axis].torque_limit
    held = min(max(torque, -limit), limit)
    if held != torque:
        drive.limits |= m.LIMIT_FLAGS_OUTER_TORQUE << axis
    return held


@compiled
def without_outward(drive: Drive, axis: int, torque: int) -> int:
    """Zero in place of a torque that leads further out of travel, or that drives on an axis that is too fast."""
    joint = drive.joints[axis]
    side = _beyond_travel(joint)
    if side * torque > 0:
        return 0
    too_fast = abs(joint.joint_rate) > joint.rate_limit
    return 0 if too_fast and (torque > 0) == (joint.joint_rate > 0) else torque


@compiled
def flag_travel_and_rate(K: np.ndarray, drive: Drive) -> None:
    """Add the flags of travel and rate limits as of the sample just taken."""
    for axis in range(K[AXES]):
        joint = drive.joints[axis]
        side = _beyond_travel(joint)
        if side != 0:
            beyond = m.LIMIT_FLAGS_OUTER_TRAVEL_HIGH if side > 0 else m.LIMIT_FLAGS_OUTER_TRAVEL_LOW
            drive.limits |= beyond << (2 * axis)
        if abs(joint.joint_rate) > joint.rate_limit:
            drive.limits |= m.LIMIT_FLAGS_OUTER_RATE << axis
