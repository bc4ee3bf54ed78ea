"""How the drive stops by itself: coast, short the winding, torque against the gyro's rate, or a ramp down to rest where
it then holds.

Only the last two need a sensor, one each: a stop is chosen so that it never uses the sensor that is suspected.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.guards import disagreement, supply_serves
from sim_backend.device.records import SCALE_BITS, Drive, Joint
from sim_backend.device.runaway import runs_away
from sim_backend.layout import AXES

_COAST, _BRAKE = m.STOP_REACTION_COAST, m.STOP_REACTION_BRAKE
#: most that the ramp's reference may be ahead of the joint, fraction of a count: far beyond what any torque follows
_MOST_LEAD = 1 << 40
#: by how many ticks of its deceleration the ramp may be faster than the joint
_TICKS_AHEAD = 8
_HOLD, _BY_GYRO = m.STOP_REACTION_DECELERATE_AND_HOLD, m.STOP_REACTION_GYRO_STOP


@compiled
def begin_stop(K: np.ndarray, drive: Drive) -> None:
    """Take the motion as it is for the start of the ramp."""
    drive.rest_count = 0
    for axis in range(K[AXES]):
        _take_motion(drive.joints[axis])


@compiled
def _take_motion(joint: Joint) -> None:
    """Where and how fast a ramp begins that acts from this tick on."""
    joint.stop_rate, joint.stop_encoder = joint.joint_rate, joint.encoder
    joint.stop_lead = joint.stop_integral = 0


@compiled
def ramp_torque(drive: Drive, axis: int) -> int:
    """Raw torque that keeps an axis on a ramp to rest and then where it came to rest; PID with the integral held at the
    torque limit. The ramp is never much faster than the joint: a false step of the encoder that it began with, or that
    comes later, is gone from its rate as soon as it is gone from the joint's.
    """
    joint = drive.joints[axis]
    rate, step = joint.stop_rate, joint.stop_rate_per_tick
    if rate > 0:
        rate = max(min(rate - step, max(joint.joint_rate, 0) + _TICKS_AHEAD * step), 0)
    else:
        rate = min(max(rate + step, min(joint.joint_rate, 0) - _TICKS_AHEAD * step), 0)
    joint.stop_rate = rate
    ahead = joint.stop_lead + rate * drive.count_of_rate - ((joint.encoder - joint.stop_encoder) << SCALE_BITS)
    joint.stop_lead, joint.stop_encoder = min(max(ahead, -_MOST_LEAD), _MOST_LEAD), joint.encoder
    error = joint.stop_lead >> SCALE_BITS
    most = joint.torque_limit << SCALE_BITS
    joint.stop_integral = min(max(joint.stop_integral + error * joint.stop_integral_gain, -most), most)
    fraction = joint.stop_rate_gain * (rate - joint.joint_rate) + joint.stop_position_gain * error + joint.stop_integral
    return int(fraction >> SCALE_BITS)


@compiled
def gyro_torque(drive: Drive, axis: int) -> int:
    """Raw torque against the inertial rate that the gyro reads."""
    joint = drive.joints[axis]
    return int(-(joint.stop_rate_gain * joint.gyro) >> SCALE_BITS)


@compiled
def stop_in_force(K: np.ndarray, drive: Drive) -> int:
    """The stop that acts now: the one chosen while what it needs serves, else the shorted winding, which needs
    nothing.
    """
    reaction = int(drive.active_reaction)
    if reaction != _HOLD and reaction != _BY_GYRO:
        return reaction
    if not supply_serves(K, drive):
        return _BRAKE
    broken = m.FAULT_CODE_ENCODER if reaction == _HOLD else m.FAULT_CODE_GYRO
    for axis in range(K[AXES]):
        if runs_away(drive, axis):
            return _BRAKE
        fault = drive.joints[axis].sensor_fault
        if fault == broken or fault == m.FAULT_CODE_INTERNAL or disagreement(drive, axis) > drive.stop_disagreement:
            return _BRAKE
    return reaction


@compiled
def stop_torque(K: np.ndarray, drive: Drive, axis: int) -> int:
    """Raw torque of the stop in force; a coasting axis and a shorted winding get none. A ramp begins when it acts: from
    the motion after a short that stood in for it, not from the one that called for the short.
    """
    stop = stop_in_force(K, drive)
    if stop == _HOLD:
        return ramp_torque(drive, axis)
    _take_motion(drive.joints[axis])
    return gyro_torque(drive, axis) if stop == _BY_GYRO else 0


@compiled
def stops_by_itself(drive: Drive) -> bool:
    """Whether the drive is stopping: its quick stop or its fault reaction."""
    return bool(drive.state == m.DRIVE_STATE_QUICK_STOP_ACTIVE or drive.state == m.DRIVE_STATE_FAULT_REACTION_ACTIVE)


@compiled
def count_rest(K: np.ndarray, drive: Drive) -> None:
    """Count the ticks in a row in which every axis was at rest."""
    for axis in range(K[AXES]):
        if abs(drive.joints[axis].joint_rate) > drive.rest_rate:
            drive.rest_count = 0
            return
    drive.rest_count += 1


@compiled
def reaction_over(drive: Drive) -> bool:
    """Whether the fault reaction has done what it can: at rest, held for its time, or out of time."""
    if drive.active_reaction == _COAST:
        return True
    hold = drive.hold_ticks if drive.active_reaction == _HOLD else 0
    return bool(drive.rest_count >= drive.rest_ticks + hold or drive.state_age >= drive.reaction_ticks + hold)
