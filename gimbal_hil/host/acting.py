"""From references to torques: what the loops do at one tick while the host is active or stopping."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.control import axis_torque, enter_mode, friction_torque, gravity_torques, has_moments
from gimbal_hil.control.layout import LOOP_ERROR, LOOP_REFERENCE, MOMENT_X, TORQUE, Mode
from gimbal_hil.host.following import set_references, stopping_reference, wanted_mode
from gimbal_hil.host.layout import (
    AXES,
    AXIS_C,
    AXIS_C_SIZE,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    BASE_GRAVITY,
    BASE_RATE,
    BRAKING_RAD_S2,
    FEEDFORWARD,
    MEASURED_POSITION,
    MEASURED_RATE,
    MODE,
    REFERENCE,
    REST_RATE,
    SLOPE,
    STEP_S,
)
from gimbal_hil.host.limits import joint_rate, rates_towards_limits
from gimbal_hil.host.states import number

_OFF, _RATE, _POSITION = number(Mode.OFF), number(Mode.RATE), number(Mode.POSITION)
_INNER_H = AXIS_H + AXIS_H_SIZE
_MOMENTS = (AXIS_C + MOMENT_X, AXIS_C + AXIS_C_SIZE + MOMENT_X)


@compiled
def follow(H: np.ndarray, G: np.ndarray, C: np.ndarray, plan: np.ndarray) -> None:
    """Torques of both axes that follow the segment in force."""
    set_references(H, G, C, plan)
    _set_gravity(H, C)
    for axis in range(AXES):
        _close(wanted_mode(G, plan, axis), H, G, C, axis)


@compiled
def begin_stop(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Take every axis that is under control into its rate loop, from the rate that it has."""
    _set_gravity(H, C)
    for axis in range(AXES):
        if G[AXIS_G + axis * AXIS_G_SIZE + MODE] != _OFF:
            h, c = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
            H[h + REFERENCE] = joint_rate(H, axis)
            enter_mode(H[h + MEASURED_POSITION], H[h + MEASURED_RATE], H[h + BASE_RATE], H[h + FEEDFORWARD], H, h, C, c)
            G[AXIS_G + axis * AXIS_G_SIZE + MODE] = _RATE


@compiled
def slow_down(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> bool:
    """Torques of both axes on the way to rest; answers whether they are at rest."""
    _set_gravity(H, C)
    resting = True
    for axis in range(AXES):
        if G[AXIS_G + axis * AXIS_G_SIZE + MODE] == _RATE:
            h, c = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
            stopping_reference(H, axis, C[c + BRAKING_RAD_S2], C[STEP_S])
            _close(_RATE, H, G, C, axis)
            resting = resting and H[h + REFERENCE] == 0.0 and abs(joint_rate(H, axis)) <= C[c + REST_RATE]
    return resting


@compiled
def let_go(H: np.ndarray, G: np.ndarray) -> None:
    """No torque and no mode on any axis."""
    for axis in range(AXES):
        h = AXIS_H + axis * AXIS_H_SIZE
        H[h + TORQUE] = H[h + LOOP_REFERENCE] = H[h + LOOP_ERROR] = H[h + REFERENCE] = H[h + SLOPE] = 0.0
        G[AXIS_G + axis * AXIS_G_SIZE + MODE] = _OFF


@compiled
def _set_gravity(H: np.ndarray, C: np.ndarray) -> None:
    outer, inner = 0.0, 0.0
    if has_moments(C, _MOMENTS[0], _MOMENTS[1]):
        outer, inner = gravity_torques(
            H[AXIS_H + MEASURED_POSITION],
            H[_INNER_H + MEASURED_POSITION],
            (H[BASE_GRAVITY], H[BASE_GRAVITY + 1], H[BASE_GRAVITY + 2]),
            C,
            _MOMENTS[0],
            _MOMENTS[1],
        )
    H[AXIS_H + FEEDFORWARD], H[_INNER_H + FEEDFORWARD] = outer, inner


@compiled
def _close(mode: int, H: np.ndarray, G: np.ndarray, C: np.ndarray, axis: int) -> None:
    """One axis' torque in `mode`; a mode that was not in force before takes over without a bump."""
    h, c, g = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE, AXIS_G + axis * AXIS_G_SIZE
    if mode == _RATE:
        H[h + FEEDFORWARD] += friction_torque(H[h + REFERENCE], C, c)
    elif mode == _POSITION:
        H[h + FEEDFORWARD] += friction_torque(H[h + SLOPE], C, c)
    position, rate, base_rate, forward = (
        H[h + MEASURED_POSITION],
        H[h + MEASURED_RATE],
        H[h + BASE_RATE],
        H[h + FEEDFORWARD],
    )
    if mode != G[g + MODE]:
        enter_mode(position, rate, base_rate, forward, H, h, C, c)
        G[g + MODE] = mode
    allowed = rates_towards_limits(position, C, c)
    axis_torque(
        mode, H[h + REFERENCE], H[h + SLOPE], position, rate, base_rate, forward, allowed, C[STEP_S], H, h, C, c
    )
