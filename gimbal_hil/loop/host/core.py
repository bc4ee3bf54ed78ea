"""The host core: one tick of supervisor and control, a pure compiled function from mail to mail.

It decides from its arguments alone: the mail of this tick, its state `H` and `G`, the configuration `C` and the plan.
Python around it only asks (bits in `G[REQUESTS]`) and looks. Every timeout counts ticks.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.block_codec import quantise
from firmware_protocol.compiling import FLOATS, INTEGER, INTEGERS, compiled, part
from gimbal_hil.loop.control import TORQUE
from gimbal_hil.loop.host.acting import carry_estimates, follow, let_go, slow_down
from gimbal_hil.loop.host.drive import may_reset_fault, send_control
from gimbal_hil.loop.host.event_ring import enter_state, report
from gimbal_hil.loop.host.following import end_segment, guard_trips, has_next, segment_over, start_segment, switches_off
from gimbal_hil.loop.host.identity import forget_identity, is_known, is_refused
from gimbal_hil.loop.host.layout import (
    AUTOMATIC_RECONNECT,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    CAUSE,
    CLEAR_TRAVEL,
    CONNECT_TICKS,
    DEBOUNCE_TICKS,
    DRIVE_FAULT,
    DRIVE_STATE,
    FRESH_IN_A_ROW,
    LAG_COUNT,
    LAST_SEQUENCE,
    LAST_TICK,
    LINK_STATUS,
    MAY_RESET,
    MODE,
    MOST_TORQUE,
    REQUEST_DISTRUST,
    REQUEST_QUICK_STOP,
    REQUEST_RESET,
    REQUEST_START,
    REQUEST_STOP,
    REQUESTS,
    REST_COUNT,
    REST_TICKS,
    SEGMENT,
    SEGMENT_LABEL,
    SEGMENT_RUNS,
    SENT_SEQUENCE,
    SET_POINT_LAG_TICKS,
    SKIPPED,
    STATE,
    STATE_AGE,
    STOP_KIND,
    STOP_TICKS,
    SYNCHRONISE_TICKS,
    TICK_SEGMENT,
    TORQUE_STEP,
)
from gimbal_hil.loop.host.limits import fault_of, forget_counts, report_beyond_limits, stop_cause
from gimbal_hil.loop.host.plausibility import accept_places, has_jumped
from gimbal_hil.loop.host.pointing import carry_attitude, has_coasted, is_pointing, judge_pointing
from gimbal_hil.loop.host.reactions import stop_kind
from gimbal_hil.loop.host.reception import receive
from gimbal_hil.loop.host.states import NOTHING, EventCode, HostCause, HostState, LinkStatus, number

_WAITING, _SYNCHRONISING, _IDLE = number(HostState.WAITING), number(HostState.SYNCHRONISING), number(HostState.IDLE)
_ACTIVE, _STOPPING, _FAULT = number(HostState.ACTIVE), number(HostState.STOPPING), number(HostState.FAULT)
_LOST, _OK = number(LinkStatus.LOST), number(LinkStatus.OK)
_NONE, _FEEDBACK_LOST, _DRIVE_FAULT = (
    number(HostCause.NONE),
    number(HostCause.FEEDBACK_LOST),
    number(HostCause.DRIVE_FAULT),
)
_DRIVE_LEFT, _SYNCHRONISATION_TIMEOUT = (
    number(HostCause.DRIVE_LEFT_OPERATION),
    number(HostCause.SYNCHRONISATION_TIMEOUT),
)
_STOP_TIMEOUT, _SET_POINT_LOST, _NOT_A_NUMBER = (
    number(HostCause.STOP_TIMEOUT),
    number(HostCause.SET_POINT_LOST),
    number(HostCause.NOT_A_NUMBER),
)
_ATTITUDE_LOST, _JUMP = number(HostCause.ATTITUDE_LOST), number(HostCause.POSITION_JUMP)
_WRONG_ANTENNA, _FIRST_TEST = number(HostCause.WRONG_ANTENNA), number(HostCause.FIRST_TEST)
_GUARD, _OPERATOR, _REPLACED = number(HostCause.GUARD), number(HostCause.OPERATOR), number(HostCause.REPLACED)
_TRIPPED, _COMMAND_REFUSED = number(EventCode.TRIPPED), number(EventCode.COMMAND_REFUSED)
#: SEGMENT_RUNS: the next segment of the plan starts with the next fresh tick
_DUE = 2
#: what a row has room for
_MOST_SKIPPED = (1 << 31) - 1
#: REST_COUNT: the loops have not yet been taken over for braking
_NOT_BRAKING = -1


@part(INTEGERS, FLOATS, INTEGERS, FLOATS, FLOATS, INTEGER)
def host_tick(mail: np.ndarray, H: np.ndarray, G: np.ndarray, C: np.ndarray, plan: np.ndarray, tick: int) -> None:
    """One tick: read the device's messages in `mail`, decide, write the host's messages into it.

    `mail` int64 (MAIL_SIZE,), `H`, `C`, `plan` float64, `G` int64, sizes in `layout`; `tick` may jump where ticks were
    skipped.
    """
    G[SKIPPED] = min(max(tick - G[LAST_TICK] - 1, 0), _MOST_SKIPPED) if G[LAST_TICK] >= 0 else 0
    G[LAST_TICK] = tick
    receive(mail, H, G, C)
    carry_attitude(H, G, C)
    G[STATE_AGE] += 1
    _take_requests(H, G)
    _supervise(H, G, C)
    if G[LINK_STATUS] == _OK:
        report_beyond_limits(H, G, C)
    if G[STATE] == _ACTIVE:
        _act(H, G, C, plan)
    G[TICK_SEGMENT] = G[SEGMENT_LABEL] if G[SEGMENT_RUNS] == 1 else -1
    if G[STATE] == _STOPPING:
        _stop(H, G, C)
    if G[STATE] != _ACTIVE and G[STATE] != _STOPPING:
        let_go(H, G)
    _send_set_point(mail, H, G, tick)
    send_control(mail, G, C)
    judge_pointing(H, G, C, plan)
    if G[STATE] == _ACTIVE:
        _end_of_tick(H, G, plan)


@compiled
def _take_requests(H: np.ndarray, G: np.ndarray) -> None:
    """What the operator asked since the last tick; a stop outranks a start."""
    requests = G[REQUESTS]
    if requests == 0:
        return
    G[REQUESTS] = 0
    if requests & REQUEST_RESET and G[STATE] == _FAULT:
        G[MAY_RESET] = 1
        accept_places(H, G)
        G[CLEAR_TRAVEL] = 1 if G[DRIVE_FAULT] == m.FAULT_CODE_TRAVEL_LIMIT else 0
        forget_identity(G)
        enter_state(G, _WAITING, _OPERATOR)
    if requests & REQUEST_DISTRUST and G[STATE] != _FAULT:
        _fault(G, _FIRST_TEST)
    if requests & REQUEST_QUICK_STOP:
        if G[STATE] != _FAULT:
            _fault(G, _OPERATOR)
        elif _ends_by_itself(G):
            # the drive goes on stopping as that fault has it, which uses no suspect; only the way out is the operator's
            G[CAUSE] = _OPERATOR
            enter_state(G, _FAULT, _OPERATOR)
    if requests & REQUEST_STOP:
        if G[STATE] == _ACTIVE:
            _begin_stopping(G, _OPERATOR)
    elif requests & REQUEST_START:
        if G[STATE] == _IDLE or G[STATE] == _ACTIVE:
            end_segment(G, _REPLACED)
            G[SEGMENT], G[SEGMENT_RUNS] = -1, _DUE
            if G[STATE] == _IDLE:
                forget_counts(G)
                G[LAG_COUNT] = 0
                enter_state(G, _ACTIVE, _OPERATOR)
        else:
            report(G, _COMMAND_REFUSED, G[STATE], G[CAUSE], NOTHING)


@compiled
def _supervise(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """The state machine: who may go where at this tick."""
    state = G[STATE]
    if state == _WAITING and not has_jumped(G):
        if G[FRESH_IN_A_ROW] >= C[CONNECT_TICKS] and is_known(G):
            enter_state(G, _SYNCHRONISING, _NONE)
    elif state == _SYNCHRONISING and not has_jumped(G):
        _synchronise(G, C)
    elif state == _FAULT:
        _leave_fault(G, C)
    elif has_jumped(G):
        _fault(G, _JUMP)
    elif is_refused(G):
        _fault(G, _WRONG_ANTENNA)
    elif G[LINK_STATUS] == _LOST:
        _fault(G, _FEEDBACK_LOST)
    elif state == _IDLE:
        if G[DRIVE_STATE] == m.DRIVE_STATE_FAULT and not may_reset_fault(G):
            _fault(G, _DRIVE_FAULT)
        elif G[DRIVE_STATE] != m.DRIVE_STATE_OPERATION_ENABLED:
            enter_state(G, _SYNCHRONISING, _DRIVE_LEFT)
    elif G[DRIVE_STATE] == m.DRIVE_STATE_FAULT or G[DRIVE_STATE] == m.DRIVE_STATE_FAULT_REACTION_ACTIVE:
        _fault(G, _DRIVE_FAULT)
    elif G[DRIVE_STATE] != m.DRIVE_STATE_OPERATION_ENABLED:
        _fault(G, _DRIVE_LEFT)
    elif G[LINK_STATUS] == _OK:
        _check_limits(H, G, C)


@compiled
def _synchronise(G: np.ndarray, C: np.ndarray) -> None:
    if is_refused(G):
        _fault(G, _WRONG_ANTENNA)
    elif G[LINK_STATUS] == _LOST:
        enter_state(G, _WAITING, _FEEDBACK_LOST)
    elif G[DRIVE_STATE] == m.DRIVE_STATE_OPERATION_ENABLED:
        G[MAY_RESET] = 0
        enter_state(G, _IDLE, _NONE)
    elif G[DRIVE_STATE] == m.DRIVE_STATE_FAULT and not may_reset_fault(G):
        _fault(G, _DRIVE_FAULT)
    elif G[STATE_AGE] >= C[SYNCHRONISE_TICKS]:
        _fault(G, _SYNCHRONISATION_TIMEOUT)


@compiled
def _ends_by_itself(G: np.ndarray) -> bool:
    """Whether the fault is a lost link, seen from either end."""
    return G[CAUSE] == _FEEDBACK_LOST or (G[CAUSE] == _DRIVE_FAULT and G[DRIVE_FAULT] == m.FAULT_CODE_DEADMAN)


@compiled
def _leave_fault(G: np.ndarray, C: np.ndarray) -> None:
    """After a lost link the host connects again by itself, once the drive has had time to stop."""
    lost_link = _ends_by_itself(G)
    if lost_link and has_jumped(G):
        _fault(G, _JUMP)
        return
    if C[AUTOMATIC_RECONNECT] == 0.0 or not lost_link or G[FRESH_IN_A_ROW] < C[CONNECT_TICKS] or not is_known(G):
        return
    braking = G[DRIVE_STATE] == m.DRIVE_STATE_QUICK_STOP_ACTIVE or G[DRIVE_STATE] == m.DRIVE_STATE_FAULT_REACTION_ACTIVE
    if not braking or G[STATE_AGE] >= C[STOP_TICKS]:
        enter_state(G, _SYNCHRONISING, _NONE)


@compiled
def _check_limits(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Guards on a fresh sample while torque is on."""
    lag = (G[SENT_SEQUENCE] - G[LAST_SEQUENCE]) & 1023
    G[LAG_COUNT] = G[LAG_COUNT] + 1 if lag > C[SET_POINT_LAG_TICKS] else 0
    if G[LAG_COUNT] >= C[DEBOUNCE_TICKS]:
        _fault(G, _SET_POINT_LOST)
        return
    cause = fault_of(H, G, C)
    if cause != _NONE:
        _fault(G, cause)
    elif G[STATE] == _ACTIVE:
        cause = stop_cause(H, G, C)
        if cause != _NONE:
            _begin_stopping(G, cause)


@compiled
def _begin_stopping(G: np.ndarray, cause: int) -> None:
    end_segment(G, cause)
    G[SEGMENT_RUNS], G[CAUSE], G[REST_COUNT] = 0, cause, _NOT_BRAKING
    enter_state(G, _STOPPING, cause)


@compiled
def _fault(G: np.ndarray, cause: int) -> None:
    end_segment(G, cause)
    G[SEGMENT_RUNS], G[CAUSE], G[STOP_KIND] = 0, cause, stop_kind(cause)
    enter_state(G, _FAULT, cause)


@compiled
def _act(H: np.ndarray, G: np.ndarray, C: np.ndarray, plan: np.ndarray) -> None:
    """Follow the segment in force; without a fresh sample the torque of the last tick is held."""
    if G[LINK_STATUS] != _OK:
        carry_estimates(H, G, C)
        return
    if G[SEGMENT_RUNS] == _DUE:
        start_segment(G[SEGMENT] + 1, H, G, plan)
    if G[SEGMENT_RUNS] == 1 and guard_trips(H, G, plan):
        _begin_stopping(G, _GUARD)
    elif is_pointing(G, plan) and has_coasted(G, C):
        _begin_stopping(G, _ATTITUDE_LOST)
    else:
        follow(H, G, C, plan)


@compiled
def _stop(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Brake to rest, then go idle; too long is a fault, and the drive stops by itself."""
    if G[LINK_STATUS] != _OK:
        carry_estimates(H, G, C)
        return
    begins = G[REST_COUNT] == _NOT_BRAKING
    if begins:
        G[REST_COUNT] = 0
    G[REST_COUNT] = G[REST_COUNT] + 1 if slow_down(begins, H, G, C) else 0
    if G[REST_COUNT] >= C[REST_TICKS]:
        enter_state(G, _IDLE, G[CAUSE])
    elif G[STATE_AGE] >= C[STOP_TICKS]:
        _fault(G, _STOP_TIMEOUT)


@compiled
def _send_set_point(mail: np.ndarray, H: np.ndarray, G: np.ndarray, tick: int) -> None:
    """Quantise the torques as the wire does, and keep what was really sent."""
    for axis in range(2):
        torque = H[AXIS_H + axis * AXIS_H_SIZE + TORQUE]
        if torque != torque:
            report(G, _TRIPPED, _NOT_A_NUMBER, axis, NOTHING)
            _fault(G, _NOT_A_NUMBER)
            let_go(H, G)
    for axis in range(2):
        h = AXIS_H + axis * AXIS_H_SIZE
        most = int(H[h + MOST_TORQUE])
        raw = quantise(H[h + TORQUE], H[h + TORQUE_STEP], -most, most)
        mail[m.SET_POINT_TORQUE_OUTER + axis] = raw
        H[h + TORQUE] = raw * H[h + TORQUE_STEP]
        mail[m.SET_POINT_ENABLE_OUTER + axis] = 1 if G[AXIS_G + axis * AXIS_G_SIZE + MODE] != 0 else 0
    mail[m.SET_POINT] = 1
    mail[m.SET_POINT_SEQUENCE] = G[SENT_SEQUENCE] = tick & 1023


@compiled
def _end_of_tick(H: np.ndarray, G: np.ndarray, plan: np.ndarray) -> None:
    """Whether the segment ends with this tick, and what comes after it."""
    if G[SEGMENT_RUNS] != 1:
        return
    cause = segment_over(H, G, plan)
    if cause == _NONE:
        return
    end_segment(G, cause)
    if has_next(G):
        G[SEGMENT_RUNS] = _DUE
    elif switches_off(G, plan):
        _begin_stopping(G, cause)
