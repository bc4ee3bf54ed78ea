"""LuGre friction with the exact bristle update.

The rate is frozen over the step, so the bristle equation is linear and its solution an exponential: stable at any rate and
step (ERRATA, Numerical traps). The torque is the mean over the step, which keeps sigma1 finite at high rates.
Source: Canudas de Wit et al. 1995; thesis eq. 4.1 and 4.2 as corrected in ERRATA.
"""

from __future__ import annotations

import math

from firmware_protocol.compiling import compiled

#: beyond this (|v|/v_s)^delta the Stribeck bump is below 1e-17 of itself
_BUMP_GONE = 40.0
#: below this relaxation per step the exponentials are replaced by their series, exact to double precision
_SMALL = 1e-2


@compiled
def stribeck_level(speed: float, ts: float, tc: float, vs: float, delta: float) -> float:
    """Steady sliding torque without its viscous part, s(v) = Tc + (Ts - Tc) exp(-(|v|/v_s)^delta), N m."""
    if speed == 0.0:
        return ts
    exponent = (speed / vs) ** delta
    if exponent > _BUMP_GONE:
        return tc
    return tc + (ts - tc) * math.exp(-exponent)


@compiled
def lugre_step(
    z: float, v: float, h: float, ts: float, tc: float, vs: float, sigma0: float, sigma1: float, sigma2: float, delta: float
) -> tuple[float, float]:
    """One step of h seconds at joint rate v: bristle deflection after it, and the mean opposing torque during it."""
    speed = abs(v)
    if sigma0 == 0.0:
        return 0.0, _sign(v) * stribeck_level(speed, ts, tc, vs, delta) + sigma2 * v
    relaxation = sigma0 * speed / stribeck_level(speed, ts, tc, vs, delta) * h
    if relaxation < _SMALL:
        x = relaxation
        # (1 - exp(-x)) / x and its mean-value companion (x - 1 + exp(-x)) / x^2
        fraction = 1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0)))))
        half = 0.5 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0 * (1.0 - x / 8.0))))))
    else:
        fraction = -math.expm1(-relaxation) / relaxation
        half = (1.0 - fraction) / relaxation
    z_end = z + (v * h - relaxation * z) * fraction
    z_mean = z * fraction + v * h * half
    return z_end, sigma0 * z_mean + sigma1 * (z_end - z) / h + sigma2 * v


@compiled
def _sign(v: float) -> float:
    return 1.0 if v > 0.0 else (-1.0 if v < 0.0 else 0.0)
