"""The device core: one tick of the antenna, firmware and plant, a pure compiled function from mail to mail.

Everything it keeps is in `J` (firmware) and `X` (plant); both may be copied and continued.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.block_codec import clear_fresh
from firmware_protocol.compiling import compiled
from firmware_protocol.schema import BY_NAME, Direction
from sim_backend.device.drive import step_state, take_deadman_config, take_set_point
from sim_backend.device.guards import flag_travel_and_rate, within_torque_limit, without_outward
from sim_backend.device.holding import hold_axes, take_brake_commands
from sim_backend.device.identity import report_identity, report_identity_unit
from sim_backend.device.layout import (
    APPLIED_TORQUE,
    AXIS_J,
    AXIS_J_SIZE,
    EXPONENT,
    FAULT,
    LAST_SEQUENCE,
    LIMITS,
    MARGIN,
    SET_ENABLE,
    SET_TORQUE,
    STATE,
    TICK,
)
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
_INNER = AXIS_J + AXIS_J_SIZE


@compiled
def device_tick(
    mail_in: np.ndarray, mail_out: np.ndarray, P: np.ndarray, K: np.ndarray, X: np.ndarray, J: np.ndarray
) -> None:
    """One tick: read the host's messages in `mail_in`, decide, advance plant and sensors, write the device's messages
    into `mail_out`.

    Mails are int64 (MAIL_SIZE,) and may be one and the same array; P, X float64, K, J int64 as `Device` makes them. The
    torque decided here acts over this tick; the feedback written is sampled at its end.
    """
    clear_fresh(mail_out, _TO_HOST)
    J[TICK] += 1
    take_set_point(mail_in, J)
    take_deadman_config(mail_in, J)
    take_brake_commands(mail_in, J)
    step_state(mail_in, mail_out, K, J)
    _command_torque(K, J)
    hold_axes(K, X, J)
    plant_tick(P, K, X, (motor_torque(K, J, AXIS_J), motor_torque(K, J, _INNER)))
    sample(P, K, X, J)
    flag_travel_and_rate(K, J)
    report_motion(mail_out, K, J)
    for axis in range(2):
        if J[TICK] % _MOTOR_PERIOD == _MOTOR_PHASES[axis]:
            report_motor(mail_out, P, K, X, J, axis)
    _report_base(mail_out, P, K, X, J)
    asked = mail_in[m.DRIVE_CONTROL] > 0 and mail_in[m.DRIVE_CONTROL_IDENTIFY] == 1
    if asked or J[TICK] % _IDENTITY_PERIOD == _IDENTITY_PHASE:
        report_identity(mail_out, J)
    if asked or J[TICK] % _IDENTITY_PERIOD == _UNIT_PHASE:
        report_identity_unit(mail_out, J)
    _report_status(mail_out, J)


@compiled
def _command_torque(K: np.ndarray, J: np.ndarray) -> None:
    """Raw torque of each axis for this tick: the set-point, the drive's own stop, or nothing. Other states know no
    torque.
    """
    J[LIMITS] = 0
    for axis in range(K[AXES]):
        j = AXIS_J + axis * AXIS_J_SIZE
        torque = 0
        if J[STATE] == m.DRIVE_STATE_OPERATION_ENABLED:
            if J[j + SET_ENABLE] == 1:
                torque = without_outward(J, axis, J[j + SET_TORQUE])
        elif stops_by_itself(J):
            torque = stop_torque(K, J, axis)
        J[j + APPLIED_TORQUE] = within_torque_limit(J, axis, torque)


@compiled
def applied_torque(J: np.ndarray, j: int) -> float:
    """Torque (N m) that the drive asks of the current loop of the axis whose block begins at `j`."""
    return float(J[j + APPLIED_TORQUE] << J[j + EXPONENT]) * m.SET_POINT_TORQUE_OUTER_STEP


@compiled
def motor_torque(K: np.ndarray, J: np.ndarray, j: int) -> float:
    """Torque (N m) that its motor makes of it: another one when it was spoilt."""
    return (
        float(spoilt_torque(J, j, J[j + APPLIED_TORQUE], _stage_is_on(K, J)) << J[j + EXPONENT])
        * m.SET_POINT_TORQUE_OUTER_STEP
    )


@compiled
def _stage_is_on(K: np.ndarray, J: np.ndarray) -> bool:
    """Whether the power stage makes current: not while the winding is shorted or the axis coasts."""
    by_torque = stop_in_force(K, J) > m.STOP_REACTION_BRAKE
    return bool(J[STATE] == m.DRIVE_STATE_OPERATION_ENABLED or (stops_by_itself(J) and by_torque))


@compiled
def _report_base(mail: np.ndarray, P: np.ndarray, K: np.ndarray, X: np.ndarray, J: np.ndarray) -> None:
    """What the base's inertial navigation says at this tick, at most one message."""
    phase = J[TICK] % _BASE_PERIOD
    if phase == _ATTITUDE_PHASE:
        report_base_attitude(mail, P, K, X, J)
    elif phase == _HEADING_PHASE:
        report_base_heading(mail, J)
    elif phase == _RATE_PHASE:
        report_base_rate(mail, P, K, X)
    elif J[TICK] % _ACCELERATION_PERIOD == _ACCELERATION_PHASE:
        report_base_acceleration(mail)


@compiled
def _report_status(mail: np.ndarray, J: np.ndarray) -> None:
    """Put the drive's status into the mail; it closes the feedback set of the tick."""
    mail[m.DRIVE_STATUS] = 1
    mail[m.DRIVE_STATUS_STATE], mail[m.DRIVE_STATUS_FAULT] = J[STATE], J[FAULT]
    mail[m.DRIVE_STATUS_LAST_SEQUENCE] = J[LAST_SEQUENCE] & 1023
    mail[m.DRIVE_STATUS_DEADMAN_MARGIN], mail[m.DRIVE_STATUS_LIMITS] = J[MARGIN], J[LIMITS]
    mail[m.DRIVE_STATUS_TICK] = J[TICK] & 4095
