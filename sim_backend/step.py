"""Plant steps: from the commanded torques to the motion some steps later.

Second order in the step: leapfrog in position with the velocity-dependent torques taken at the rate predicted for the
middle of the step. Everything is a function of (P, K, X); nothing is allocated.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.actuator import actuate
from sim_backend.base_motion import base_at_rest, base_state
from sim_backend.effects import (
    Hook,
    command_law,
    encoder_law,
    friction_law,
    gyro_law,
    structure_advance,
    structure_law,
    torque_law,
)
from sim_backend.friction import bristle_step, without_bristles
from sim_backend.friction_in_force import Friction, friction_at, friction_in_force
from sim_backend.layout import (
    ACCELERATION,
    AMBIENT,
    APPLIED,
    AXES,
    AXIS,
    AXIS_BLOCK,
    AXIS_SIZE,
    BASE_KIND,
    BODY_RATE,
    BRAKE_DAMPING,
    BRAKE_STIFFNESS,
    BRAKE_TORQUE,
    BRISTLE,
    CODE,
    FRICTION,
    GYRO_STATE,
    HEATING,
    HELD,
    HELD_AT,
    HOOK_COUNT,
    HOOK_FIRST,
    INSTANCE,
    INSTANCE_SIZE,
    INSTANCES,
    KIND,
    LAGGED,
    PARAMETERS,
    POSITION,
    RATE,
    SEED,
    SHORT_DAMPING,
    SLIPS,
    STATES,
    STEP_S,
    STEPS,
    STEPS_PER_TICK,
    STOP_DAMPING,
    STOP_HIGH,
    STOP_LOW,
    STOP_STIFFNESS,
    TEMPERATURE,
    TEMPERATURE_KNOTS,
    THERMAL_TIME_S,
    BaseKind,
    HeldBy,
    PlantKind,
)
from sim_backend.rigid_body import (
    body_numbers,
    equations_at,
    expand_turns,
    outer_turn_counts,
    turn_by,
    turn_centre,
    turned_from,
)
from sim_backend.sensors import encoder_reading, gyro_reading, gyro_step
from sim_backend.stribeck_expansion import bump_share
from sim_backend.thesis_slips import slip_torque

_COMMAND, _FRICTION, _TORQUE, _STRUCTURE = int(Hook.COMMAND), int(Hook.FRICTION), int(Hook.TORQUE), int(Hook.STRUCTURE)
_ENCODER, _GYRO = int(Hook.ENCODER), int(Hook.GYRO)
_SHORTED, _BRAKED = int(HeldBy.SHORTED_WINDING), int(HeldBy.HOLDING_BRAKE)
_GIMBAL, _FIXED = int(PlantKind.GIMBAL), int(BaseKind.FIXED)
#: place of the applied torque in `joint_state`
_TORQUE_NOW = 2
Pair = tuple[float, float]


@compiled
def advance(P: np.ndarray, K: np.ndarray, X: np.ndarray, command: Pair, steps: int) -> None:
    """Advance the plant by steps of P[STEP_S] seconds under commanded torques (N m) held over them; `begin_tick` comes
    before.
    """
    held = X[HELD] > 0.0 or X[HELD + 1] > 0.0
    if K[KIND] == _GIMBAL and K[BASE_KIND] == _FIXED and K[INSTANCES] == 0 and K[SLIPS] == 0 and not held:
        _advance(P, K, X, command, steps, True)
    else:
        _advance(P, K, X, command, steps, False)


@compiled
def _advance(P: np.ndarray, K: np.ndarray, X: np.ndarray, command: Pair, steps: int, plain: bool) -> None:
    """The steps themselves; `plain` is a literal, so that the compiler leaves out what a gimbal without effects, slips,
    brakes or a moving base does not have. The state is in locals from step to step: through X each step would wait for
    the stores of the one before.
    """
    effects, slips = not plain and K[INSTANCES] > 0, not plain and K[SLIPS] != 0
    turning, held = not plain and K[BASE_KIND] != _FIXED, not plain and (X[HELD] > 0.0 or X[HELD + 1] > 0.0)
    gimbal, two = plain or K[KIND] == _GIMBAL, plain or K[AXES] > 1
    h = P[STEP_S]
    half = 0.5 * h
    v0, v1, a0, a1 = X[RATE], X[RATE + 1], X[ACCELERATION], X[ACCELERATION + 1]
    joint0, joint1 = joint_state(X, 0), joint_state(X, 1)
    in_force0, in_force1 = friction_in_force(P, X, 0), friction_in_force(P, X, 1)
    gyro0, gyro1 = gyro_state(X, 0), gyro_state(X, 1)
    # positions count from where the tick began; d0, d1 are those in the middle of a step, which advance by the rate
    # after it
    centre0, centre1 = turn_centre(X, 0), turn_centre(X, 1)
    d0, d1 = (X[POSITION] - centre0[0]) + half * v0, (X[POSITION + 1] - centre1[0]) + half * v1
    body = body_numbers(P, K, centre1[1:])
    base = base_at_rest(P)
    done = X[STEPS]
    for _ in range(steps):
        q = (centre0[0] + d0, centre1[0] + d1)
        v = (v0 + half * a0, v1 + half * a1)
        if turning:
            base = base_state(P, K, (done + 0.5) * h)
        turns = ((0.0, 1.0), turn_by(d1))
        if outer_turn_counts(base[0], gimbal, turning):
            turns = (turned_from(centre0, d0), turns[1])
        mass, bias, outer_rate, inner_rate, carried = equations_at(P, K, body, turns, v, base, gimbal, turning)
        if slips:
            extra = slip_torque(P, K, q, v, base)
            bias = (bias[0] + extra[0], bias[1] + extra[1])
        if held:
            bias = (bias[0] + _holding_torque(P, X, 0, q[0], v[0]), bias[1] + _holding_torque(P, X, 1, q[1], v[1]))
        net0, own0, joint0 = joint_law(
            P, K, X, 0, effects, h, command[0], q[0], v[0], mass[0], carried[0], joint0, in_force0
        )
        if two:
            net1, own1, joint1 = joint_law(
                P, K, X, 1, effects, h, command[1], q[1], v[1], mass[2], carried[1], joint1, in_force1
            )
            m11, m12, m22 = mass[0] - own0, mass[1], mass[2] - own1
            b0, b1 = net0 + bias[0], net1 + bias[1]
            inverse = 1.0 / (m11 * m22 - m12 * m12)
            a0, a1 = (m22 * b0 - m12 * b1) * inverse, (m11 * b1 - m12 * b0) * inverse
        else:
            a0 = (net0 + bias[0]) / (mass[0] - own0)
        if effects:
            torques = (joint0[_TORQUE_NOW], joint1[_TORQUE_NOW])
            advance_structures(P, K, X, h, torques, (mass[0], mass[2]), (a0 + carried[0], a1 + carried[1]))
        d0, d1 = (d0 + h * v0) + (h * h) * a0, (d1 + h * v1) + (h * h) * a1
        v0, v1 = v0 + h * a0, v1 + h * a1
        done += 1.0
        if effects:
            X[STEPS] = done
        gyro0 = gyro_step(P, AXIS_BLOCK, gyro0, outer_rate[2])
        if two:
            gyro1 = gyro_step(P, AXIS_BLOCK + AXIS_SIZE, gyro1, inner_rate[1])
    X[POSITION], X[POSITION + 1] = centre0[0] + (d0 - half * v0), centre1[0] + (d1 - half * v1)
    X[RATE], X[RATE + 1], X[ACCELERATION], X[ACCELERATION + 1] = v0, v1, a0, a1
    X[STEPS] = done
    put_joint_state(X, 0, joint0)
    put_joint_state(X, 1, joint1)
    X[GYRO_STATE], X[GYRO_STATE + 1] = gyro0
    X[GYRO_STATE + 2], X[GYRO_STATE + 3] = gyro1


@compiled
def joint_state(X: np.ndarray, axis: int) -> tuple[float, float, float, float]:
    """Of one joint: bristle deflection, state of the actuator's lag, applied torque and friction over the last step."""
    return X[BRISTLE + axis], X[LAGGED + axis], X[APPLIED + axis], X[FRICTION + axis]


@compiled
def put_joint_state(X: np.ndarray, axis: int, joint: tuple[float, float, float, float]) -> None:
    """The reverse of `joint_state`."""
    X[BRISTLE + axis], X[LAGGED + axis], X[APPLIED + axis], X[FRICTION + axis] = joint


@compiled
def joint_law(
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    axis: int,
    effects: bool,
    h: float,
    command: float,
    q: float,
    v: float,
    inertia: float,
    inertial_acceleration: float,
    joint: tuple[float, float, float, float],
    in_force: Friction,
) -> tuple[float, float, tuple[float, float, float, float]]:
    """Net torque of actuator, effects and friction at one joint (N m), the inertia that does not move with it (kg m^2),
    and its `joint_state` after the step. `effects` False leaves them out at no cost; `in_force` is what
    `friction_in_force` answers.
    """
    block = AXIS_BLOCK + axis * AXIS_SIZE
    if effects and K[HOOK_COUNT + _COMMAND] > 0:
        for i in range(K[HOOK_FIRST + _COMMAND], K[HOOK_FIRST + _COMMAND] + K[HOOK_COUNT + _COMMAND]):
            k = INSTANCE + INSTANCE_SIZE * K[i]
            if K[k + AXIS] == axis:
                command = command_law(K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], K, command, q, v)
    torque, lagged = actuate(P, block, joint[1], command)
    ts, tc, sigma2, relaxation, per_vs, delta, gone, sigma0, sigma1_per_step, tabled = in_force
    if effects and K[HOOK_COUNT + _FRICTION] > 0:
        for i in range(K[HOOK_FIRST + _FRICTION], K[HOOK_FIRST + _FRICTION] + K[HOOK_COUNT + _FRICTION]):
            k = INSTANCE + INSTANCE_SIZE * K[i]
            if K[k + AXIS] == axis:
                ts, tc, sigma2 = friction_law(
                    K[k + CODE],
                    P,
                    K[k + PARAMETERS],
                    X,
                    K[k + STATES],
                    q,
                    v,
                    torque,
                    X[TEMPERATURE + axis],
                    ts,
                    tc,
                    sigma2,
                )
        relaxation = sigma0 * h / tc if tc > 0.0 else 0.0
    speed = abs(v)
    level = tc
    if speed <= gone:
        level = tc + (ts - tc) * bump_share(P, axis, tabled, speed * per_vs, delta)
        if sigma0 > 0.0:
            relaxation = sigma0 * h / level
    if sigma0 > 0.0:
        z, friction = bristle_step(joint[0], v, h, relaxation, sigma0, sigma1_per_step, sigma2)
    else:
        z, friction = 0.0, without_bristles(v, level, sigma2)
    after = (z, lagged, torque, friction)
    # friction, stops and joint-side effects act on the joint; what a structure passes on of the motor's torque comes
    # last
    net = -friction
    if P[block + STOP_STIFFNESS] > 0.0:
        net += _stop_torque(P, block, q, v)
    taken_off = 0.0
    if effects and K[HOOK_COUNT + _TORQUE] > 0:
        for i in range(K[HOOK_FIRST + _TORQUE], K[HOOK_FIRST + _TORQUE] + K[HOOK_COUNT + _TORQUE]):
            k = INSTANCE + INSTANCE_SIZE * K[i]
            if K[k + AXIS] == axis:
                net += torque_law(K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], q, v, h)
    if effects and K[HOOK_COUNT + _STRUCTURE] > 0:
        for i in range(K[HOOK_FIRST + _STRUCTURE], K[HOOK_FIRST + _STRUCTURE] + K[HOOK_COUNT + _STRUCTURE]):
            k = INSTANCE + INSTANCE_SIZE * K[i]
            if K[k + AXIS] == axis:
                torque, inertia_off = structure_law(
                    K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], torque, inertia, inertial_acceleration
                )
                taken_off += inertia_off
    return torque + net, taken_off, after


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
    """`joint_law` of a joint whose state is in X."""
    joint, in_force, effects = joint_state(X, axis), friction_in_force(P, X, axis), K[INSTANCES] > 0
    net, own, joint = joint_law(
        P, K, X, axis, effects, h, command, q, v, inertia, inertial_acceleration, joint, in_force
    )
    put_joint_state(X, axis, joint)
    return net, own


@compiled
def gyro_state(X: np.ndarray, axis: int) -> tuple[float, float]:
    """State of an axis' gyro."""
    return X[GYRO_STATE + 2 * axis], X[GYRO_STATE + 2 * axis + 1]


@compiled
def advance_structures(
    P: np.ndarray, K: np.ndarray, X: np.ndarray, h: float, torque: Pair, inertia: Pair, acceleration: Pair
) -> None:
    """Hidden states of the structure effects after a step with these torques (N m), inertias (kg m^2) and accelerations
    (rad/s^2).
    """
    for i in range(K[HOOK_FIRST + _STRUCTURE], K[HOOK_FIRST + _STRUCTURE] + K[HOOK_COUNT + _STRUCTURE]):
        k = INSTANCE + INSTANCE_SIZE * K[i]
        axis = K[k + AXIS]
        structure_advance(
            K[k + CODE], P, K[k + PARAMETERS], X, K[k + STATES], torque[axis], inertia[axis], acceleration[axis], h
        )


@compiled
def _stop_torque(P: np.ndarray, block: int, q: float, v: float) -> float:
    if q > P[block + STOP_HIGH]:
        return min(0.0, -P[block + STOP_STIFFNESS] * (q - P[block + STOP_HIGH]) - P[block + STOP_DAMPING] * v)
    if q < P[block + STOP_LOW]:
        return max(0.0, -P[block + STOP_STIFFNESS] * (q - P[block + STOP_LOW]) - P[block + STOP_DAMPING] * v)
    return 0.0


@compiled
def _holding_torque(P: np.ndarray, X: np.ndarray, axis: int, q: float, v: float) -> float:
    """Torque of a shorted winding and of a holding brake: a stiff spring and damper that slip at the brake's torque."""
    block, held = AXIS_BLOCK + axis * AXIS_SIZE, int(X[HELD + axis])
    torque = -P[block + SHORT_DAMPING] * v if held & _SHORTED else 0.0
    if held & _BRAKED:
        most = P[block + BRAKE_TORQUE]
        spring = -P[block + BRAKE_STIFFNESS] * (q - X[HELD_AT + axis])
        if abs(spring) > most:
            spring = most if spring > 0.0 else -most
            X[HELD_AT + axis] = q + spring / P[block + BRAKE_STIFFNESS]
        torque += min(max(spring - P[block + BRAKE_DAMPING] * v, -most), most)
    return torque


@compiled
def begin_tick(P: np.ndarray, K: np.ndarray, X: np.ndarray) -> None:
    """Once a tick: sine and cosine expand about the present position, temperatures advance, friction in force follows
    its table.
    """
    expand_turns(X, _outer_counts(P, K))
    tick_s = P[STEP_S] * K[STEPS_PER_TICK]
    for axis in range(K[AXES]):
        block = AXIS_BLOCK + axis * AXIS_SIZE
        if P[block + THERMAL_TIME_S] > 0.0:
            share = min(1.0, tick_s / P[block + THERMAL_TIME_S])
            settled = (
                P[block + AMBIENT]
                + P[block + HEATING] * P[block + THERMAL_TIME_S] * X[APPLIED + axis] * X[APPLIED + axis]
            )
            X[TEMPERATURE + axis] += share * (settled - X[TEMPERATURE + axis])
        if K[TEMPERATURE_KNOTS] > 0:
            friction_at(P, K, axis, X[TEMPERATURE + axis], X)


@compiled
def _outer_counts(P: np.ndarray, K: np.ndarray) -> bool:
    """Whether the equations will ask for sine and cosine of the outer position at any time."""
    return outer_turn_counts(base_at_rest(P)[0], K[KIND] == _GIMBAL, K[BASE_KIND] != _FIXED)


@compiled
def plant_tick(P: np.ndarray, K: np.ndarray, X: np.ndarray, command: tuple[float, float]) -> None:
    """Advance by one tick: K[STEPS_PER_TICK] steps under the same command."""
    begin_tick(P, K, X)
    advance(P, K, X, command, K[STEPS_PER_TICK])


@compiled
def observed_tick(P: np.ndarray, K: np.ndarray, X: np.ndarray, command: tuple[float, float]) -> None:
    """`plant_tick` without the short cut for a plant that has nothing extra: half the time to compile."""
    begin_tick(P, K, X)
    _advance(P, K, X, command, K[STEPS_PER_TICK], False)


@compiled
def true_rates(P: np.ndarray, K: np.ndarray, X: np.ndarray) -> None:
    """Inertial body rates at this instant into X[BODY_RATE:BODY_RATE + 6]."""
    base = base_state(P, K, X[STEPS] * P[STEP_S])
    expand_turns(X, _outer_counts(P, K))
    turns = (turn_centre(X, 0)[1:], turn_centre(X, 1)[1:])
    body, gimbal, turning = body_numbers(P, K, (0.0, 1.0)), K[KIND] == _GIMBAL, K[BASE_KIND] != _FIXED
    _, _, outer, inner, _ = equations_at(P, K, body, turns, (X[RATE], X[RATE + 1]), base, gimbal, turning)
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
