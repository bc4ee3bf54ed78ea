"""Where a request of the host leads, after the state machine of CiA 402."""

from __future__ import annotations

from firmware_protocol.enumerations import DriveRequest, DriveState
from firmware_protocol.messages import DriveControl

_STATE, _REQUEST = DriveState, DriveRequest


def asked_for(control: DriveControl) -> DriveRequest:
    """What the host asks for: the bit for a quick stop outranks the request beside it."""
    return _REQUEST.QUICK_STOP if control.quick_stop else control.request


def destination(state: DriveState, request: DriveRequest) -> DriveState:
    """Where a request leads after CiA 402, without the optional transition 16; enabling is decided by the drives."""
    if request is _REQUEST.DISABLE_VOLTAGE:
        return _STATE.SWITCH_ON_DISABLED
    if request is _REQUEST.QUICK_STOP:
        if state is _STATE.OPERATION_ENABLED:
            return _STATE.QUICK_STOP_ACTIVE
        return state if state is _STATE.QUICK_STOP_ACTIVE else _STATE.SWITCH_ON_DISABLED
    if request is _REQUEST.SHUTDOWN and state is not _STATE.QUICK_STOP_ACTIVE:
        return _STATE.READY_TO_SWITCH_ON
    if request is _REQUEST.SWITCH_ON and state is _STATE.READY_TO_SWITCH_ON:
        return _STATE.SWITCHED_ON
    if request is _REQUEST.DISABLE_OPERATION and state is _STATE.OPERATION_ENABLED:
        return _STATE.SWITCHED_ON
    return state
