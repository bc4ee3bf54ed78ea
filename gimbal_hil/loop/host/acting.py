"""From references to torques: what the loops do at one tick while the host is active or stopping."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control import (
    ADAPT_SHARE,
    BRISTLE,
    DELAY_TICKS,
    DISTRUST,
    DRAG,
    FORESEEN,
    FORWARD,
    FRICTION_FORWARD,
    INERTIA,
    LAST_FEEDBACK,
    LEARNS,
    LOOP_ERROR,
    LOOP_REFERENCE,
    MOMENT_X,
    MOVED_INERTIA,
    NAMED_FORWARD,
    SHAKES,
    SHAPED,
    SHAPED_ACCELERATION,
    SHAPED_POSITION,
    SHAPED_RATE,
    SLIDING_LEVEL,
    TORQUE,
    UNCHANGED,
    VISCOUS_LEVEL,
    WATCH_SHARE,
    Mode,
    adapt_friction,
    axis_torque,
    carry_on,
    enter_mode,
    fade_model,
    friction_torque,
    gravity_torques,
    has_moments,
    has_new_levels,
    is_observed,
    judge_model,
    learn,
    learned_torque,
    leave_observer,
    modelled_friction,
    named_torque,
    observe,
    observed_torque,
    remember_torque,
    rigid_torques,
    shape_position,
    start_observing,
    start_shaping,
)
from gimbal_hil.loop.host.event_ring import report
from gimbal_hil.loop.host.following import set_references, stopping_reference, wanted_mode
from gimbal_hil.loop.host.layout import (
    AXES,
    AXIS_C,
    AXIS_C_SIZE,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    BASE_FELT,
    BASE_GRAVITY,
    BASE_NOW,
    BASE_RATE,
    BASE_RATES,
    BASE_TURNING,
    BRAKING_RAD_S2,
    CURVE,
    EXTRA_PERIODS,
    EXTRAPOLATES_BASE,
    FEEDFORWARD,
    FEEDS_BODIES,
    MEASURED_POSITION,
    MEASURED_RATE,
    MODE,
    MODEL_BODY,
    MODEL_TENSOR,
    MOTOR_TEMPERATURE,
    REFERENCE,
    REST_RATE,
    SKIPPED,
    SLOPE,
    STEP_S,
    TEMPERATURE_HEARD,
)
from gimbal_hil.loop.host.limits import braking, joint_rate, rates_towards_limits
from gimbal_hil.loop.host.states import NOTHING, EventCode, number

_OFF, _RATE, _POSITION = number(Mode.OFF), number(Mode.RATE), number(Mode.POSITION)
_MODEL, _LEVELS = number(EventCode.MODEL), number(EventCode.FRICTION_LEVELS)
#: temperature of a motor that tells none: what the model's numbers hold for
_UNTOLD_DEGC = 20.0
#: more ticks than this in a row are not carried over
_MOST_CARRIED = 64
_INNER_H = AXIS_H + AXIS_H_SIZE
_MOMENTS = (AXIS_C + MOMENT_X, AXIS_C + AXIS_C_SIZE + MOMENT_X)


@compiled
def follow(H: np.ndarray, G: np.ndarray, C: np.ndarray, plan: np.ndarray) -> None:
    """Torques of both axes that follow the segment in force."""
    _carry_over(H, G, C)
    set_references(H, G, C, plan)
    _feed_forward(wanted_mode(G, plan, 0), wanted_mode(G, plan, 1), H, G, C)
    for axis in range(AXES):
        _close(wanted_mode(G, plan, axis), H, G, C, axis)


@compiled
def _carry_over(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Carry the observers over what passed between the last two samples: ticks of the host, and periods of the antenna,
    whose clock is its own.
    """
    for _ in range(min(G[SKIPPED] + G[EXTRA_PERIODS], _MOST_CARRIED)):
        carry_estimates(H, G, C)


@compiled
def carry_estimates(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Carry the observers over a tick without a sample, in which torque is held."""
    for axis in range(AXES):
        h, c = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
        if is_observed(H, h, C, c) and G[AXIS_G + axis * AXIS_G_SIZE + MODE] >= _RATE:
            carry_on(H[h + BASE_RATE], C[STEP_S], H, h, C, c)


@compiled
def slow_down(begins: bool, H: np.ndarray, G: np.ndarray, C: np.ndarray) -> bool:
    """Torques of both axes on the way to rest; answers whether they are at rest. As it `begins` every axis that is
    under control is taken into its rate loop, from the rate that it has.
    """
    _carry_over(H, G, C)
    if begins:
        for axis in range(AXES):
            if G[AXIS_G + axis * AXIS_G_SIZE + MODE] != _OFF:
                h = AXIS_H + axis * AXIS_H_SIZE
                # until now it may have been a position or a torque, and what is fed forward reads it
                H[h + REFERENCE], H[h + SLOPE] = joint_rate(H, axis), 0.0
    _feed_forward(_braking_mode(G, 0), _braking_mode(G, 1), H, G, C)
    resting = True
    for axis in range(AXES):
        if G[AXIS_G + axis * AXIS_G_SIZE + MODE] != _OFF:
            h, c = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
            if begins:
                _enter(_RATE, H, G, C, axis)
            stopping_reference(H, axis, C[c + BRAKING_RAD_S2], C[STEP_S])
            _close(_RATE, H, G, C, axis)
            resting = resting and H[h + REFERENCE] == 0.0 and abs(joint_rate(H, axis)) <= C[c + REST_RATE]
    return resting


@compiled
def _braking_mode(G: np.ndarray, axis: int) -> int:
    """An axis that is off stays off while the other one brakes."""
    return _OFF if G[AXIS_G + axis * AXIS_G_SIZE + MODE] == _OFF else _RATE


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
    if C[c + SHAPED] == 0.0:
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
    observed = is_observed(H, h, C, c) and mode >= _RATE
    if mode != G[g + MODE]:
        _enter(mode, H, G, C, axis)
    allowed = rates_towards_limits(position, braking(H, C, h, c), C, c)
    if observed:
        observe(position, rate, base_rate, C[STEP_S], H, h, C, c)
        observed_torque(mode, H[h + REFERENCE], base_rate, allowed, C[STEP_S], H, h, C, c)
        remember_torque(H, h)
        _learn(mode, H, G, C, axis)
        _watch(True, mode, H, G, C, axis)
        return
    reference, slope = H[h + REFERENCE], H[h + SLOPE]
    if mode == _POSITION and C[c + SHAPED] > 0.0:
        reference, slope = H[h + SHAPED_POSITION], H[h + SHAPED_RATE]
    axis_torque(mode, reference, slope, position, rate, base_rate, forward, allowed, C[STEP_S], H, h, C, c)
    _learn(mode, H, G, C, axis)
    _watch(False, mode, H, G, C, axis)


@compiled
def _learn(mode: int, H: np.ndarray, G: np.ndarray, C: np.ndarray, axis: int) -> None:
    """Take what the loops added to the torque that was fed forward into table and levels, where the joint's rate is the
    reference's.
    """
    h, c = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
    if (C[c + LEARNS] == 0.0 and C[c + ADAPT_SHARE] == 0.0) or (mode != _RATE and mode != _POSITION):
        return
    lacking = H[h + TORQUE] - H[h + DRAG] - H[h + MOVED_INERTIA] * H[h + SHAPED_ACCELERATION]
    learn(lacking, C[STEP_S], H, h, C, c)
    adapt_friction(lacking, H, h, C, c)
    if C[c + ADAPT_SHARE] > 0.0 and has_new_levels(H, h):
        sliding, viscous = 1.0 + H[h + SLIDING_LEVEL], 1.0 + H[h + VISCOUS_LEVEL]
        report(G, _LEVELS, axis, int(1000.0 * sliding + 0.5), int(1000.0 * viscous + 0.5))


@compiled
def _watch(observed: bool, mode: int, H: np.ndarray, G: np.ndarray, C: np.ndarray, axis: int) -> None:
    """Judge the model by the torque of this tick, and say what changed."""
    h, c = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
    if C[c + WATCH_SHARE] == 0.0 or mode < _RATE:
        return
    news = judge_model(observed, C[FEEDS_BODIES] > 0.0, H, h, C, c)
    if news == SHAKES:
        leave_observer(H, h, C, c)
    if news != UNCHANGED:
        report(G, _MODEL, axis, news, NOTHING)


@compiled
def _enter(mode: int, H: np.ndarray, G: np.ndarray, C: np.ndarray, axis: int) -> None:
    """Have an axis' loops go on in `mode` from the torque that acts."""
    h, c, g = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE, AXIS_G + axis * AXIS_G_SIZE
    position, rate, base_rate = H[h + MEASURED_POSITION], H[h + MEASURED_RATE], H[h + BASE_RATE]
    enter_mode(position, rate, base_rate, H[h + FEEDFORWARD], H, h, C, c)
    if is_observed(H, h, C, c) and G[g + MODE] < _RATE <= mode:
        start_observing(position, rate, base_rate, C[STEP_S], H, h)
    # what another mode asked for and fed back says nothing of what this one will
    H[h + FORESEEN] = H[h + LAST_FEEDBACK] = np.nan
    G[g + MODE] = mode


@compiled
def _feed_forward(mode_outer: int, mode_inner: int, H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """What both axes are given in advance in these modes: their weight, or with a model all that the motion takes."""
    _set_gravity(H, C)
    for axis in range(AXES):
        mode, h, c = (mode_inner if axis else mode_outer), AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
        if C[c + SHAPED] > 0.0:
            _shape(mode, G[AXIS_G + axis * AXIS_G_SIZE + MODE], H, h, C, c)
    if C[FEEDS_BODIES] > 0.0:
        _set_rigid(H, C)
    for axis in range(AXES):
        mode, h, c = (mode_inner if axis else mode_outer), AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
        if C[c + SHAPED] > 0.0:
            if C[FEEDS_BODIES] == 0.0:
                H[h + MOVED_INERTIA] = C[c + INERTIA]
            if mode >= _RATE:
                _add_friction_and_position(H, h, C, c)
            _fade_or_feed(mode, H, h, C, c)


@compiled
def _add_friction_and_position(H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    """Feed forward what depends on one joint's own rate and position, at where it is when the torque acts."""
    ahead = C[c + DELAY_TICKS] * C[STEP_S]
    rate = H[h + SHAPED_RATE] + ahead * H[h + SHAPED_ACCELERATION]
    if C[c + FRICTION_FORWARD] > 0.0:
        temperature = H[h + MOTOR_TEMPERATURE] if H[h + TEMPERATURE_HEARD] > 0.0 else _UNTOLD_DEGC
        H[h + FEEDFORWARD] += modelled_friction(rate, temperature, C[STEP_S], H, h, C, c)
    else:
        H[h + FEEDFORWARD] += friction_torque(rate, C, c)
    position = H[h + SHAPED_POSITION] + ahead * H[h + SHAPED_RATE]
    if C[c + NAMED_FORWARD] > 0.0:
        H[h + FEEDFORWARD] += named_torque(position, C, c)
    if C[c + LEARNS] > 0.0:
        H[h + FEEDFORWARD] += learned_torque(position, rate, H, h, C, c)


@compiled
def _fade_or_feed(mode: int, H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    """What of the model's torque is fed forward, by how far it is trusted."""
    observed = is_observed(H, h, C, c) and mode >= _RATE
    drag = H[h + FEEDFORWARD]
    accelerating = H[h + MOVED_INERTIA] * H[h + SHAPED_ACCELERATION] if C[FEEDS_BODIES] > 0.0 else 0.0
    if C[c + WATCH_SHARE] > 0.0:
        H[h + FORWARD] = drag + accelerating
        fade_model(observed, drag, H, h, C, c)
    trust = 1.0 - H[h + DISTRUST]
    H[h + DRAG] = trust * drag
    # a cascade without observer gets the whole torque in advance, an observer adds what accelerates itself
    H[h + FEEDFORWARD] = H[h + DRAG] if observed else trust * (drag + accelerating)


@compiled
def _shape(mode: int, before: int, H: np.ndarray, h: int, C: np.ndarray, c: int) -> None:
    """Shaped reference of an axis that was in mode `before`; in a mode of a rate its integral is nowhere needed."""
    if mode != before:
        start_shaping(H[h + MEASURED_POSITION], H, h)
    if before < _RATE:
        # from one closed loop to the other the friction that is fed forward stays as it is
        H[h + BRISTLE] = 0.0
    if mode == _POSITION:
        shape_position(H[h + REFERENCE], H[h + SLOPE], H[h + CURVE], C[STEP_S], H, h, C, c)
    elif mode == _RATE:
        H[h + SHAPED_POSITION] = H[h + MEASURED_POSITION]
        H[h + SHAPED_RATE], H[h + SHAPED_ACCELERATION] = H[h + REFERENCE], H[h + SLOPE]
    else:
        H[h + SHAPED_POSITION] = H[h + MEASURED_POSITION]
        H[h + SHAPED_RATE], H[h + SHAPED_ACCELERATION] = H[h + MEASURED_RATE] - H[h + BASE_RATE], 0.0


@compiled
def _set_rigid(H: np.ndarray, C: np.ndarray) -> None:
    """Weight, coupling and base motion of both bodies by the model, at where the references are when torque acts."""
    outer, inner = AXIS_H, _INNER_H
    ahead = C[AXIS_C + DELAY_TICKS] * C[STEP_S]
    ahead_inner = C[AXIS_C + AXIS_C_SIZE + DELAY_TICKS] * C[STEP_S]
    q = (
        H[outer + SHAPED_POSITION] + ahead * H[outer + SHAPED_RATE],
        (H[inner + SHAPED_POSITION] + ahead_inner * H[inner + SHAPED_RATE]),
    )
    a = H[outer + SHAPED_ACCELERATION], H[inner + SHAPED_ACCELERATION]
    v = H[outer + SHAPED_RATE] + ahead * a[0], H[inner + SHAPED_RATE] + ahead_inner * a[1]
    gravity, rates, turning = BASE_GRAVITY, BASE_RATES, BASE_TURNING
    if C[EXTRAPOLATES_BASE] > 0.0:
        gravity, rates = BASE_FELT, BASE_NOW
    base = (
        (H[gravity], H[gravity + 1], H[gravity + 2]),
        (H[rates], H[rates + 1], H[rates + 2]),
        (H[turning], H[turning + 1], H[turning + 2]),
    )
    drag, moved = rigid_torques(C[MODEL_TENSOR:], C[MODEL_BODY:], q, v, a, base)
    H[outer + FEEDFORWARD], H[inner + FEEDFORWARD] = drag
    H[outer + MOVED_INERTIA], H[inner + MOVED_INERTIA] = moved
