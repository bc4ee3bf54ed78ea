"""What the host tells the drive besides torque: its way through the CiA 402 states, fault resets, quick stop, the
deadman.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from gimbal_hil.loop.host.identity import is_known
from gimbal_hil.loop.host.layout import (
    AXIS_G,
    AXIS_G_SIZE,
    BRAKED,
    CLEAR_TRAVEL,
    CONTROL_AGE,
    CONTROL_TICKS,
    DEADMAN_REACTION,
    DEADMAN_WINDOW,
    DRIVE_FAULT,
    DRIVE_LIMITS,
    DRIVE_STATE,
    FRESH_IN_A_ROW,
    MAY_RESET,
    RESET_PULSE_TICKS,
    SENT_CONTROL,
    STATE,
    STATE_AGE,
    STOP_KIND,
    STOP_TICKS,
)
from gimbal_hil.loop.host.states import HostState, number

_WAITING, _SYNCHRONISING, _FAULT = number(HostState.WAITING), number(HostState.SYNCHRONISING), number(HostState.FAULT)
_ACTIVE, _STOPPING = number(HostState.ACTIVE), number(HostState.STOPPING)
_TRAVEL_FLAGS = (
    m.LIMIT_FLAGS_OUTER_TRAVEL_LOW
    | m.LIMIT_FLAGS_OUTER_TRAVEL_HIGH
    | m.LIMIT_FLAGS_INNER_TRAVEL_LOW
    | m.LIMIT_FLAGS_INNER_TRAVEL_HIGH
)


@compiled
def may_reset_fault(G: np.ndarray) -> bool:
    """Whether the drive's fault may be reset: what a lost link leaves behind always, anything else when the operator
    asked.
    """
    fault = G[DRIVE_FAULT]
    if fault == m.FAULT_CODE_DEADMAN or fault == m.FAULT_CODE_COMMUNICATION or fault == m.FAULT_CODE_NONE:
        return True
    return bool(G[MAY_RESET] != 0)


@compiled
def next_request(drive_state: int) -> int:
    """The CiA 402 command that brings a drive one state nearer to operation enabled."""
    if drive_state == m.DRIVE_STATE_SWITCH_ON_DISABLED:
        return m.DRIVE_REQUEST_SHUTDOWN
    if drive_state == m.DRIVE_STATE_READY_TO_SWITCH_ON:
        return m.DRIVE_REQUEST_SWITCH_ON
    if drive_state == m.DRIVE_STATE_SWITCHED_ON or drive_state == m.DRIVE_STATE_OPERATION_ENABLED:
        return m.DRIVE_REQUEST_ENABLE_OPERATION
    return m.DRIVE_REQUEST_DISABLE_VOLTAGE if drive_state == m.DRIVE_STATE_QUICK_STOP_ACTIVE else m.DRIVE_REQUEST_NONE


@compiled
def _brake_of(G: np.ndarray, axis: int) -> int:
    """What an axis' holding brake is told: by itself it stays open on an axis that is off beside one under torque."""
    moves = G[STATE] == _ACTIVE or G[STATE] == _STOPPING
    closed = moves and G[AXIS_G + axis * AXIS_G_SIZE + BRAKED] == 1
    return m.BRAKE_COMMAND_ENGAGE if closed else m.BRAKE_COMMAND_AUTOMATIC


@compiled
def send_control(mail: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Put drive_control into the mail when it changed or is due; with it, while synchronising, the deadman's
    configuration.
    """
    request, reset, quick_stop = m.DRIVE_REQUEST_ENABLE_OPERATION, 0, 0
    if G[STATE] == _WAITING:
        request = m.DRIVE_REQUEST_NONE
    elif G[STATE] == _SYNCHRONISING:
        request = next_request(G[DRIVE_STATE])
        if G[DRIVE_STATE] == m.DRIVE_STATE_FAULT and may_reset_fault(G):
            # a pulse, because the drive answers to the edge and a frame may be lost
            reset = (G[STATE_AGE] // int(C[RESET_PULSE_TICKS])) & 1
    elif G[STATE] == _FAULT:
        if G[STATE_AGE] < C[STOP_TICKS]:
            request, quick_stop = m.DRIVE_REQUEST_QUICK_STOP, 1
        else:
            request = m.DRIVE_REQUEST_DISABLE_VOLTAGE
    if (G[DRIVE_LIMITS] & _TRAVEL_FLAGS) == 0:
        G[CLEAR_TRAVEL] = 0
    identify = 0 if is_known(G) else 1
    # asked anew when frames come after silence, because whoever sends them has not heard the request
    asks = 0 if identify == 0 else (2 if G[FRESH_IN_A_ROW] > 0 else 1)
    brake_outer, brake_inner = _brake_of(G, 0), _brake_of(G, 1)
    packed = request + 16 * reset + 32 * quick_stop + 64 * G[CLEAR_TRAVEL] + 128 * asks
    packed += 512 * brake_outer + 2048 * brake_inner
    G[CONTROL_AGE] += 1
    due = packed != G[SENT_CONTROL] or G[CONTROL_AGE] >= C[CONTROL_TICKS]
    mail[m.DRIVE_CONTROL] = 1 if due else 0
    mail[m.DEADMAN_CONFIG] = 1 if due and G[STATE] == _SYNCHRONISING else 0
    if due:
        G[SENT_CONTROL], G[CONTROL_AGE] = packed, 0
        mail[m.DRIVE_CONTROL_REQUEST] = request
        mail[m.DRIVE_CONTROL_FAULT_RESET] = reset
        mail[m.DRIVE_CONTROL_QUICK_STOP] = quick_stop
        mail[m.DRIVE_CONTROL_CLEAR_TRAVEL] = G[CLEAR_TRAVEL]
        mail[m.DRIVE_CONTROL_STOP] = G[STOP_KIND]
        mail[m.DRIVE_CONTROL_BRAKE_OUTER], mail[m.DRIVE_CONTROL_BRAKE_INNER] = brake_outer, brake_inner
        mail[m.DRIVE_CONTROL_IDENTIFY] = identify
        mail[m.DEADMAN_CONFIG_WINDOW_TICKS] = int(C[DEADMAN_WINDOW])
        mail[m.DEADMAN_CONFIG_REACTION] = int(C[DEADMAN_REACTION])
