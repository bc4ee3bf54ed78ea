"""The drive's state machine after CiA 402 (IEC 61800-7-201): who may go where, and the event that tells of it.

At most one transition a tick, so the mail's single `drive_event` tells of every one. Requests act in the tick in which
their frame arrives; a fault outranks them all.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.guards import beyond_any_travel, find_fault, has_power
from sim_backend.device.layout import (
    ACTIVE_REACTION,
    CONTROL_AGE,
    DETAIL_BY_ITSELF,
    DETAIL_FAULT_RESET,
    FAULT,
    FAULT_DETAIL,
    FAULT_REACTION,
    LAST_SEQUENCE,
    MARGIN,
    REACTION,
    REFUSED,
    RESET_LEVEL,
    SET_ENABLE,
    SET_TORQUE,
    STARTUP_TICKS,
    STATE,
    STATE_AGE,
    TAKEN,
    TICK,
    TRAVEL_CLEARED,
    WINDOW,
    axis_j,
)
from sim_backend.device.stopping import begin_stop, count_rest, reaction_over

_NOT_READY, _SWITCH_ON_DISABLED = m.DRIVE_STATE_NOT_READY, m.DRIVE_STATE_SWITCH_ON_DISABLED
_READY, _SWITCHED_ON, _ENABLED = (
    m.DRIVE_STATE_READY_TO_SWITCH_ON,
    m.DRIVE_STATE_SWITCHED_ON,
    m.DRIVE_STATE_OPERATION_ENABLED,
)
_QUICK_STOP, _REACTING, _FAULT = (
    m.DRIVE_STATE_QUICK_STOP_ACTIVE,
    m.DRIVE_STATE_FAULT_REACTION_ACTIVE,
    m.DRIVE_STATE_FAULT,
)
_OUTER, _INNER = axis_j(0), axis_j(1)


@compiled
def take_set_point(mail: np.ndarray, J: np.ndarray) -> None:
    """Let the deadman run by one tick, and feed it if a fresh set-point with a new sequence came."""
    margin = J[MARGIN]
    J[MARGIN] = max(margin - 1, 0)
    if mail[m.SET_POINT] == 0:
        return
    sequence = mail[m.SET_POINT_SEQUENCE]
    ahead = (sequence - J[LAST_SEQUENCE]) & 1023
    # a repeat never counts; one from behind only when the deadman has run out, because then it is a host that started
    # anew
    if J[LAST_SEQUENCE] >= 0 and (ahead == 0 or (ahead >= 512 and margin > 0)):
        J[REFUSED] += 1
        return
    J[TAKEN] += 1
    J[LAST_SEQUENCE], J[MARGIN] = sequence, J[WINDOW]
    J[_OUTER + SET_TORQUE], J[_OUTER + SET_ENABLE] = mail[m.SET_POINT_TORQUE_OUTER], mail[m.SET_POINT_ENABLE_OUTER]
    J[_INNER + SET_TORQUE], J[_INNER + SET_ENABLE] = mail[m.SET_POINT_TORQUE_INNER], mail[m.SET_POINT_ENABLE_INNER]


@compiled
def take_deadman_config(mail: np.ndarray, J: np.ndarray) -> None:
    """Take the host's deadman over, never while it guards torque."""
    if mail[m.DEADMAN_CONFIG] > 0 and not has_power(J[STATE]) and J[STATE] != _REACTING:
        J[WINDOW], J[REACTION] = mail[m.DEADMAN_CONFIG_WINDOW_TICKS], mail[m.DEADMAN_CONFIG_REACTION]
        J[MARGIN] = min(J[MARGIN], J[WINDOW])


@compiled
def step_state(mail_in: np.ndarray, mail_out: np.ndarray, K: np.ndarray, J: np.ndarray) -> None:
    """One tick of the state machine."""
    J[STATE_AGE] += 1
    J[CONTROL_AGE] += 1
    reset_edge = _hear_control(mail_in, K, J)
    count_rest(K, J)
    state = J[STATE]
    fault, about = find_fault(K, J)
    if state == _REACTING:
        if reaction_over(J):
            _enter(mail_out, J, _FAULT, J[FAULT], J[FAULT_DETAIL])
    elif state == _FAULT:
        if reset_edge and fault == m.FAULT_CODE_NONE:
            J[FAULT] = m.FAULT_CODE_NONE
            _enter(mail_out, J, _SWITCH_ON_DISABLED, m.FAULT_CODE_NONE, DETAIL_FAULT_RESET)
    elif fault != m.FAULT_CODE_NONE:
        J[FAULT], J[FAULT_DETAIL] = fault, about
        J[ACTIVE_REACTION] = _reaction_to(fault, state, J)
        begin_stop(K, J)
        _enter(mail_out, J, _REACTING, fault, about)
    elif state == _NOT_READY:
        if J[STATE_AGE] >= J[STARTUP_TICKS]:
            _enter(mail_out, J, _SWITCH_ON_DISABLED, m.FAULT_CODE_NONE, DETAIL_BY_ITSELF)
    elif mail_in[m.DRIVE_CONTROL] > 0:
        request = mail_in[m.DRIVE_CONTROL_REQUEST]
        if mail_in[m.DRIVE_CONTROL_QUICK_STOP] == 1 and state != _QUICK_STOP:
            request = m.DRIVE_REQUEST_QUICK_STOP
        wanted = destination(state, request, J[MARGIN] > 0)
        if wanted == _QUICK_STOP and (state != _QUICK_STOP or _asks_for_another_stop(mail_in, J)):
            J[ACTIVE_REACTION] = mail_in[m.DRIVE_CONTROL_STOP]
            begin_stop(K, J)
        if wanted != state:
            _enter(mail_out, J, wanted, m.FAULT_CODE_NONE, request)


@compiled
def destination(state: int, request: int, deadman_fed: bool) -> int:
    """Where a request leads: the transitions of CiA 402 without the optional 16, so a quick stop is left through
    SWITCH_ON_DISABLED.

    Torque is not switched on before set-points come.
    """
    if request == m.DRIVE_REQUEST_DISABLE_VOLTAGE:
        return _SWITCH_ON_DISABLED
    if request == m.DRIVE_REQUEST_QUICK_STOP:
        if state == _ENABLED:
            return _QUICK_STOP
        return state if state == _QUICK_STOP else _SWITCH_ON_DISABLED
    if request == m.DRIVE_REQUEST_SHUTDOWN and state != _QUICK_STOP:
        return _READY
    if request == m.DRIVE_REQUEST_SWITCH_ON and state == _READY:
        return _SWITCHED_ON
    if request == m.DRIVE_REQUEST_DISABLE_OPERATION and state == _ENABLED:
        return _SWITCHED_ON
    if request == m.DRIVE_REQUEST_ENABLE_OPERATION and state == _SWITCHED_ON and deadman_fed:
        return _ENABLED
    return state


@compiled
def _asks_for_another_stop(mail: np.ndarray, J: np.ndarray) -> bool:
    """Whether a quick stop that runs shall go on without the sensor that it uses; one that uses none stays."""
    other = mail[m.DRIVE_CONTROL_STOP] != J[ACTIVE_REACTION]
    return bool(mail[m.DRIVE_CONTROL_QUICK_STOP] == 1 and other and J[ACTIVE_REACTION] > m.STOP_REACTION_BRAKE)


@compiled
def _hear_control(mail: np.ndarray, K: np.ndarray, J: np.ndarray) -> bool:
    """Take drive_control's levels; answers whether fault_reset rose."""
    if J[TRAVEL_CLEARED] == 1 and not beyond_any_travel(K, J):
        J[TRAVEL_CLEARED] = 0
    if mail[m.DRIVE_CONTROL] == 0:
        return False
    J[CONTROL_AGE] = 0
    # cleared while it is out of travel only: once back inside, the next time is a fault again
    J[TRAVEL_CLEARED] = 1 if mail[m.DRIVE_CONTROL_CLEAR_TRAVEL] == 1 and beyond_any_travel(K, J) else 0
    level = mail[m.DRIVE_CONTROL_FAULT_RESET]
    rose = level == 1 and J[RESET_LEVEL] == 0
    J[RESET_LEVEL] = level
    return bool(rose)


@compiled
def _reaction_to(fault: int, state: int, J: np.ndarray) -> int:
    """Without power there is nothing to stop; a lost link has the reaction that the host chose."""
    if not has_power(state):
        return m.STOP_REACTION_COAST
    if fault == m.FAULT_CODE_DEADMAN or fault == m.FAULT_CODE_COMMUNICATION:
        return int(J[REACTION])
    return int(J[FAULT_REACTION])


@compiled
def _enter(mail: np.ndarray, J: np.ndarray, state: int, cause: int, detail: int) -> None:
    """Go over to a state and tell of it."""
    mail[m.DRIVE_EVENT] = 1
    mail[m.DRIVE_EVENT_FROM_STATE], mail[m.DRIVE_EVENT_TO_STATE] = J[STATE], state
    mail[m.DRIVE_EVENT_CAUSE], mail[m.DRIVE_EVENT_DETAIL] = cause, detail
    mail[m.DRIVE_EVENT_TICK] = J[TICK] & 4095
    J[STATE], J[STATE_AGE] = state, 0
