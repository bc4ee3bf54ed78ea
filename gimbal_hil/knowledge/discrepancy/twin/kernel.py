"""The twin's inner loop: the model's own laws, driven along the measured motion, and what they leave over.

Bristles, lags, twists and delays are carried along the joint rate that was measured; the torque that the rigid body
would need for the measured acceleration is compared with what actuator, effects and friction give. It is the plant's
step with the acceleration given instead of solved for: the same laws, so an effect is defined once.

The acceleration is that of positions, which feel torque early in an interval more than torque late in it: where a
drive's torque changes inside its intervals, the change of its first moment from one to the next counts as well.
"""

from __future__ import annotations

from enum import IntFlag

import numpy as np

from firmware_protocol.compiling import compiled, entry_point
from firmware_protocol.elementary import sine_cosine
from sim_backend.effects import Hook, encoder_law, gyro_law
from sim_backend.friction_in_force import Friction, friction_at, friction_in_force
from sim_backend.layout import (
    AXES,
    AXIS,
    BODY_RATE,
    CODE,
    COMMAND_MOMENT,
    GAIN_ERROR,
    GYRO_FILTER,
    GYRO_STATE,
    HOOK_COUNT,
    HOOK_FIRST,
    IN_FORCE,
    IN_FORCE_SIZE,
    INSTANCE,
    INSTANCE_SIZE,
    INSTANCES,
    KIND,
    LAG_DECAY,
    LAG_MEAN,
    PARAMETERS,
    SEED,
    SIGMA0,
    STATES,
    STEP_S,
    STEPS,
    TEMPERATURE,
    TEMPERATURE_KNOTS,
    TS,
    PlantKind,
    axis_block,
)
from sim_backend.rigid_body import Vector, body_numbers, equations_at, outer_turn_counts
from sim_backend.sensors import gyro_reading, gyro_step
from sim_backend.step import advance_structures, joint_law, joint_state


class Part(IntFlag):
    """What is evaluated by itself: a joint's torque, and a gyro's rate."""

    JOINT_0 = 1
    JOINT_1 = 2
    GYRO_0 = 4
    GYRO_1 = 8


EVERY_JOINT = Part.JOINT_0 | Part.JOINT_1
EVERY_PART = EVERY_JOINT | Part.GYRO_0 | Part.GYRO_1
_JOINT_0, _JOINT_1, _GYRO_0, _GYRO_1 = (int(part) for part in Part)
_STRUCTURE, _ENCODER, _GYRO = int(Hook.STRUCTURE), int(Hook.ENCODER), int(Hook.GYRO)
_GIMBAL = int(PlantKind.GIMBAL)
#: places of the lag's state and of the applied torque in `joint_state`
_LAGGED, _TORQUE_NOW = 1, 2
Joint = tuple[float, float, float, float]
_BLOCK = (axis_block(0), axis_block(1))
#: finite step (rad or m) for the slope and curvature of an encoder's error over position
_SLOPE_STEP = 1e-3


@compiled
def _encoder_shift(P: np.ndarray, K: np.ndarray, X: np.ndarray, axis: int, position: float) -> float:
    shift = 0.0
    for i in range(K[HOOK_FIRST + _ENCODER], K[HOOK_FIRST + _ENCODER] + K[HOOK_COUNT + _ENCODER]):
        k = INSTANCE + INSTANCE_SIZE * K[i]
        if K[k + AXIS] == axis:
            shift += encoder_law(K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], position)
    return shift


@compiled
def _true_motion(
    P: np.ndarray, K: np.ndarray, X: np.ndarray, axis: int, q: float, v: float, a: float
) -> tuple[float, float, float]:
    """Joint motion behind an encoder whose error is a function of position."""
    if K[HOOK_COUNT + _ENCODER] == 0:
        return q, v, a
    true = q
    for _ in range(3):
        true = q - _encoder_shift(P, K, X, axis, true)
    before, here, after = (
        _encoder_shift(P, K, X, axis, true - _SLOPE_STEP),
        _encoder_shift(P, K, X, axis, true),
        _encoder_shift(P, K, X, axis, true + _SLOPE_STEP),
    )
    slope = 1.0 + (after - before) / (2.0 * _SLOPE_STEP)
    bend = (after - 2.0 * here + before) / (_SLOPE_STEP * _SLOPE_STEP)
    rate = v / slope
    return true, rate, (a - bend * rate * rate) / slope


@compiled
def _gyro(P: np.ndarray, K: np.ndarray, X: np.ndarray, axis: int, steps: int, turns: Vector) -> float:
    """What the gyro reads in the middle of an interval in which its body turns so."""
    b = BODY_RATE + 3 * axis
    X[b], X[b + 1], X[b + 2] = turns
    rate = X[b + 1] if K[KIND] == _GIMBAL and axis == 1 else X[b + 2]
    block = _BLOCK[0] if axis == 0 else _BLOCK[1]
    state = GYRO_STATE + 2 * axis
    before = X[state]
    for _ in range(steps):
        X[state], X[state + 1] = gyro_step(P, block, (X[state], X[state + 1]), rate)
    after = X[state]
    if P[block + GYRO_FILTER] > 0.0:
        X[state] = 0.5 * (before + after)
    extra = 0.0
    for i in range(K[HOOK_FIRST + _GYRO], K[HOOK_FIRST + _GYRO] + K[HOOK_COUNT + _GYRO]):
        k = INSTANCE + INSTANCE_SIZE * K[i]
        if K[k + AXIS] == axis:
            extra += gyro_law(K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], axis, X[b], X[b + 1], X[b + 2])
    read = gyro_reading(P, block, X, K[SEED], 0, axis, rate + extra)
    X[state] = after
    return read


@compiled
def _warmed(P: np.ndarray, K: np.ndarray, X: np.ndarray, two: bool) -> tuple[Friction, Friction]:
    """Friction in force on both axes at the temperatures in X."""
    friction_at(P, K, 0, X[TEMPERATURE], X)
    if two:
        friction_at(P, K, 1, X[TEMPERATURE + 1], X)
    return friction_in_force(P, X, 0), friction_in_force(P, X, 1)


@compiled
def _shapes(P: np.ndarray, axis: int) -> tuple[float, float]:
    """First moment of what a drive's lag gives in a step, about the middle of it, over the step and over the change of
    the lag's state; and the share of a moment of the command that the drive passes on.
    """
    block = _BLOCK[0] if axis == 0 else _BLOCK[1]
    decay, mean = P[block + LAG_DECAY], P[block + LAG_MEAN]
    passed = 1.0 + P[block + GAIN_ERROR]
    if decay == 0.0:
        return 0.0, passed
    over_lag = (1.0 - decay) / mean
    return (0.5 * mean - (mean - decay) / over_lag) / (1.0 - decay), passed * (1.0 - mean)


@compiled
def _moment(X: np.ndarray, shapes: tuple[float, float], lag_moved: float) -> float:
    """First moment of a drive's torque in the last step, over the step."""
    return X[COMMAND_MOMENT] * shapes[1] + lag_moved * shapes[0]


@compiled
def _taken_off(out: np.ndarray, axis: int, k: int, moment: float, before: tuple[float, float]) -> tuple[float, float]:
    """Moments of this interval and the one before it, of which row k - 1 is told; `before` are those of that row."""
    if k > 1:
        out[axis, k - 1] -= 0.5 * (moment - before[1])
    return moment, before[0]


@compiled
def _led(X: np.ndarray, axis: int, joint: Joint, torque: float) -> Joint:
    """A standing joint (`joint_state`) with its bristle moved by so much torque, within break-away."""
    f = IN_FORCE + axis * IN_FORCE_SIZE
    if X[f + SIGMA0] == 0.0:
        return joint
    most = X[f + TS] / X[f + SIGMA0]
    bristle, lagged, applied, friction = joint
    return min(most, max(-most, bristle + torque / X[f + SIGMA0])), lagged, applied, friction


@entry_point
def balance(
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    steps: int,
    torque: np.ndarray,
    motion: np.ndarray,
    base: np.ndarray,
    heat: np.ndarray,
    parts: int,
    out: np.ndarray,
) -> None:
    """Torque left over and gyro rate predicted in every interval, of the parts that are asked for (`Part`).

    torque (n, 2) commanded, N m; motion (n, 8) as in a `Record`; base (n, 9) gravity less the pivot's acceleration,
    rate and angular acceleration of the base in base axes; heat (n, 2) degC. Fills out (6, n): torque given minus
    torque needed per axis (N m), gyro rate predicted per axis (rad/s), torque that the actuator gives per axis (N m);
    other parts stay as they are. P[STEP_S] times `steps` is the interval.
    """
    # joints, bodies and friction in locals: through X and P each row would wait for the stores of the one before
    h, effects, gimbal, two = P[STEP_S], K[INSTANCES] > 0, K[KIND] == _GIMBAL, K[AXES] > 1
    warms, structures = K[TEMPERATURE_KNOTS] > 0, K[HOOK_COUNT + _STRUCTURE] > 0
    joint0, joint1 = parts & _JOINT_0 != 0, two and parts & _JOINT_1 != 0
    gyro0, gyro1 = parts & _GYRO_0 != 0, two and parts & _GYRO_1 != 0
    body = body_numbers(P, K, (0.0, 1.0))
    state0, state1 = joint_state(X, 0), joint_state(X, 1)
    moments0, moments1 = (0.0, 0.0), (0.0, 0.0)
    force0, force1 = friction_in_force(P, X, 0), friction_in_force(P, X, 1)
    shapes0, shapes1 = _shapes(P, 0), _shapes(P, 1)
    for k in range(torque.shape[0]):
        gravity, rate = (base[k, 0], base[k, 1], base[k, 2]), (base[k, 3], base[k, 4], base[k, 5])
        acceleration = (base[k, 6], base[k, 7], base[k, 8])
        q0, v0, a0 = _true_motion(P, K, X, 0, motion[k, 0], motion[k, 2], motion[k, 4])
        q1, v1, a1 = _true_motion(P, K, X, 1, motion[k, 1], motion[k, 3], motion[k, 5]) if two else (0.0, 0.0, 0.0)
        turning = rate != (0.0, 0.0, 0.0) or acceleration != (0.0, 0.0, 0.0)
        outer_turn = sine_cosine(q0) if outer_turn_counts(gravity, gimbal, turning) else (0.0, 1.0)
        turns = (outer_turn, sine_cosine(q1))
        mass, bias, outer, inner, carried = equations_at(
            P, K, body, turns, (v0, v1), (gravity, rate, acceleration), gimbal, turning
        )
        X[TEMPERATURE], X[TEMPERATURE + 1] = heat[k, 0], heat[k, 1]
        if warms:
            force0, force1 = _warmed(P, K, X, two)
        left0, left1, given0, given1, moment0, moment1 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for s in range(steps):
            t = (s + 0.5 - 0.5 * steps) * h
            if joint0:
                X[COMMAND_MOMENT], lagged = 0.0, state0[_LAGGED]
                net, own, state0 = joint_law(
                    P, K, X, 0, effects, h, torque[k, 0], q0 + v0 * t, v0 + a0 * t, mass[0], carried[0], state0, force0
                )
                given0 += state0[_TORQUE_NOW]
                moment0 += state0[_TORQUE_NOW] * t + h * _moment(X, shapes0, state0[_LAGGED] - lagged)
                left0 += net + bias[0] - (mass[0] - own) * a0 - mass[1] * a1
            if joint1:
                X[COMMAND_MOMENT], lagged = 0.0, state1[_LAGGED]
                net, own, state1 = joint_law(
                    P, K, X, 1, effects, h, torque[k, 1], q1 + v1 * t, v1 + a1 * t, mass[2], carried[1], state1, force1
                )
                given1 += state1[_TORQUE_NOW]
                moment1 += state1[_TORQUE_NOW] * t + h * _moment(X, shapes1, state1[_LAGGED] - lagged)
                left1 += net + bias[1] - (mass[2] - own) * a1 - mass[1] * a0
            if structures:
                torques = (state0[_TORQUE_NOW], state1[_TORQUE_NOW])
                advance_structures(P, K, X, h, torques, (mass[0], mass[2]), (a0 + carried[0], a1 + carried[1]))
            X[STEPS] += 1.0
        if joint0:
            out[0, k], out[4, k] = left0 / steps, given0 / steps
            moments0 = _taken_off(out, 0, k, moment0 / (h * steps * steps), moments0)
            if motion[k, 6] > 0.0:
                state0 = _led(X, 0, state0, motion[k, 6] * out[0, k])
        if joint1:
            out[1, k], out[5, k] = left1 / steps, given1 / steps
            moments1 = _taken_off(out, 1, k, moment1 / (h * steps * steps), moments1)
            if motion[k, 7] > 0.0:
                state1 = _led(X, 1, state1, motion[k, 7] * out[1, k])
        if gyro0:
            out[2, k] = _gyro(P, K, X, 0, steps, outer)
        if gyro1:
            out[3, k] = _gyro(P, K, X, 1, steps, inner)
