"""From the mail of one tick to what the host believes: measurements, drive status, base motion, and how old they
are.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control import base_rates, gravity_in_base
from gimbal_hil.loop.host.base_now import extrapolate_base, has_attitude, learn_turning
from gimbal_hil.loop.host.event_ring import report
from gimbal_hil.loop.host.identity import forget_identity, receive_identity
from gimbal_hil.loop.host.layout import (
    ATTITUDE_TICKS,
    AXES,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    BASE_ACCELERATION,
    BASE_AGE,
    BASE_ANGLES,
    BASE_GRAVITY,
    BASE_LOST_TICKS,
    BASE_NOW,
    BASE_RATE,
    BASE_RATES,
    BEHIND,
    BRAKE_STATE,
    DEADMAN_MARGIN,
    DRIVE_FAULT,
    DRIVE_LIMITS,
    DRIVE_STATE,
    ENCODER_RATE,
    EXTRA_PERIODS,
    EXTRAPOLATES_BASE,
    FEEDBACK_AGE,
    FRESH_IN_A_ROW,
    GYRO_RATE,
    LAST_POSITION,
    LAST_SEQUENCE,
    LINK_STATUS,
    LOST_TICKS,
    MEASURED_POSITION,
    MEASURED_RATE,
    MOTOR_TEMPERATURE,
    MOTOR_TORQUE,
    PLAUSIBILITY_SHARE,
    SAMPLE_TICK,
    SKIPPED,
    STEP_S,
    TEMPERATURE_HEARD,
    TORQUE_STEP,
)
from gimbal_hil.loop.host.plausibility import watch_sensors, watch_status
from gimbal_hil.loop.host.states import NOTHING, YES, EventCode, LinkStatus, number

_LOST, _DEGRADED, _OK = number(LinkStatus.LOST), number(LinkStatus.DEGRADED), number(LinkStatus.OK)
_LINK, _DRIVE, _BASE = number(EventCode.LINK), number(EventCode.DRIVE), number(EventCode.BASE)
#: periods beyond which a count that leaps is none: more are not carried over either
_MOST_AHEAD = 64
#: age of what was never heard
NEVER = 1 << 40


@compiled
def receive(mail: np.ndarray, H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Take in one tick's mail. A measurement changes only when both axes and the status are fresh: never half a set."""
    silence = G[FEEDBACK_AGE]
    fresh = mail[m.FEEDBACK_OUTER] > 0 and mail[m.FEEDBACK_INNER] > 0 and mail[m.DRIVE_STATUS] > 0
    _receive_base(mail, H, G, C)
    receive_identity(mail, H, G, C)
    if mail[m.DRIVE_EVENT] > 0:
        report(G, _DRIVE, mail[m.DRIVE_EVENT_FROM_STATE], mail[m.DRIVE_EVENT_TO_STATE], mail[m.DRIVE_EVENT_CAUSE])
    if mail[m.DRIVE_STATUS] > 0:
        _receive_status(mail, G)
        watch_status(mail, G)
    if fresh:
        H[AXIS_H + MEASURED_POSITION] = mail[m.FEEDBACK_OUTER_POSITION] * m.FEEDBACK_OUTER_POSITION_STEP
        H[AXIS_H + MEASURED_RATE] = mail[m.FEEDBACK_OUTER_RATE] * m.FEEDBACK_OUTER_RATE_STEP
        inner = AXIS_H + AXIS_H_SIZE
        H[inner + MEASURED_POSITION] = mail[m.FEEDBACK_INNER_POSITION] * m.FEEDBACK_INNER_POSITION_STEP
        H[inner + MEASURED_RATE] = mail[m.FEEDBACK_INNER_RATE] * m.FEEDBACK_INNER_RATE_STEP
        G[FEEDBACK_AGE] = 0
        G[FRESH_IN_A_ROW] += 1
    else:
        G[FEEDBACK_AGE] = min(silence + 1, NEVER)
        G[FRESH_IN_A_ROW] = 0
    _receive_motors(mail, H, G)
    at = BASE_RATES
    if C[EXTRAPOLATES_BASE] > 0.0:
        extrapolate_base(mail, H, G, C)
        at = BASE_NOW
    rates = base_rates(H[AXIS_H + MEASURED_POSITION], H[at], H[at + 1], H[at + 2])
    H[AXIS_H + BASE_RATE], H[AXIS_H + AXIS_H_SIZE + BASE_RATE] = rates
    status = _OK if fresh else (_DEGRADED if G[FEEDBACK_AGE] <= C[LOST_TICKS] else _LOST)
    if status != G[LINK_STATUS]:
        report(G, _LINK, G[LINK_STATUS], status, NOTHING)
        if status == _LOST:
            forget_identity(G)
    G[EXTRA_PERIODS] = 0
    if fresh:
        passed = silence + 1 + G[SKIPPED]
        begin, stands = G[LINK_STATUS] == _LOST, mail[m.DRIVE_STATUS_TICK] == G[SAMPLE_TICK]
        ticks = _periods_since(mail, G, passed)
        _note_periods(G, begin, (0 if stands else ticks) - passed)
        watch_sensors(H, G, C, begin, ticks)
        _compare_gyro_and_encoder(H, C, begin, ticks)
    G[LINK_STATUS] = status


@compiled
def _periods_since(mail: np.ndarray, G: np.ndarray, ticks: int) -> int:
    """How many periods of the antenna lie between the last full set and this one; `ticks` of the host have passed.

    By the antenna's own count: one that was kept from running makes up for what it missed, and what it measures has
    then moved by many periods within one tick of the host. A count that stands still says nothing.
    """
    periods = (mail[m.DRIVE_STATUS_TICK] - G[SAMPLE_TICK]) & m.DRIVE_STATUS_TICK_HIGH
    G[SAMPLE_TICK] = mail[m.DRIVE_STATUS_TICK]
    return int(periods) if periods > 0 else ticks


@compiled
def _note_periods(G: np.ndarray, begin: bool, more: int) -> None:
    """Note how many periods the antenna is ahead by, `more` (or less) of them since the sample before than ticks of the
    host. One that was behind just now only makes up for it, and a count that leaps says nothing.
    """
    ahead = 0 if begin or more > _MOST_AHEAD else more - G[BEHIND]
    G[EXTRA_PERIODS] = max(0, ahead)
    # in step again: what it is behind by now it stays behind
    G[BEHIND] = 0 if more == 0 else max(0, -ahead)


@compiled
def _receive_status(mail: np.ndarray, G: np.ndarray) -> None:
    if mail[m.DRIVE_EVENT] == 0 and mail[m.DRIVE_STATUS_STATE] != G[DRIVE_STATE]:
        # the event's own frame was lost
        report(G, _DRIVE, G[DRIVE_STATE], mail[m.DRIVE_STATUS_STATE], mail[m.DRIVE_STATUS_FAULT])
    G[DRIVE_STATE] = mail[m.DRIVE_STATUS_STATE]
    G[DRIVE_FAULT] = mail[m.DRIVE_STATUS_FAULT]
    G[LAST_SEQUENCE] = mail[m.DRIVE_STATUS_LAST_SEQUENCE]
    G[DEADMAN_MARGIN] = mail[m.DRIVE_STATUS_DEADMAN_MARGIN]
    G[DRIVE_LIMITS] = mail[m.DRIVE_STATUS_LIMITS]


@compiled
def _receive_motors(mail: np.ndarray, H: np.ndarray, G: np.ndarray) -> None:
    if mail[m.MOTOR_STATUS_OUTER] > 0:
        H[AXIS_H + MOTOR_TORQUE] = mail[m.MOTOR_STATUS_OUTER_TORQUE] * H[AXIS_H + TORQUE_STEP]
        G[AXIS_G + BRAKE_STATE] = mail[m.MOTOR_STATUS_OUTER_BRAKE]
        H[AXIS_H + MOTOR_TEMPERATURE] = mail[m.MOTOR_STATUS_OUTER_TEMPERATURE] * m.MOTOR_STATUS_OUTER_TEMPERATURE_STEP
        H[AXIS_H + TEMPERATURE_HEARD] = 1.0
    if mail[m.MOTOR_STATUS_INNER] > 0:
        inner = AXIS_H + AXIS_H_SIZE
        H[inner + MOTOR_TORQUE] = mail[m.MOTOR_STATUS_INNER_TORQUE] * H[inner + TORQUE_STEP]
        G[AXIS_G + AXIS_G_SIZE + BRAKE_STATE] = mail[m.MOTOR_STATUS_INNER_BRAKE]
        H[inner + MOTOR_TEMPERATURE] = mail[m.MOTOR_STATUS_INNER_TEMPERATURE] * m.MOTOR_STATUS_INNER_TEMPERATURE_STEP
        H[inner + TEMPERATURE_HEARD] = 1.0


@compiled
def _receive_base(mail: np.ndarray, H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Base attitude and rate; a base that was never heard, or not for long, counts as fixed."""
    if has_attitude(mail, C):
        H[BASE_ANGLES] = mail[m.BASE_ATTITUDE_ROLL] * m.BASE_ATTITUDE_ROLL_STEP
        H[BASE_ANGLES + 1] = mail[m.BASE_ATTITUDE_PITCH] * m.BASE_ATTITUDE_PITCH_STEP
        H[BASE_ANGLES + 2] = mail[m.BASE_HEADING_YAW] * m.BASE_HEADING_YAW_STEP
        G[ATTITUDE_TICKS] = 0
        gravity = gravity_in_base(H[BASE_ANGLES], H[BASE_ANGLES + 1])
        for k in range(3):
            H[BASE_GRAVITY + k] = gravity[k] - H[BASE_ACCELERATION + k]
    elif G[ATTITUDE_TICKS] < NEVER:
        G[ATTITUDE_TICKS] += 1 + G[SKIPPED]
    if mail[m.BASE_ACCELERATION] > 0:
        for k in range(3):
            H[BASE_ACCELERATION + k] = mail[m.BASE_ACCELERATION_AX + k] * m.BASE_ACCELERATION_AX_STEP
    if mail[m.BASE_RATE] > 0:
        if G[BASE_AGE] > C[BASE_LOST_TICKS]:
            report(G, _BASE, YES, NOTHING, NOTHING)
        if C[EXTRAPOLATES_BASE] > 0.0:
            learn_turning(mail, H, G, C)
        G[BASE_AGE] = 0
        for k in range(3):
            H[BASE_RATES + k] = mail[m.BASE_RATE_P + k] * m.BASE_RATE_P_STEP
    elif G[BASE_AGE] < NEVER:
        G[BASE_AGE] += 1
        if G[BASE_AGE] == int(C[BASE_LOST_TICKS]) + 1:
            report(G, _BASE, NOTHING, NOTHING, NOTHING)
            for k in range(3):
                H[BASE_RATES + k] = 0.0


@compiled
def _compare_gyro_and_encoder(H: np.ndarray, C: np.ndarray, begin: bool, ticks: int) -> None:
    """Low-pass both views of the joint rate alike; `ticks` is how many periods ago the sample before was taken."""
    for axis in range(AXES):
        h = AXIS_H + axis * AXIS_H_SIZE
        joint = H[h + MEASURED_RATE] - H[h + BASE_RATE]
        if begin:
            H[h + ENCODER_RATE] = H[h + GYRO_RATE] = joint
        else:
            encoder = (H[h + MEASURED_POSITION] - H[h + LAST_POSITION]) / (C[STEP_S] * ticks)
            H[h + ENCODER_RATE] += C[PLAUSIBILITY_SHARE] * (encoder - H[h + ENCODER_RATE])
            H[h + GYRO_RATE] += C[PLAUSIBILITY_SHARE] * (joint - H[h + GYRO_RATE])
        H[h + LAST_POSITION] = H[h + MEASURED_POSITION]
