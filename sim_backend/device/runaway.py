"""The drive's own guard against a motor that does not do as it is told: momentum that an axis gains against the impulse
of its torque.

It knows the heaviest that the antenna can pull on any base, and no more: a coarse guard behind the host's, for a motor
that turns the wrong way at full torque. The gyro is its sensor, because torque makes inertial acceleration whatever the
base does.
"""

from __future__ import annotations

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.records import SCALE_BITS, Drive, Joint

#: ticks that a torque may act late
_LATE_TICKS = 3


@compiled
def watch_momentum(drive: Drive, joint: Joint, gyro_before: int) -> None:
    """Take in the sample just taken; the verdict stays until the drive is without power."""
    state = drive.state
    running = state == m.DRIVE_STATE_OPERATION_ENABLED and joint.set_enable == 1
    stopping = state == m.DRIVE_STATE_QUICK_STOP_ACTIVE or state == m.DRIVE_STATE_FAULT_REACTION_ACTIVE
    if not running and not stopping:
        joint.ran_away = 0
    # what a shorted winding and a brake do to the axis is not the torque's
    free = joint.shorted == 0 and joint.brake_state != m.BRAKE_STATE_ENGAGED
    if joint.strange_impulse == 0 or not (running or stopping) or not free:
        joint.momentum = joint.effort = joint.peak_torque = 0
        return
    torque, kept = joint.applied_torque, drive.momentum_kept
    gained = (joint.gyro - gyro_before) * joint.impulse_of_rate - (torque << SCALE_BITS)
    joint.momentum = (joint.momentum * kept >> SCALE_BITS) + gained
    joint.effort = (joint.effort * kept >> SCALE_BITS) + (abs(torque) << SCALE_BITS)
    joint.peak_torque = max(joint.peak_torque * kept >> SCALE_BITS, abs(torque))
    allowed = joint.strange_impulse + (joint.effort >> 1) + _LATE_TICKS * (joint.peak_torque << SCALE_BITS)
    if abs(joint.momentum) > allowed:
        joint.ran_away = 1


@compiled
def runs_away(drive: Drive, axis: int) -> bool:
    """Whether an axis moved as its torque cannot have moved it since the drive got power."""
    return bool(drive.joints[axis].ran_away == 1)
