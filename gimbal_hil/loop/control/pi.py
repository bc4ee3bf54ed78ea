"""The proportional-integral law and the limits around it."""

from __future__ import annotations

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.control.layout import AntiWindup

_CLAMPING, _BACK_CALCULATION = int(AntiWindup.CLAMPING), int(AntiWindup.BACK_CALCULATION)


@compiled
def clamp(value: float, low: float, high: float) -> float:
    """`value` held within [low, high]; NaN stays NaN, so that the last check before the wire sees it."""
    if value > high:
        return high
    return low if value < low else value


@compiled
def next_integral(
    error: float,
    integral: float,
    kp: float,
    ki: float,
    step_s: float,
    low: float,
    high: float,
    anti_windup: int,
    tracking_s: float,
) -> float:
    """Integral after one step of a PI whose output `kp error + integral` acts within [low, high].

    Clamping stops integration that would push further into the limit and keeps the integral itself within the limits;
    back-calculation bleeds the excess with the time constant `tracking_s` (Astrom and Hagglund 2006, section 3.5).
    """
    growth = ki * step_s * error
    output = kp * error + integral
    if anti_windup == _CLAMPING:
        if (output > high and growth > 0.0) or (output < low and growth < 0.0):
            return integral
        return clamp(integral + growth, low, high)
    if anti_windup == _BACK_CALCULATION:
        return integral + growth + (clamp(output, low, high) - output) * (step_s / tracking_s)
    return integral + growth
