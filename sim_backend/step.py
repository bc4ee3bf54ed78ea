"""One plant step: from the commanded torques to the motion one step later.

Second order in the step: leapfrog in position with the velocity-dependent torques taken at the rate predicted for the
middle of the step. Everything is a function of (P, K, X); nothing is allocated.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.actuator import actuate
from sim_backend.base_motion import base_state
from sim_backend.effects.dispatch import command_law, encoder_law, friction_law, gyro_law, structure_advance, structure_law, torque_law
from sim_backend.effects.effect import Hook
from sim_backend.friction import BUMP_GONE, lugre_step, stribeck_level
from sim_backend.layout import (
    ACCELERATION,
    AMBIENT,
    APPLIED,
    AXES,
    AXIS,
    AXIS_BLOCK,
    AXIS_SIZE,
    BODY_RATE,
    BRISTLE,
    BUMP_GONE_SPEED,
    CODE,
    DELTA,
    FRICTION,
    HEATING,
    HOOK_COUNT,
    HOOK_FIRST,
    IN_FORCE,
    IN_FORCE_SIZE,
    INSTANCE,
    INSTANCE_SIZE,
    INSTANCES,
    KIND,
    KNOT_SIZE,
    KNOTS,
    MAX_KNOTS,
    PARAMETERS,
    POSITION,
    RATE,
    SEED,
    SIGMA0,
    SIGMA1,
    SIGMA2,
    SLIPS,
    STATES,
    STEP_S,
    STEPS,
    STEPS_PER_TICK,
    STOP_DAMPING,
    STOP_HIGH,
    STOP_LOW,
    STOP_STIFFNESS,
    TC,
    TEMPERATURE,
    TEMPERATURE_KNOTS,
    THERMAL_TIME_S,
    TS,
    VS,
    PlantKind,
)
from sim_backend.rigid_body import equations_at, equations_of_motion, expand_turns, turns_near
from sim_backend.sensors import encoder_reading, gyro_reading, gyro_step
from sim_backend.thesis_slips import slip_torque

_COMMAND, _FRICTION, _TORQUE, _STRUCTURE = int(Hook.COMMAND), int(Hook.FRICTION), int(Hook.TORQUE), int(Hook.STRUCTURE)
_ENCODER, _GYRO = int(Hook.ENCODER), int(Hook.GYRO)
_GIMBAL = int(PlantKind.GIMBAL)


@compiled
def plant_step(P: np.ndarray, K: np.ndarray, X: np.ndarray, command: tuple[float, float]) -> None:
    """Advance the plant by one step of P[STEP_S] seconds under commanded torques (N m) held over it."""
    h = P[STEP_S]
    q = (X[POSITION] + 0.5 * h * X[RATE], X[POSITION + 1] + 0.5 * h * X[RATE + 1])
    v = (X[RATE] + 0.5 * h * X[ACCELERATION], X[RATE + 1] + 0.5 * h * X[ACCELERATION + 1])
    base = base_state(P, K, (X[STEPS] + 0.5) * h)
    turns = (turns_near(X, 0, q[0]), turns_near(X, 1, q[1]))
    mass, bias, outer_rate, inner_rate, axis_acceleration = equations_at(P, K, turns, v, base)
    if K[SLIPS] != 0:
        extra = slip_torque(P, K, q, v, base)
        bias = (bias[0] + extra[0], bias[1] + extra[1])
    net0, own0 = joint_torque(P, K, X, 0, h, command[0], q[0], v[0], mass[0], axis_acceleration[0])
    if K[AXES] > 1:
        net1, own1 = joint_torque(P, K, X, 1, h, command[1], q[1], v[1], mass[2], axis_acceleration[1])
        m11, m12, m22 = mass[0] - own0, mass[1], mass[2] - own1
        b0, b1 = net0 + bias[0], net1 + bias[1]
        inverse = 1.0 / (m11 * m22 - m12 * m12)
        a0, a1 = (m22 * b0 - m12 * b1) * inverse, (m11 * b1 - m12 * b0) * inverse
    else:
        a0, a1 = (net0 + bias[0]) / (mass[0] - own0), 0.0
    if K[HOOK_COUNT + _STRUCTURE] > 0:
        advance_structures(P, K, X, h, (mass[0], mass[2]), (a0 + axis_acceleration[0], a1 + axis_acceleration[1]))
    X[POSITION] += h * (X[RATE] + 0.5 * h * a0)
    X[POSITION + 1] += h * (X[RATE + 1] + 0.5 * h * a1)
    X[RATE] += h * a0
    X[RATE + 1] += h * a1
    X[ACCELERATION], X[ACCELERATION + 1] = a0, a1
    X[STEPS] += 1.0
    half = 0.5 * h
    gyro_step(P, AXIS_BLOCK, X, 0, outer_rate[2] + half * a0)
    if K[AXES] > 1:
        gyro_step(P, AXIS_BLOCK + AXIS_SIZE, X, 1, inner_rate[1] + half * a1)


@compiled
def joint_torque(
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    axis: int,
    h: float,
    command: float,
    q: float,
    v: float,
    inertia: float,
    inertial_acceleration: float,
) -> tuple[float, float]:
    """Net torque of actuator, effects and friction at one joint (N m), and the inertia that does not move with it (kg m^2)."""
    block = AXIS_BLOCK + axis * AXIS_SIZE
    f = IN_FORCE + axis * IN_FORCE_SIZE
    effects = K[INSTANCES] > 0
    if effects and K[HOOK_COUNT + _COMMAND] > 0:
        for i in range(K[HOOK_FIRST + _COMMAND], K[HOOK_FIRST + _COMMAND] + K[HOOK_COUNT + _COMMAND]):
            k = INSTANCE + INSTANCE_SIZE * K[i]
            if K[k + AXIS] == axis:
                command = command_law(K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], K, command, q, v)
    torque = actuate(P, block, X, axis, command)
    ts, tc, sigma2 = X[f + TS], X[f + TC], X[f + SIGMA2]
    if effects and K[HOOK_COUNT + _FRICTION] > 0:
        for i in range(K[HOOK_FIRST + _FRICTION], K[HOOK_FIRST + _FRICTION] + K[HOOK_COUNT + _FRICTION]):
            k = INSTANCE + INSTANCE_SIZE * K[i]
            if K[k + AXIS] == axis:
                ts, tc, sigma2 = friction_law(
                    K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], q, v, torque, X[TEMPERATURE + axis], ts, tc, sigma2
                )
    X[APPLIED + axis] = torque
    speed = abs(v)
    level = tc if speed > X[f + BUMP_GONE_SPEED] else stribeck_level(speed, ts, tc, X[f + VS], X[f + DELTA])
    X[BRISTLE + axis], friction = lugre_step(X[BRISTLE + axis], v, h, level, X[f + SIGMA0], X[f + SIGMA1], sigma2)
    X[FRICTION + axis] = friction
    # friction, stops and joint-side effects act on the joint; what a structure passes on of the motor's torque comes last
    joint = -friction
    if P[block + STOP_STIFFNESS] > 0.0:
        joint += _stop_torque(P, block, q, v)
    if effects and K[HOOK_COUNT + _TORQUE] > 0:
        for i in range(K[HOOK_FIRST + _TORQUE], K[HOOK_FIRST + _TORQUE] + K[HOOK_COUNT + _TORQUE]):
            k = INSTANCE + INSTANCE_SIZE * K[i]
            if K[k + AXIS] == axis:
                joint += torque_law(K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], q, v, h)
    taken_off = 0.0
    if effects and K[HOOK_COUNT + _STRUCTURE] > 0:
        for i in range(K[HOOK_FIRST + _STRUCTURE], K[HOOK_FIRST + _STRUCTURE] + K[HOOK_COUNT + _STRUCTURE]):
            k = INSTANCE + INSTANCE_SIZE * K[i]
            if K[k + AXIS] == axis:
                torque, inertia_off = structure_law(
                    K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], torque, inertia, inertial_acceleration
                )
                taken_off += inertia_off
    return torque + joint, taken_off


@compiled
def advance_structures(
    P: np.ndarray, K: np.ndarray, X: np.ndarray, h: float, inertia: tuple[float, float], acceleration: tuple[float, float]
) -> None:
    for i in range(K[HOOK_FIRST + _STRUCTURE], K[HOOK_FIRST + _STRUCTURE] + K[HOOK_COUNT + _STRUCTURE]):
        k = INSTANCE + INSTANCE_SIZE * K[i]
        axis = K[k + AXIS]
        structure_advance(K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], X[APPLIED + axis], inertia[axis], acceleration[axis], h)


@compiled
def _stop_torque(P: np.ndarray, block: int, q: float, v: float) -> float:
    if q > P[block + STOP_HIGH]:
        return min(0.0, -P[block + STOP_STIFFNESS] * (q - P[block + STOP_HIGH]) - P[block + STOP_DAMPING] * v)
    if q < P[block + STOP_LOW]:
        return max(0.0, -P[block + STOP_STIFFNESS] * (q - P[block + STOP_LOW]) - P[block + STOP_DAMPING] * v)
    return 0.0


@compiled
def begin_tick(P: np.ndarray, K: np.ndarray, X: np.ndarray) -> None:
    """Once a tick: sine and cosine expand about the present position, temperatures advance, friction in force follows its table."""
    expand_turns(X)
    for axis in range(K[AXES]):
        block = AXIS_BLOCK + axis * AXIS_SIZE
        if P[block + THERMAL_TIME_S] > 0.0:
            share = min(1.0, P[STEP_S] * K[STEPS_PER_TICK] / P[block + THERMAL_TIME_S])
            settled = P[block + AMBIENT] + P[block + HEATING] * P[block + THERMAL_TIME_S] * X[APPLIED + axis] * X[APPLIED + axis]
            X[TEMPERATURE + axis] += share * (settled - X[TEMPERATURE + axis])
        if K[TEMPERATURE_KNOTS] > 0:
            friction_at(P, K, axis, X[TEMPERATURE + axis], X)


@compiled
def friction_at(P: np.ndarray, K: np.ndarray, axis: int, temperature: float, X: np.ndarray) -> None:
    """Put friction at a temperature (degC) in force: linear between the knots of the model's table, held beyond its ends."""
    first = KNOTS + axis * MAX_KNOTS * KNOT_SIZE
    last = first + (K[TEMPERATURE_KNOTS] - 1) * KNOT_SIZE
    knot = first
    while knot + KNOT_SIZE < last and P[knot + KNOT_SIZE] <= temperature:
        knot += KNOT_SIZE
    after = min(knot + KNOT_SIZE, last)
    width = P[after] - P[knot]
    share = min(1.0, max(0.0, (temperature - P[knot]) / width)) if width > 0.0 else 0.0
    for i in range(KNOT_SIZE - 1):
        X[IN_FORCE + axis * IN_FORCE_SIZE + i] = P[knot + 1 + i] + share * (P[after + 1 + i] - P[knot + 1 + i])
    put_bump_gone(X, axis)


@compiled
def put_bump_gone(X: np.ndarray, axis: int) -> None:
    """Speed beyond which the Stribeck bump of the friction in force is nothing, so that its power need not be computed."""
    f = IN_FORCE + axis * IN_FORCE_SIZE
    X[f + BUMP_GONE_SPEED] = X[f + VS] * BUMP_GONE ** (1.0 / X[f + DELTA])


@compiled
def plant_tick(P: np.ndarray, K: np.ndarray, X: np.ndarray, command: tuple[float, float]) -> None:
    """Advance by one tick: K[STEPS_PER_TICK] steps under the same command."""
    begin_tick(P, K, X)
    for _ in range(K[STEPS_PER_TICK]):
        plant_step(P, K, X, command)


@compiled
def true_rates(P: np.ndarray, K: np.ndarray, X: np.ndarray) -> None:
    """Inertial body rates at this instant into X[BODY_RATE:BODY_RATE + 6]."""
    base = base_state(P, K, X[STEPS] * P[STEP_S])
    _, _, outer, inner, _ = equations_of_motion(P, K, (X[POSITION], X[POSITION + 1]), (X[RATE], X[RATE + 1]), base)
    X[BODY_RATE], X[BODY_RATE + 1], X[BODY_RATE + 2] = outer
    X[BODY_RATE + 3], X[BODY_RATE + 4], X[BODY_RATE + 5] = inner


@compiled
def read_encoder(P: np.ndarray, K: np.ndarray, X: np.ndarray, axis: int, tick: int) -> float:
    """Encoder position of an axis at this instant, rad."""
    position = X[POSITION + axis]
    shift = 0.0
    for i in range(K[HOOK_FIRST + _ENCODER], K[HOOK_FIRST + _ENCODER] + K[HOOK_COUNT + _ENCODER]):
        k = INSTANCE + INSTANCE_SIZE * K[i]
        if K[k + AXIS] == axis:
            shift += encoder_law(K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], position)
    return encoder_reading(P, AXIS_BLOCK + axis * AXIS_SIZE, K[SEED], tick, axis, position + shift)


@compiled
def read_gyro(P: np.ndarray, K: np.ndarray, X: np.ndarray, axis: int, tick: int) -> float:
    """Gyro rate of an axis at this instant, rad/s; `true_rates` must have been called for this instant."""
    b = BODY_RATE + 3 * axis
    rate = X[b + 1] if K[KIND] == _GIMBAL and axis == 1 else X[b + 2]
    extra = 0.0
    for i in range(K[HOOK_FIRST + _GYRO], K[HOOK_FIRST + _GYRO] + K[HOOK_COUNT + _GYRO]):
        k = INSTANCE + INSTANCE_SIZE * K[i]
        if K[k + AXIS] == axis:
            extra += gyro_law(K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], axis, X[b], X[b + 1], X[b + 2])
    return gyro_reading(P, AXIS_BLOCK + axis * AXIS_SIZE, X, K[SEED], tick, axis, rate + extra)
