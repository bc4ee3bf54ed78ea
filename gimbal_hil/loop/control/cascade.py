"""The control law of one axis: position PI on the encoder, rate PI on the gyro, torque out.

Cascade of thesis chapter 5: the position loop asks for a joint rate, the rate loop for a torque. A gyro reads the
inertial rate, so the base rate about the axis is added to a joint rate reference before the two are compared; in
inertial rate hold it is not. All state is in `H` from offset `h`, all parameters in `C` from offset `c`.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control.layout import (
    BASE_RATE_SHARE,
    FILTERED,
    FILTERED_RATE,
    LOOP_ERROR,
    LOOP_REFERENCE,
    POSITION_ANTI_WINDUP,
    POSITION_INTEGRAL,
    POSITION_KI,
    POSITION_KP,
    POSITION_TRACKING,
    PREFILTER_ACCELERATION,
    PREFILTER_CORNER,
    PREFILTER_DECAY,
    PREFILTER_GAIN,
    PREFILTER_RATE,
    RATE_ANTI_WINDUP,
    RATE_FEEDFORWARD,
    RATE_INTEGRAL,
    RATE_KI,
    RATE_KP,
    RATE_REFERENCE_LIMIT,
    RATE_TRACKING,
    SHAPED,
    TORQUE,
    TORQUE_LIMIT,
    TORQUE_SCALE,
    AntiWindup,
    Mode,
)
from gimbal_hil.loop.control.pi import clamp, next_integral

_OFF, _TORQUE, _RATE, _POSITION = int(Mode.OFF), int(Mode.TORQUE), int(Mode.RATE), int(Mode.POSITION)
_NO_ANTI_WINDUP = int(AntiWindup.NONE)


@compiled
def enter_mode(
    position: float, rate: float, base_rate: float, feedforward_nm: float, H: np.ndarray, h: int, C: np.ndarray, c: int
) -> None:
    """Prepare the state so that closing a loop adds nothing of its own: at zero error the first torque is the last one.

    The rate integrator takes over the torque that acts now, the position integrator the joint rate, the prefilter the
    position.
    """
    limit = C[c + TORQUE_LIMIT]
    H[h + RATE_INTEGRAL] = (clamp(H[h + TORQUE], -limit, limit) - feedforward_nm) / C[c + TORQUE_SCALE]
    H[h + POSITION_INTEGRAL] = rate - C[c + BASE_RATE_SHARE] * base_rate
    H[h + FILTERED], H[h + FILTERED_RATE] = position, 0.0


@compiled
def axis_torque(
    mode: int,
    reference: float,
    slope: float,
    position: float,
    rate: float,
    base_rate: float,
    feedforward_nm: float,
    allowed: tuple[float, float],
    step_s: float,
    H: np.ndarray,
    h: int,
    C: np.ndarray,
    c: int,
) -> float:
    """Torque (N m) of one axis for the next tick, within the axis' torque limit.

    `reference` is in the mode's unit (N m, rad/s, rad), `slope` its time derivative; `position` is the encoder's (rad),
    `rate` the gyro's (rad/s), `base_rate` the inertial rate that the axis would have with its joint at rest (rad/s);
    `allowed` is the least and the largest joint rate (rad/s) that the position loop may ask for.
    """
    if mode == _OFF:
        H[h + TORQUE] = H[h + LOOP_REFERENCE] = H[h + LOOP_ERROR] = 0.0
    elif mode == _TORQUE:
        H[h + TORQUE] = clamp(reference, -C[c + TORQUE_LIMIT], C[c + TORQUE_LIMIT])
        H[h + LOOP_REFERENCE], H[h + LOOP_ERROR] = reference, 0.0
    elif mode == _POSITION:
        _follow_position(
            reference,
            slope,
            position,
            rate,
            C[c + BASE_RATE_SHARE] * base_rate,
            feedforward_nm,
            allowed,
            step_s,
            H,
            h,
            C,
            c,
        )
    else:
        wanted = reference
        if mode == _RATE:
            wanted += C[c + BASE_RATE_SHARE] * base_rate
        H[h + LOOP_REFERENCE], H[h + LOOP_ERROR] = reference, wanted - rate
        _follow_rate(wanted - rate, feedforward_nm, step_s, H, h, C, c)
    return float(H[h + TORQUE])


@compiled
def _follow_position(
    reference: float,
    slope: float,
    position: float,
    rate: float,
    base_rate: float,
    feedforward_nm: float,
    allowed: tuple[float, float],
    step_s: float,
    H: np.ndarray,
    h: int,
    C: np.ndarray,
    c: int,
) -> None:
    """Position PI to a rate reference, through the prefilter, then the rate loop."""
    wanted, wanted_slope = reference, slope
    if C[c + PREFILTER_CORNER] > 0.0 and C[c + SHAPED] == 0.0:
        # with the slope the filter knows where a moving reference will be: it delays steps, not motions
        ahead = C[c + RATE_FEEDFORWARD] * slope / C[c + PREFILTER_CORNER]
        gap = C[c + PREFILTER_GAIN] * (reference + ahead) - H[h + FILTERED]
        wanted_slope = C[c + PREFILTER_CORNER] * gap
        if C[c + PREFILTER_ACCELERATION] > 0.0:
            wanted_slope = _feasible_slope(gap, H[h + FILTERED_RATE], step_s, C, c)
            H[h + FILTERED] += wanted_slope * step_s
        else:
            H[h + FILTERED] += (1.0 - C[c + PREFILTER_DECAY]) * gap
        H[h + FILTERED_RATE] = wanted_slope
        wanted = H[h + FILTERED]
    else:
        H[h + FILTERED] = reference
    error = wanted - position
    H[h + LOOP_REFERENCE], H[h + LOOP_ERROR] = wanted, error
    forward = C[c + RATE_FEEDFORWARD] * wanted_slope
    low, high = max(-C[c + RATE_REFERENCE_LIMIT], allowed[0]), min(C[c + RATE_REFERENCE_LIMIT], allowed[1])
    rate_reference = clamp(C[c + POSITION_KP] * error + H[h + POSITION_INTEGRAL] + forward, low, high)
    pushed = _follow_rate(rate_reference + base_rate - rate, feedforward_nm, step_s, H, h, C, c)
    anti_windup = int(C[c + POSITION_ANTI_WINDUP])
    # a torque at its limit cannot answer a larger rate reference: integrating on would only wind up
    if anti_windup == _NO_ANTI_WINDUP or pushed * error <= 0.0:
        H[h + POSITION_INTEGRAL] = next_integral(
            error,
            H[h + POSITION_INTEGRAL],
            C[c + POSITION_KP],
            C[c + POSITION_KI],
            step_s,
            low - forward,
            high - forward,
            anti_windup,
            C[c + POSITION_TRACKING],
        )


@compiled
def _feasible_slope(gap: float, last: float, step_s: float, C: np.ndarray, c: int) -> float:
    """Slope (rad/s) of the prefilter's output that closes a gap (rad) within its limits: the filter's own near the end,
    from where it would brake too hard the speed from which the acceleration allowed just comes to rest.
    """
    corner, most = C[c + PREFILTER_CORNER], C[c + PREFILTER_ACCELERATION]
    size, near = abs(gap), most / (corner * corner)
    speed = corner * size if size <= near else math.sqrt(2.0 * most * (size - 0.5 * near))
    slope = math.copysign(min(speed, C[c + PREFILTER_RATE]), gap)
    return clamp(slope, last - most * step_s, last + most * step_s)


@compiled
def _follow_rate(
    error: float, feedforward_nm: float, step_s: float, H: np.ndarray, h: int, C: np.ndarray, c: int
) -> int:
    """Rate PI to torque; answers the side (-1, 0, 1) on which the torque is limited."""
    limit, scale = C[c + TORQUE_LIMIT], C[c + TORQUE_SCALE]
    kp, integral = C[c + RATE_KP], H[h + RATE_INTEGRAL]
    torque = scale * (kp * error + integral) + feedforward_nm
    H[h + TORQUE] = clamp(torque, -limit, limit)
    H[h + RATE_INTEGRAL] = next_integral(
        error,
        integral,
        kp,
        C[c + RATE_KI],
        step_s,
        (-limit - feedforward_nm) / scale,
        (limit - feedforward_nm) / scale,
        int(C[c + RATE_ANTI_WINDUP]),
        C[c + RATE_TRACKING],
    )
    if torque > limit:
        return 1
    return -1 if torque < -limit else 0
