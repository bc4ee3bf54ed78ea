"""The drive's state machine after CiA 402 (IEC 61800-7-201): who may go where, and the event that tells of it.

At most one transition a tick, so the mail's single `drive_event` tells of every one. Requests act in the tick in which
their frame arrives; a fault outranks them all.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.guards import beyond_any_travel, find_fault, has_power
from sim_backend.device.records import DETAIL_BY_ITSELF, DETAIL_FAULT_RESET, Drive
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


@compiled
def take_set_point(mail: np.ndarray, drive: Drive) -> None:
    """Let the deadman run by one tick, and feed it if a fresh set-point with a new sequence came."""
    margin = drive.margin
    drive.margin = max(margin - 1, 0)
    if mail[m.SET_POINT] == 0:
        return
    sequence = mail[m.SET_POINT_SEQUENCE]
    ahead = (sequence - drive.last_sequence) & 1023
    # a repeat never counts; one from behind only when the deadman has run out, because then it is a host that started
    # anew
    if drive.last_sequence >= 0 and (ahead == 0 or (ahead >= 512 and margin > 0)):
        drive.refused += 1
        return
    drive.taken += 1
    drive.last_sequence, drive.margin = sequence, drive.window
    for axis in range(2):
        joint = drive.joints[axis]
        joint.set_torque = mail[m.SET_POINT_TORQUE_OUTER + axis]
        joint.set_enable = mail[m.SET_POINT_ENABLE_OUTER + axis]


@compiled
def take_deadman_config(mail: np.ndarray, drive: Drive) -> None:
    """Take the host's deadman over, never while it guards torque."""
    if mail[m.DEADMAN_CONFIG] > 0 and not has_power(drive.state) and drive.state != _REACTING:
        drive.window, drive.reaction = mail[m.DEADMAN_CONFIG_WINDOW_TICKS], mail[m.DEADMAN_CONFIG_REACTION]
        drive.margin = min(drive.margin, drive.window)


@compiled
def step_state(mail_in: np.ndarray, mail_out: np.ndarray, K: np.ndarray, drive: Drive) -> None:
    """One tick of the state machine."""
    drive.state_age += 1
    drive.control_age += 1
    reset_edge = _hear_control(mail_in, K, drive)
    count_rest(K, drive)
    state = drive.state
    fault, about = find_fault(K, drive)
    if state == _REACTING:
        if reaction_over(drive):
            _enter(mail_out, drive, _FAULT, drive.fault, drive.fault_detail)
    elif state == _FAULT:
        if reset_edge and fault == m.FAULT_CODE_NONE:
            drive.fault = m.FAULT_CODE_NONE
            _enter(mail_out, drive, _SWITCH_ON_DISABLED, m.FAULT_CODE_NONE, DETAIL_FAULT_RESET)
    elif fault != m.FAULT_CODE_NONE:
        drive.fault, drive.fault_detail = fault, about
        drive.active_reaction = _reaction_to(fault, state, drive)
        begin_stop(K, drive)
        _enter(mail_out, drive, _REACTING, fault, about)
    elif state == _NOT_READY:
        if drive.state_age >= drive.startup_ticks:
            _enter(mail_out, drive, _SWITCH_ON_DISABLED, m.FAULT_CODE_NONE, DETAIL_BY_ITSELF)
    elif mail_in[m.DRIVE_CONTROL] > 0:
        request = mail_in[m.DRIVE_CONTROL_REQUEST]
        if mail_in[m.DRIVE_CONTROL_QUICK_STOP] == 1 and state != _QUICK_STOP:
            request = m.DRIVE_REQUEST_QUICK_STOP
        wanted = destination(state, request, drive.margin > 0)
        if wanted == _QUICK_STOP and (state != _QUICK_STOP or _asks_for_another_stop(mail_in, drive)):
            drive.active_reaction = mail_in[m.DRIVE_CONTROL_STOP]
            begin_stop(K, drive)
        if wanted != state:
            _enter(mail_out, drive, wanted, m.FAULT_CODE_NONE, request)


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
def _asks_for_another_stop(mail: np.ndarray, drive: Drive) -> bool:
    """Whether a quick stop that runs shall go on without the sensor that it uses; one that uses none stays."""
    other = mail[m.DRIVE_CONTROL_STOP] != drive.active_reaction
    return bool(mail[m.DRIVE_CONTROL_QUICK_STOP] == 1 and other and drive.active_reaction > m.STOP_REACTION_BRAKE)


@compiled
def _hear_control(mail: np.ndarray, K: np.ndarray, drive: Drive) -> bool:
    """Take drive_control's levels; answers whether fault_reset rose."""
    if drive.travel_cleared == 1 and not beyond_any_travel(K, drive):
        drive.travel_cleared = 0
    if mail[m.DRIVE_CONTROL] == 0:
        return False
    drive.control_age = 0
    # cleared while it is out of travel only: once back inside, the next time is a fault again
    drive.travel_cleared = 1 if mail[m.DRIVE_CONTROL_CLEAR_TRAVEL] == 1 and beyond_any_travel(K, drive) else 0
    level = mail[m.DRIVE_CONTROL_FAULT_RESET]
    rose = level == 1 and drive.reset_level == 0
    drive.reset_level = level
    return bool(rose)


@compiled
def _reaction_to(fault: int, state: int, drive: Drive) -> int:
    """Without power there is nothing to stop; a lost link has the reaction that the host chose, but a stop that uses no
    sensor goes on: the host had a reason to ask for it before it fell silent.
    """
    if not has_power(state):
        return m.STOP_REACTION_COAST
    if fault == m.FAULT_CODE_DEADMAN or fault == m.FAULT_CODE_COMMUNICATION:
        without_sensor = state == _QUICK_STOP and drive.active_reaction <= m.STOP_REACTION_BRAKE
        return int(drive.active_reaction) if without_sensor else int(drive.reaction)
    return int(drive.fault_reaction)


@compiled
def _enter(mail: np.ndarray, drive: Drive, state: int, cause: int, detail: int) -> None:
    """Go over to a state and tell of it."""
    mail[m.DRIVE_EVENT] = 1
    mail[m.DRIVE_EVENT_FROM_STATE], mail[m.DRIVE_EVENT_TO_STATE] = drive.state, state
    mail[m.DRIVE_EVENT_CAUSE], mail[m.DRIVE_EVENT_DETAIL] = cause, detail
    mail[m.DRIVE_EVENT_TICK] = drive.tick & 4095
    drive.state, drive.state_age = state, 0
