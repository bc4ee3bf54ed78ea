"""The twin's inner loop: the model's own laws, driven along the measured motion, and what they leave over.

Bristles, lags, twists and delays are carried along the joint rate that was measured; the torque that the rigid body
would need for the measured acceleration is compared with what actuator, effects and friction give. It is the plant's
step with the acceleration given instead of solved for: the same laws, so an effect is defined once.
"""

from __future__ import annotations

from enum import IntFlag

import numpy as np

from firmware_protocol.compiling import compiled, entry_point
from sim_backend.effects import Hook, encoder_law, gyro_law
from sim_backend.friction_in_force import friction_at
from sim_backend.layout import (
    APPLIED,
    AXES,
    AXIS,
    BODY_RATE,
    BRISTLE,
    CODE,
    GYRO_FILTER,
    GYRO_STATE,
    HOOK_COUNT,
    HOOK_FIRST,
    IN_FORCE,
    IN_FORCE_SIZE,
    INSTANCE,
    INSTANCE_SIZE,
    KIND,
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
from sim_backend.rigid_body import equations_of_motion
from sim_backend.sensors import gyro_reading, gyro_step
from sim_backend.step import advance_structures, joint_torque


class Part(IntFlag):
    """What is evaluated by itself: a joint's torque, and a gyro's rate."""

    JOINT_0 = 1
    JOINT_1 = 2
    GYRO_0 = 4
    GYRO_1 = 8


EVERY_PART = Part.JOINT_0 | Part.JOINT_1 | Part.GYRO_0 | Part.GYRO_1
_JOINT_0, _JOINT_1, _GYRO_0, _GYRO_1 = (int(part) for part in Part)
_STRUCTURE, _ENCODER, _GYRO = int(Hook.STRUCTURE), int(Hook.ENCODER), int(Hook.GYRO)
_GIMBAL = int(PlantKind.GIMBAL)
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
def _gyro(P: np.ndarray, K: np.ndarray, X: np.ndarray, axis: int, steps: int) -> float:
    """What the gyro reads in the middle of an interval, body rates given in X[BODY_RATE:]."""
    b = BODY_RATE + 3 * axis
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
def _lead_bristle(X: np.ndarray, axis: int, torque: float) -> None:
    """Move a standing joint's bristle by so much torque, within break-away."""
    f = IN_FORCE + axis * IN_FORCE_SIZE
    if X[f + SIGMA0] > 0.0:
        most = X[f + TS] / X[f + SIGMA0]
        X[BRISTLE + axis] = min(most, max(-most, X[BRISTLE + axis] + torque / X[f + SIGMA0]))


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
    """Left-over torque and predicted gyro rate of every interval; of the parts that are asked for (`Part`), the others
    stay as they are in `out`.

    torque (n, 2) commanded, N m; motion (n, 8) interval means of q, q, v, v, a, a and how far a standing bristle is led
    per axis; base (n, 9) gravity less the pivot's acceleration, rate and angular acceleration of the base in base axes;
    heat (n, 2) degC. Fills out (6, n): torque given minus torque needed per axis (N m), gyro rate predicted per axis
    (rad/s), torque that the actuator gives per axis (N m). P[STEP_S] times `steps` is the interval.
    """
    h = P[STEP_S]
    two = K[AXES] > 1
    joint0, joint1 = parts & _JOINT_0 != 0, two and parts & _JOINT_1 != 0
    gyro0, gyro1 = parts & _GYRO_0 != 0, two and parts & _GYRO_1 != 0
    for k in range(torque.shape[0]):
        g = (
            (base[k, 0], base[k, 1], base[k, 2]),
            (base[k, 3], base[k, 4], base[k, 5]),
            (base[k, 6], base[k, 7], base[k, 8]),
        )
        q0, v0, a0 = _true_motion(P, K, X, 0, motion[k, 0], motion[k, 2], motion[k, 4])
        q1, v1, a1 = 0.0, 0.0, 0.0
        if two:
            q1, v1, a1 = _true_motion(P, K, X, 1, motion[k, 1], motion[k, 3], motion[k, 5])
        mass, bias, outer, inner, carried = equations_of_motion(P, K, (q0, q1), (v0, v1), g)
        for axis in range(K[AXES]):
            X[TEMPERATURE + axis] = heat[k, axis]
            if K[TEMPERATURE_KNOTS] > 0:
                friction_at(P, K, axis, heat[k, axis], X)
        left0, left1, given0, given1 = 0.0, 0.0, 0.0, 0.0
        for s in range(steps):
            t = (s + 0.5 - 0.5 * steps) * h
            if joint0:
                net, own = joint_torque(P, K, X, 0, h, torque[k, 0], q0 + v0 * t, v0 + a0 * t, mass[0], carried[0])
                given0 += X[APPLIED]
                left0 += net + bias[0] - (mass[0] - own) * a0 - mass[1] * a1
            if joint1:
                net, own = joint_torque(P, K, X, 1, h, torque[k, 1], q1 + v1 * t, v1 + a1 * t, mass[2], carried[1])
                given1 += X[APPLIED + 1]
                left1 += net + bias[1] - (mass[2] - own) * a1 - mass[1] * a0
            if K[HOOK_COUNT + _STRUCTURE] > 0:
                torques = (X[APPLIED], X[APPLIED + 1])
                advance_structures(P, K, X, h, torques, (mass[0], mass[2]), (a0 + carried[0], a1 + carried[1]))
            X[STEPS] += 1.0
        if joint0:
            out[0, k], out[4, k] = left0 / steps, given0 / steps
            if motion[k, 6] > 0.0:
                _lead_bristle(X, 0, motion[k, 6] * out[0, k])
        if joint1:
            out[1, k], out[5, k] = left1 / steps, given1 / steps
            if motion[k, 7] > 0.0:
                _lead_bristle(X, 1, motion[k, 7] * out[1, k])
        X[BODY_RATE], X[BODY_RATE + 1], X[BODY_RATE + 2] = outer
        X[BODY_RATE + 3], X[BODY_RATE + 4], X[BODY_RATE + 5] = inner
        if gyro0:
            out[2, k] = _gyro(P, K, X, 0, steps)
        if gyro1:
            out[3, k] = _gyro(P, K, X, 1, steps)
