"""The device core: one tick of the antenna, firmware and plant, a pure compiled function from mail to mail.

Everything it keeps is in `drive` (firmware, see `records`) and `X` (plant); both may be copied and continued.
"""

from __future__ import annotations

import numpy as np
from numba import from_dtype

from firmware_protocol import mail as m
from firmware_protocol.block_codec import clear_fresh
from firmware_protocol.compiling import FLOATS, INTEGERS, compiled, part
from firmware_protocol.schema import BY_NAME, Direction
from sim_backend.device.drive import step_state, take_deadman_config, take_set_point
from sim_backend.device.guards import flag_travel_and_rate, within_torque_limit, without_outward
from sim_backend.device.holding import hold_axes, take_brake_commands
from sim_backend.device.identity import report_identity, report_identity_unit
from sim_backend.device.records import DRIVE, Drive, Joint
from sim_backend.device.sensing import (
    report_base_acceleration,
    report_base_attitude,
    report_base_heading,
    report_base_rate,
    report_motion,
    report_motor,
    sample,
)
from sim_backend.device.spoiling import spoilt_torque
from sim_backend.device.stopping import stop_in_force, stop_torque, stops_by_itself
from sim_backend.layout import AXES
from sim_backend.step import plant_tick

_TO_HOST = int(Direction.DEVICE_TO_HOST)
_MOTOR_PERIOD = BY_NAME["motor_status_outer"].period_ticks
_BASE_PERIOD = BY_NAME["base_attitude"].period_ticks
#: in which tick of their period the slow messages go out, so that no tick has more than one of them
_MOTOR_PHASES = (3, 3 + _MOTOR_PERIOD // 2)
_ATTITUDE_PHASE, _HEADING_PHASE, _RATE_PHASE, _ACCELERATION_PHASE = 0, 1, _BASE_PERIOD // 2, 7
_ACCELERATION_PERIOD, _IDENTITY_PERIOD = BY_NAME["base_acceleration"].period_ticks, BY_NAME["identity"].period_ticks
_IDENTITY_PHASE, _UNIT_PHASE = 2, 4


@part(INTEGERS, INTEGERS, FLOATS, INTEGERS, FLOATS, from_dtype(DRIVE))
def device_tick(
    mail_in: np.ndarray, mail_out: np.ndarray, P: np.ndarray, K: np.ndarray, X: np.ndarray, drive: Drive
) -> None:
    """One tick: read the host's messages in `mail_in`, decide, advance plant and sensors, write the device's messages
    into `mail_out`.

    Mails are int64 (MAIL_SIZE,) and may be one and the same array; P, X float64, K int64 and `drive` as `Device` makes
    them. The torque decided here acts over this tick; the feedback written is sampled at its end.
    """
    clear_fresh(mail_out, _TO_HOST)
    drive.tick += 1
    take_set_point(mail_in, drive)
    take_deadman_config(mail_in, drive)
    take_brake_commands(mail_in, drive)
    step_state(mail_in, mail_out, K, drive)
    _command_torque(K, drive)
    hold_axes(K, X, drive)
    plant_tick(P, K, X, (motor_torque(K, drive, 0), motor_torque(K, drive, 1)))
    sample(P, K, X, drive)
    flag_travel_and_rate(K, drive)
    report_motion(mail_out, K, drive)
    for axis in range(2):
        if drive.tick % _MOTOR_PERIOD == _MOTOR_PHASES[axis]:
            report_motor(mail_out, P, K, X, drive, axis)
    _report_base(mail_out, P, K, X, drive)
    asked = mail_in[m.DRIVE_CONTROL] > 0 and mail_in[m.DRIVE_CONTROL_IDENTIFY] == 1
    if asked or drive.tick % _IDENTITY_PERIOD == _IDENTITY_PHASE:
        report_identity(mail_out, drive)
    if asked or drive.tick % _IDENTITY_PERIOD == _UNIT_PHASE:
        report_identity_unit(mail_out, drive)
    _report_status(mail_out, drive)


@compiled
def _command_torque(K: np.ndarray, drive: Drive) -> None:
    """Raw torque of each axis for this tick: the set-point, the drive's own stop, or nothing. Other states know no
    torque.
    """
    drive.limits = 0
    for axis in range(K[AXES]):
        joint = drive.joints[axis]
        torque = 0
        if drive.state == m.DRIVE_STATE_OPERATION_ENABLED:
            if joint.set_enable == 1:
                torque = without_outward(drive, axis, joint.set_torque)
        elif stops_by_itself(drive):
            torque = stop_torque(K, drive, axis)
        joint.applied_torque = within_torque_limit(drive, axis, torque)


@compiled
def applied_torque(joint: Joint) -> float:
    """Torque (N m) that the drive asks of the current loop of an axis."""
    return float(joint.applied_torque << joint.exponent) * m.SET_POINT_TORQUE_OUTER_STEP


@compiled
def motor_torque(K: np.ndarray, drive: Drive, axis: int) -> float:
    """Torque (N m) that the motor of an axis makes of it: another one when it was spoilt."""
    joint = drive.joints[axis]
    torque = spoilt_torque(joint, joint.applied_torque, _stage_is_on(K, drive))
    return float(torque << joint.exponent) * m.SET_POINT_TORQUE_OUTER_STEP


@compiled
def _stage_is_on(K: np.ndarray, drive: Drive) -> bool:
    """Whether the power stage makes current: not while the winding is shorted or the axis coasts."""
    by_torque = stop_in_force(K, drive) > m.STOP_REACTION_BRAKE
    return bool(drive.state == m.DRIVE_STATE_OPERATION_ENABLED or (stops_by_itself(drive) and by_torque))


@compiled
def _report_base(mail: np.ndarray, P: np.ndarray, K: np.ndarray, X: np.ndarray, drive: Drive) -> None:
    """What the base's inertial navigation says at this tick, at most one message."""
    phase = drive.tick % _BASE_PERIOD
    if phase == _ATTITUDE_PHASE:
        report_base_attitude(mail, P, K, X, drive)
    elif phase == _HEADING_PHASE:
        report_base_heading(mail, drive)
    elif phase == _RATE_PHASE:
        report_base_rate(mail, P, K, X)
    elif drive.tick % _ACCELERATION_PERIOD == _ACCELERATION_PHASE:
        report_base_acceleration(mail, P, K, X)


@compiled
def _report_status(mail: np.ndarray, drive: Drive) -> None:
    """Put the drive's status into the mail; it closes the feedback set of the tick."""
    mail[m.DRIVE_STATUS] = 1
    mail[m.DRIVE_STATUS_STATE], mail[m.DRIVE_STATUS_FAULT] = drive.state, drive.fault
    mail[m.DRIVE_STATUS_LAST_SEQUENCE] = drive.last_sequence & 1023
    mail[m.DRIVE_STATUS_DEADMAN_MARGIN], mail[m.DRIVE_STATUS_LIMITS] = drive.margin, drive.limits
    mail[m.DRIVE_STATUS_TICK] = drive.tick & 4095
