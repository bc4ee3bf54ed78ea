"""What holds an axis without torque from the current loop: its shorted winding and its holding brake."""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.records import Drive, Joint
from sim_backend.device.stopping import stop_in_force, stops_by_itself
from sim_backend.layout import AXES, HELD, HELD_AT, POSITION, HeldBy

_SHORTED, _BRAKED = int(HeldBy.SHORTED_WINDING), int(HeldBy.HOLDING_BRAKE)


@compiled
def take_brake_commands(mail: np.ndarray, drive: Drive) -> None:
    """What the host asks of the holding brakes."""
    if mail[m.DRIVE_CONTROL] > 0:
        drive.joints[0].brake_command, drive.joints[1].brake_command = (
            mail[m.DRIVE_CONTROL_BRAKE_OUTER],
            mail[m.DRIVE_CONTROL_BRAKE_INNER],
        )


@compiled
def hold_axes(K: np.ndarray, X: np.ndarray, drive: Drive) -> None:
    """Short the windings and close or open the brakes for this tick: a brake opens at once and takes BRAKE_TICKS to
    close.
    """
    stop = stop_in_force(K, drive)
    # without power the winding is shorted, because nothing else slows an axis that has no brake; one that was told to
    # coast coasts
    stopped = stops_by_itself(drive) or drive.state == m.DRIVE_STATE_FAULT
    shorted = stop == m.STOP_REACTION_BRAKE if stopped else drive.state != m.DRIVE_STATE_OPERATION_ENABLED
    for axis in range(K[AXES]):
        joint = drive.joints[axis]
        joint.shorted = 1 if shorted else 0
        held = _SHORTED if joint.shorted == 1 else 0
        if joint.has_brake == 1:
            if not _wants_brake(drive, joint, stop):
                joint.brake_state, joint.brake_age = m.BRAKE_STATE_RELEASED, 0
            elif joint.brake_age < drive.brake_ticks:
                joint.brake_age += 1
            elif joint.brake_state != m.BRAKE_STATE_ENGAGED:
                joint.brake_state = m.BRAKE_STATE_ENGAGED
                X[HELD_AT + axis] = X[POSITION + axis]
            if joint.brake_state == m.BRAKE_STATE_ENGAGED:
                held |= _BRAKED
        X[HELD + axis] = held


@compiled
def _wants_brake(drive: Drive, joint: Joint, stop: int) -> bool:
    """Whether an axis' brake is to be closed: by command, or by itself whenever nothing else holds the antenna."""
    if joint.brake_command != m.BRAKE_COMMAND_AUTOMATIC:
        return bool(joint.brake_command == m.BRAKE_COMMAND_ENGAGE)
    if drive.state == m.DRIVE_STATE_OPERATION_ENABLED:
        # an axis that a plan leaves free beside one under torque may swing
        return bool(drive.joints[0].set_enable == 0 and drive.joints[1].set_enable == 0)
    if stops_by_itself(drive) and (stop == m.STOP_REACTION_DECELERATE_AND_HOLD or stop == m.STOP_REACTION_GYRO_STOP):
        # torque stops the axis; the brake closes at rest, while torque still holds it
        return bool(drive.rest_count >= drive.rest_ticks)
    return True
