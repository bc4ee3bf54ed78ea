"""From the plant's motion to the raw integers of the wire: the one place where the virtual antenna quantises."""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.block_codec import quantise
from firmware_protocol.compiling import compiled
from sim_backend.base_motion import base_attitude, base_state, pivot_acceleration
from sim_backend.device.records import JOINT_RATE_SHIFT, SCALE_BITS, Drive
from sim_backend.device.runaway import watch_momentum
from sim_backend.device.spoiling import spoilt_reading
from sim_backend.layout import (
    APPLIED,
    AXES,
    AXIS_BLOCK,
    AXIS_SIZE,
    INS_AGE_S,
    POSITION,
    RATE,
    SEED,
    SHORT_DAMPING,
    STEP_S,
    STEPS,
    STEPS_PER_TICK,
    TEMPERATURE,
    TORQUE_NOISE,
)
from sim_backend.noise import normal
from sim_backend.step import read_encoder, read_gyro, true_rates

_POSITION_STEP, _POSITION_LOW, _POSITION_HIGH = (
    m.FEEDBACK_OUTER_POSITION_STEP,
    m.FEEDBACK_OUTER_POSITION_LOW,
    m.FEEDBACK_OUTER_POSITION_HIGH,
)
_RATE_STEP, _RATE_LOW, _RATE_HIGH = m.FEEDBACK_OUTER_RATE_STEP, m.FEEDBACK_OUTER_RATE_LOW, m.FEEDBACK_OUTER_RATE_HIGH
_TORQUE_STEP, _TORQUE_LOW, _TORQUE_HIGH = (
    m.MOTOR_STATUS_OUTER_TORQUE_STEP,
    m.MOTOR_STATUS_OUTER_TORQUE_LOW,
    m.MOTOR_STATUS_OUTER_TORQUE_HIGH,
)
_HEAT_STEP, _HEAT_LOW, _HEAT_HIGH = (
    m.MOTOR_STATUS_OUTER_TEMPERATURE_STEP,
    m.MOTOR_STATUS_OUTER_TEMPERATURE_LOW,
    m.MOTOR_STATUS_OUTER_TEMPERATURE_HIGH,
)
_ANGLE_STEP, _ANGLE_LOW, _ANGLE_HIGH = m.BASE_ATTITUDE_ROLL_STEP, m.BASE_ATTITUDE_ROLL_LOW, m.BASE_ATTITUDE_ROLL_HIGH
_BODY_STEP, _BODY_LOW, _BODY_HIGH = m.BASE_RATE_P_STEP, m.BASE_RATE_P_LOW, m.BASE_RATE_P_HIGH
_ACCELERATION_STEP, _ACCELERATION_LOW, _ACCELERATION_HIGH = (
    m.BASE_ACCELERATION_AX_STEP,
    m.BASE_ACCELERATION_AX_LOW,
    m.BASE_ACCELERATION_AX_HIGH,
)
_FRACTIONS = 1 << 8
#: channel of the noise of measured torque, behind those of encoders and gyros
_TORQUE_CHANNEL = 4


@compiled
def sample(P: np.ndarray, K: np.ndarray, X: np.ndarray, drive: Drive) -> None:
    """Read encoders and gyros at this instant into drive, with the joint rate and what is wrong with the sensors."""
    true_rates(P, K, X)
    for axis in range(K[AXES]):
        joint = drive.joints[axis]
        # a motion that is no number is the simulator's own failure; sensors keep what they last said
        if not (math.isfinite(X[POSITION + axis]) and math.isfinite(X[RATE + axis])):
            joint.sensor_fault = m.FAULT_CODE_INTERNAL
            continue
        position = quantise(read_encoder(P, K, X, axis, drive.tick), _POSITION_STEP, _POSITION_LOW, _POSITION_HIGH)
        rate = quantise(read_gyro(P, K, X, axis, drive.tick), _RATE_STEP, _RATE_LOW, _RATE_HIGH)
        position = min(
            max(spoilt_reading(joint.encoder_spoilt, position, False, _POSITION_HIGH), _POSITION_LOW), _POSITION_HIGH
        )
        rate = min(max(spoilt_reading(joint.gyro_spoilt, rate, True, _RATE_HIGH), _RATE_LOW), _RATE_HIGH)
        # the first sample after power-up has none before it
        moved = (position - joint.encoder) * drive.rate_of_count >> SCALE_BITS if drive.tick > 1 else 0
        joint.joint_rate += (moved - joint.joint_rate) >> JOINT_RATE_SHIFT
        before = joint.gyro
        joint.encoder, joint.gyro = position, rate
        watch_momentum(drive, joint, before)
        joint.winding = quantise(X[TEMPERATURE + axis], _HEAT_STEP, _HEAT_LOW, _HEAT_HIGH)
        joint.sensor_fault = _sensor_fault(position, rate)


@compiled
def _sensor_fault(position: int, rate: int) -> int:
    """A number at the end of its range says nothing any more."""
    if not _POSITION_LOW < position < _POSITION_HIGH:
        return m.FAULT_CODE_ENCODER
    return m.FAULT_CODE_NONE if _RATE_LOW < rate < _RATE_HIGH else m.FAULT_CODE_GYRO


@compiled
def report_motion(mail: np.ndarray, K: np.ndarray, drive: Drive) -> None:
    """Put the feedback of this tick into the mail; the inner fields of a single axis stay zero."""
    mail[m.FEEDBACK_OUTER] = mail[m.FEEDBACK_INNER] = 1
    for axis in range(K[AXES]):
        slot = m.FEEDBACK_OUTER_POSITION + axis * (m.FEEDBACK_INNER_POSITION - m.FEEDBACK_OUTER_POSITION)
        joint = drive.joints[axis]
        mail[slot], mail[slot + 1] = joint.encoder, joint.gyro


@compiled
def report_motor(mail: np.ndarray, P: np.ndarray, K: np.ndarray, X: np.ndarray, drive: Drive, axis: int) -> None:
    """Put one motor's torque, temperature and supply into the mail; zeros for an axis that the model does not have."""
    fresh = m.MOTOR_STATUS_OUTER + axis * (m.MOTOR_STATUS_INNER - m.MOTOR_STATUS_OUTER)
    mail[fresh] = 1
    if axis >= K[AXES]:
        return
    torque = X[APPLIED + axis]
    if drive.joints[axis].shorted == 1:
        torque -= P[AXIS_BLOCK + axis * AXIS_SIZE + SHORT_DAMPING] * X[RATE + axis]
    noise = P[AXIS_BLOCK + axis * AXIS_SIZE + TORQUE_NOISE]
    if noise > 0.0:
        torque += noise * normal(K[SEED], drive.tick, _TORQUE_CHANNEL + axis)
    joint = drive.joints[axis]
    mail[fresh + 1] = quantise(torque, _TORQUE_STEP * (1 << joint.exponent), _TORQUE_LOW, _TORQUE_HIGH)
    mail[fresh + 2], mail[fresh + 3] = joint.winding, drive.supply
    mail[fresh + 4], mail[fresh + 5] = joint.brake_state, joint.shorted


@compiled
def report_base_attitude(mail: np.ndarray, P: np.ndarray, K: np.ndarray, X: np.ndarray, drive: Drive) -> None:
    """Put roll and pitch of the base into the mail, as its inertial navigation gives them, and keep the rest for
    `report_base_heading`.
    """
    mail[m.BASE_ATTITUDE] = 1
    roll, pitch, yaw = base_attitude(P, K, _told_s(P, X))
    mail[m.BASE_ATTITUDE_ROLL] = _angle(roll)
    mail[m.BASE_ATTITUDE_PITCH] = _angle(pitch)
    # when it was true, in 1 / 256 of a tick; rounded, so that an age of whole ticks has no fraction
    valid = drive.tick * _FRACTIONS - int(math.floor(P[INS_AGE_S] / (P[STEP_S] * K[STEPS_PER_TICK]) * _FRACTIONS + 0.5))
    drive.yaw, drive.attitude_tick = _angle(yaw), (valid // _FRACTIONS) & m.BASE_HEADING_VALID_TICK_HIGH
    drive.attitude_fraction = valid % _FRACTIONS
    mail[m.BASE_ATTITUDE_SET] = drive.attitude_tick & m.BASE_ATTITUDE_SET_HIGH


@compiled
def report_base_heading(mail: np.ndarray, drive: Drive) -> None:
    """Put the heading that belongs to the last `report_base_attitude` into the mail, and when both were true."""
    mail[m.BASE_HEADING] = 1
    mail[m.BASE_HEADING_YAW], mail[m.BASE_HEADING_VALID_TICK], mail[m.BASE_HEADING_VALID_FRACTION] = (
        drive.yaw,
        drive.attitude_tick,
        drive.attitude_fraction,
    )


@compiled
def report_base_acceleration(mail: np.ndarray, P: np.ndarray, K: np.ndarray, X: np.ndarray) -> None:
    """Put the acceleration of the pivot, gravity not included, into the mail."""
    mail[m.BASE_ACCELERATION] = 1
    ax, ay, az = pivot_acceleration(P, K, _told_s(P, X))
    mail[m.BASE_ACCELERATION_AX] = quantise(ax, _ACCELERATION_STEP, _ACCELERATION_LOW, _ACCELERATION_HIGH)
    mail[m.BASE_ACCELERATION_AY] = quantise(ay, _ACCELERATION_STEP, _ACCELERATION_LOW, _ACCELERATION_HIGH)
    mail[m.BASE_ACCELERATION_AZ] = quantise(az, _ACCELERATION_STEP, _ACCELERATION_LOW, _ACCELERATION_HIGH)


@compiled
def report_base_rate(mail: np.ndarray, P: np.ndarray, K: np.ndarray, X: np.ndarray) -> None:
    """Put the body rates of the base into the mail."""
    mail[m.BASE_RATE] = 1
    _, rates, _ = base_state(P, K, _told_s(P, X))
    mail[m.BASE_RATE_P] = quantise(rates[0], _BODY_STEP, _BODY_LOW, _BODY_HIGH)
    mail[m.BASE_RATE_Q] = quantise(rates[1], _BODY_STEP, _BODY_LOW, _BODY_HIGH)
    mail[m.BASE_RATE_R] = quantise(rates[2], _BODY_STEP, _BODY_LOW, _BODY_HIGH)


@compiled
def _told_s(P: np.ndarray, X: np.ndarray) -> float:
    """The time of which the inertial navigation tells at this instant (s)."""
    return X[STEPS] * P[STEP_S] - P[INS_AGE_S]


@compiled
def _angle(angle: float) -> int:
    """Raw angle between -pi and pi."""
    return quantise(
        angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi)), _ANGLE_STEP, _ANGLE_LOW, _ANGLE_HIGH
    )
