"""What holds an axis without torque from the current loop: its shorted winding and its holding brake."""

from __future__ import annotations

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from sim_backend.device.layout import (
    AXIS_J,
    AXIS_J_SIZE,
    BRAKE_AGE,
    BRAKE_COMMAND,
    BRAKE_STATE,
    BRAKE_TICKS,
    HAS_BRAKE,
    REST_COUNT,
    REST_TICKS,
    SET_ENABLE,
    SHORTED,
    STATE,
)
from sim_backend.device.stopping import stop_in_force, stops_by_itself
from sim_backend.layout import AXES, HELD, HELD_AT, POSITION, HeldBy

_SHORTED, _BRAKED = int(HeldBy.SHORTED_WINDING), int(HeldBy.HOLDING_BRAKE)
_OUTER, _INNER = AXIS_J, AXIS_J + AXIS_J_SIZE


@compiled
def take_brake_commands(mail: np.ndarray, J: np.ndarray) -> None:
    """What the host asks of the holding brakes."""
    if mail[m.DRIVE_CONTROL] > 0:
        J[_OUTER + BRAKE_COMMAND], J[_INNER + BRAKE_COMMAND] = (
            mail[m.DRIVE_CONTROL_BRAKE_OUTER],
            mail[m.DRIVE_CONTROL_BRAKE_INNER],
        )


@compiled
def hold_axes(K: np.ndarray, X: np.ndarray, J: np.ndarray) -> None:
    """Short the windings and close or open the brakes for this tick: a brake opens at once and takes BRAKE_TICKS to
    close.
    """
    stop = stop_in_force(K, J)
    # without power the winding is shorted, because nothing else slows an axis that has no brake; one that was told to
    # coast coasts
    stopped = stops_by_itself(J) or J[STATE] == m.DRIVE_STATE_FAULT
    shorted = stop == m.STOP_REACTION_BRAKE if stopped else J[STATE] != m.DRIVE_STATE_OPERATION_ENABLED
    for axis in range(K[AXES]):
        j = AXIS_J + axis * AXIS_J_SIZE
        J[j + SHORTED] = 1 if shorted else 0
        held = _SHORTED if J[j + SHORTED] == 1 else 0
        if J[j + HAS_BRAKE] == 1:
            if not _wants_brake(J, j, stop):
                J[j + BRAKE_STATE], J[j + BRAKE_AGE] = m.BRAKE_STATE_RELEASED, 0
            elif J[j + BRAKE_AGE] < J[BRAKE_TICKS]:
                J[j + BRAKE_AGE] += 1
            elif J[j + BRAKE_STATE] != m.BRAKE_STATE_ENGAGED:
                J[j + BRAKE_STATE] = m.BRAKE_STATE_ENGAGED
                X[HELD_AT + axis] = X[POSITION + axis]
            if J[j + BRAKE_STATE] == m.BRAKE_STATE_ENGAGED:
                held |= _BRAKED
        X[HELD + axis] = held


@compiled
def _wants_brake(J: np.ndarray, j: int, stop: int) -> bool:
    """Whether an axis' brake is to be closed: by command, or by itself whenever nothing else holds the antenna."""
    if J[j + BRAKE_COMMAND] != m.BRAKE_COMMAND_AUTOMATIC:
        return bool(J[j + BRAKE_COMMAND] == m.BRAKE_COMMAND_ENGAGE)
    if J[STATE] == m.DRIVE_STATE_OPERATION_ENABLED:
        # an axis that a plan leaves free beside one under torque may swing
        return bool(J[_OUTER + SET_ENABLE] == 0 and J[_INNER + SET_ENABLE] == 0)
    if stops_by_itself(J) and (stop == m.STOP_REACTION_DECELERATE_AND_HOLD or stop == m.STOP_REACTION_GYRO_STOP):
        # torque stops the axis; the brake closes at rest, while torque still holds it
        return bool(J[REST_COUNT] >= J[REST_TICKS])
    return True
