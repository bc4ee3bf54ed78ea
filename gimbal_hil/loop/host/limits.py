"""The host's own guards on an axis: speed, following error, gyro against encoder, travel, cable wrap, winding
temperature.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control import LOOP_ERROR, RATE_REFERENCE_LIMIT, TORQUE_LIMIT, Mode
from gimbal_hil.loop.host.event_ring import report
from gimbal_hil.loop.host.layout import (
    AXES,
    AXIS_C,
    AXIS_C_SIZE,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    BASE_RATE,
    BRAKING_RAD_S2,
    DEBOUNCE_TICKS,
    DISAGREE_COUNT,
    DISTURBANCE,
    ENCODER_RATE,
    EXPECTED_INERTIA,
    FOLLOWING_COUNT,
    FOLLOWING_TICKS,
    GYRO_RATE,
    LEAST_BRAKING_SHARE,
    MAX_DISAGREEMENT,
    MAX_FOLLOWING_POSITION,
    MAX_FOLLOWING_RATE,
    MAX_RATE,
    MAX_TEMPERATURE,
    MEASURED_POSITION,
    MEASURED_RATE,
    MODE,
    MOMENTUM_WINDOW_S,
    MOTOR_TEMPERATURE,
    OUTSIDE,
    OVERSPEED_COUNT,
    POSITION_HIGH,
    POSITION_LOW,
    PULL,
    REST_RATE,
    STEP_S,
    TRAVEL_MARGIN,
    WRAP_HIGH,
    WRAP_LOW,
)
from gimbal_hil.loop.host.plausibility import implausible
from gimbal_hil.loop.host.states import NOTHING, YES, EventCode, HostCause, number

_NONE, _TRAVEL, _WRAP = number(HostCause.NONE), number(HostCause.TRAVEL), number(HostCause.CABLE_WRAP)
_OVERSPEED, _FOLLOWING = number(HostCause.OVERSPEED), number(HostCause.FOLLOWING_ERROR)
_DISAGREE, _TEMPERATURE = number(HostCause.GYRO_ENCODER_DISAGREE), number(HostCause.TEMPERATURE)
_OFF, _POSITION, _RATE = number(Mode.OFF), number(Mode.POSITION), number(Mode.RATE)
_TRIPPED, _BEYOND_LIMIT = number(EventCode.TRIPPED), number(EventCode.BEYOND_LIMIT)


@compiled
def joint_rate(H: np.ndarray, axis: int) -> float:
    """Joint rate (rad/s) of an axis from its gyro, the base rate taken off."""
    h = AXIS_H + axis * AXIS_H_SIZE
    return float(H[h + MEASURED_RATE] - H[h + BASE_RATE])


@compiled
def _moving_rate(H: np.ndarray, C: np.ndarray, axis: int) -> float:
    """Joint rate above the noise of its sensor: the gyro's, or for a slow creep the encoder's; 0 at rest."""
    rest = C[AXIS_C + axis * AXIS_C_SIZE + REST_RATE]
    rate = joint_rate(H, axis)
    if abs(rate) > rest:
        return rate
    creep = H[AXIS_H + axis * AXIS_H_SIZE + ENCODER_RATE]
    return float(creep) if abs(creep) > 0.1 * rest else 0.0


@compiled
def braking(H: np.ndarray, C: np.ndarray, h: int, c: int) -> float:
    """Deceleration (rad/s^2) that the axis at `h` and `c` can be counted on: the configured one, or what its torque
    limit leaves of it beside disturbance and weight; of both only known with an expectation.
    """
    asked, inertia = C[c + BRAKING_RAD_S2], C[c + EXPECTED_INERTIA]
    if inertia == 0.0:
        return float(asked)
    left = C[c + TORQUE_LIMIT] - C[c + DISTURBANCE] / MOMENTUM_WINDOW_S - H[h + PULL]
    return float(min(asked, max(left / inertia, LEAST_BRAKING_SHARE * asked)))


@compiled
def fault_of(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> int:
    """The HostCause that any axis has for a fault at this fresh sample, NONE when all is well."""
    for axis in range(AXES):
        cause = _fault_of_axis(H, G, C, axis)
        if cause != _NONE:
            report(G, _TRIPPED, cause, axis, NOTHING)
            return cause
    return _NONE


@compiled
def stop_cause(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> int:
    """The HostCause to stop now: an axis whose braking distance reaches a limit; NONE when there is none."""
    for axis in range(AXES):
        cause = limit_ahead(H, G, C, axis)
        if cause != _NONE:
            report(G, _TRIPPED, cause, axis, YES)
            return cause
    return _NONE


@compiled
def limit_ahead(H: np.ndarray, G: np.ndarray, C: np.ndarray, axis: int) -> int:
    """The HostCause of the limit that an axis' braking distance reaches; NONE when there is none."""
    h, c = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE
    rate = _moving_rate(H, C, axis)
    # an axis that is off cannot be braked: it may swing where it likes
    if rate == 0.0 or G[AXIS_G + axis * AXIS_G_SIZE + MODE] == _OFF:
        return _NONE
    # the loop needs a few ticks before the torque brakes
    distance = rate * rate / (2.0 * braking(H, C, h, c)) + 3.0 * abs(rate) * C[STEP_S]
    if G[AXIS_G + axis * AXIS_G_SIZE + MODE] == _POSITION:
        # the reference ends at the limit: only its overshoot may lead beyond
        distance -= 0.5 * C[c + TRAVEL_MARGIN]
    return _reached(H[h + MEASURED_POSITION], rate, distance, C, c)


@compiled
def rates_towards_limits(position: float, braking_rad_s2: float, C: np.ndarray, c: int) -> tuple[float, float]:
    """Joint rates (rad/s) down and up from which an axis can still brake before its limits, with half the deceleration
    kept back, and within what the position loop may ask for at all.
    """
    below = position - max(C[c + POSITION_LOW], C[c + WRAP_LOW])
    above = min(C[c + POSITION_HIGH], C[c + WRAP_HIGH]) - position
    limit = C[c + RATE_REFERENCE_LIMIT]
    return -_rate_before(below, braking_rad_s2, limit), _rate_before(above, braking_rad_s2, limit)


@compiled
def _rate_before(distance: float, braking_rad_s2: float, limit: float) -> float:
    """Least of the loop's own limit and the rate that half the deceleration brings to rest within a distance."""
    square = braking_rad_s2 * max(distance, 0.0)
    # far from the limit no root has to be waited for
    return float(math.sqrt(square) if square < limit * limit else limit)


@compiled
def forget_counts(G: np.ndarray) -> None:
    """Begin to count anew, when loops are closed."""
    for axis in range(AXES):
        g = AXIS_G + axis * AXIS_G_SIZE
        G[g + OVERSPEED_COUNT] = G[g + FOLLOWING_COUNT] = G[g + DISAGREE_COUNT] = 0


@compiled
def report_beyond_limits(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Say once when an axis without torque goes past a soft limit: it falls, or somebody turns it."""
    for axis in range(AXES):
        position, c, g = (
            H[AXIS_H + axis * AXIS_H_SIZE + MEASURED_POSITION],
            AXIS_C + axis * AXIS_C_SIZE,
            AXIS_G + axis * AXIS_G_SIZE,
        )
        outside = 0
        if G[g + MODE] == _OFF:
            outside = 1 if position > C[c + POSITION_HIGH] else (-1 if position < C[c + POSITION_LOW] else 0)
        if outside != 0 and outside != G[g + OUTSIDE]:
            report(G, _BEYOND_LIMIT, axis, 1 if outside > 0 else 0, NOTHING)
        G[g + OUTSIDE] = outside


@compiled
def _reached(position: float, rate: float, distance: float, C: np.ndarray, c: int) -> int:
    if rate > 0.0:
        if position + distance > C[c + POSITION_HIGH]:
            return _TRAVEL
        return _WRAP if position + distance > C[c + WRAP_HIGH] else _NONE
    if position - distance < C[c + POSITION_LOW]:
        return _TRAVEL
    return _WRAP if position - distance < C[c + WRAP_LOW] else _NONE


@compiled
def _counted(G: np.ndarray, slot: int, failed: bool) -> int:
    G[slot] = G[slot] + 1 if failed else 0
    return int(G[slot])


@compiled
def _fault_of_axis(H: np.ndarray, G: np.ndarray, C: np.ndarray, axis: int) -> int:
    h, c, g = AXIS_H + axis * AXIS_H_SIZE, AXIS_C + axis * AXIS_C_SIZE, AXIS_G + axis * AXIS_G_SIZE
    rate = joint_rate(H, axis)
    if _counted(G, g + OVERSPEED_COUNT, abs(rate) > C[c + MAX_RATE]) >= C[DEBOUNCE_TICKS]:
        return _OVERSPEED
    disagreement = abs(H[h + ENCODER_RATE] - H[h + GYRO_RATE])
    if _counted(G, g + DISAGREE_COUNT, disagreement > C[c + MAX_DISAGREEMENT]) >= C[DEBOUNCE_TICKS]:
        return _DISAGREE
    limit = C[c + MAX_FOLLOWING_POSITION] if G[g + MODE] == _POSITION else C[c + MAX_FOLLOWING_RATE]
    following = G[g + MODE] >= _RATE and abs(H[h + LOOP_ERROR]) > limit
    if _counted(G, g + FOLLOWING_COUNT, following) >= C[FOLLOWING_TICKS]:
        return _FOLLOWING
    cause = implausible(H, G, C, axis)
    if cause != _NONE:
        return cause
    if _moving_rate(H, C, axis) != 0.0 and G[g + MODE] != _OFF:
        # outside and still going out; on the way back an axis may be outside
        cause = _reached(H[h + MEASURED_POSITION], _moving_rate(H, C, axis), -C[c + TRAVEL_MARGIN], C, c)
        if cause != _NONE:
            return cause
    return _TEMPERATURE if H[h + MOTOR_TEMPERATURE] > C[c + MAX_TEMPERATURE] else _NONE
