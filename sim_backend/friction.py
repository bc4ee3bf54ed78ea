"""LuGre friction with the exact bristle update.

The rate is frozen over the step, so the bristle equation is linear and its solution an exponential: stable at any rate and
step (ERRATA, Numerical traps). The torque is the mean over the step, which keeps sigma1 finite at high rates.
Source: Canudas de Wit et al. 1995; thesis eq. 4.1 and 4.2 as corrected in ERRATA.
"""

from __future__ import annotations

import math

from firmware_protocol.compiling import compiled

#: beyond this (|v|/v_s)^delta the Stribeck bump is below 1e-17 of itself
BUMP_GONE = 40.0
#: below this relaxation per step the exponentials are replaced by their series, exact to double precision
_SMALL = 0.02


@compiled
def stribeck_level(speed: float, ts: float, tc: float, vs: float, delta: float) -> float:
    """Steady sliding torque without its viscous part, s(v) = Tc + (Ts - Tc) exp(-(|v|/v_s)^delta), N m."""
    if speed == 0.0:
        return ts
    # the power by exp and log: half the time of the library's own, which guards cases that cannot come here
    return tc + (ts - tc) * math.exp(-math.exp(delta * math.log(speed / vs)))


@compiled
def lugre_step(z: float, v: float, h: float, level: float, sigma0: float, sigma1: float, sigma2: float) -> tuple[float, float]:
    """One step of h seconds at joint rate v and steady level s(v): bristle deflection after it, mean opposing torque during it."""
    if sigma0 == 0.0:
        return 0.0, (level if v > 0.0 else (-level if v < 0.0 else 0.0)) + sigma2 * v
    x = sigma0 * abs(v) / level * h
    if x < _SMALL:
        # fraction = (1 - exp(-x)) / x and half = (1 - fraction) / x, whose closed forms cancel here
        x2 = x * x
        half = (1 / 2 - x * (1 / 6)) + x2 * ((1 / 24 - x * (1 / 120)) + x2 * ((1 / 720 - x * (1 / 5040)) + x2 * (1 / 40320)))
        fraction = 1.0 - x * half
    else:
        inverse = 1.0 / x
        fraction = -math.expm1(-x) * inverse
        half = (1.0 - fraction) * inverse
    z_end = z + (v * h - x * z) * fraction
    z_mean = z * fraction + v * h * half
    return z_end, sigma0 * z_mean + sigma1 * (z_end - z) / h + sigma2 * v
