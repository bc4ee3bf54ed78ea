"""LuGre friction with the exact bristle update.

The rate is frozen over the step, so the bristle equation is linear and its solution an exponential: stable at any rate
and step (docs/explanation/reading-the-thesis.md). The torque is the mean over the step, which keeps sigma1 finite at
high rates. Source: Canudas de Wit et al. 1995; thesis eq. 4.1 and 4.2 as corrected in
docs/explanation/reading-the-thesis.md.
"""

from __future__ import annotations

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import exponential, logarithm_of_two, power_of_two

#: beyond this (|v|/v_s)^delta the Stribeck bump is below 1e-17 of itself
BUMP_GONE = 40.0
#: below this relaxation per step a polynomial takes the place of the exponentials, exact to double precision
_SMALL = 0.25


@compiled
def stribeck_level(speed: float, ts: float, tc: float, vs: float, delta: float) -> float:
    """Steady sliding torque without its viscous part, s(v) = Tc + (Ts - Tc) exp(-(|v|/v_s)^delta), N m."""
    return tc + (ts - tc) * stribeck_share(speed / vs, delta)


@compiled
def stribeck_share(ratio: float, delta: float) -> float:
    """exp(-ratio^delta): what is left of the Stribeck bump at `ratio` = |v|/v_s."""
    return exponential(-stribeck_power(ratio, delta))


@compiled
def stribeck_power(ratio: float, delta: float) -> float:
    """ratio^delta, held at 512, where nothing is left of the bump; next to nothing at rest."""
    return power_of_two(min(max(delta * logarithm_of_two(ratio), -1000.0), 9.0))


@compiled
def lugre_step(
    z: float, v: float, h: float, level: float, sigma0: float, sigma1: float, sigma2: float
) -> tuple[float, float]:
    """One step of h seconds at joint rate v and steady level s(v): bristle deflection after it, mean opposing torque
    during it.
    """
    if sigma0 == 0.0:
        return 0.0, without_bristles(v, level, sigma2)
    return bristle_step(z, v, h, sigma0 * h / level, sigma0, sigma1 / h, sigma2)


@compiled
def without_bristles(v: float, level: float, sigma2: float) -> float:
    """Opposing torque of the static curve, nothing at rest."""
    return (level if v > 0.0 else (-level if v < 0.0 else 0.0)) + sigma2 * v


@compiled
def bristle_step(
    z: float, v: float, h: float, relaxation: float, sigma0: float, sigma1_per_step: float, sigma2: float
) -> tuple[float, float]:
    """`lugre_step` with bristles; `relaxation` is sigma0 h / s(v), how far a step at unit rate takes them,
    `sigma1_per_step` sigma1 / h.
    """
    x = relaxation * abs(v)
    half = decay_half(x)
    # z' = (v h - x z) / h, so that the bristle moves by driven times fraction and is at z + driven times half in the
    # mean
    driven = v * h - x * z
    friction = (sigma0 * z + sigma2 * v) + driven * (sigma1_per_step + half * (sigma0 - sigma1_per_step * x))
    return z + driven * (1.0 - x * half), friction


@compiled
def decay_half(x: float) -> float:
    """(1 - m) / x with m = (1 - exp(-x)) / x the mean of exp(-x t) over t from 0 to 1, for x from 0; one half at 0."""
    if x < _SMALL:
        # the closed forms cancel here; the polynomial nearest to them
        x2 = x * x
        x4 = x2 * x2
        low = (0.5 - x * 0.16666666666666624) + x2 * (0.04166666666662073 - x * 0.008333333331444445)
        high = (0.001388888849952544 - x * 0.00019841224704629919) + x2 * (
            2.4798507793871996e-05 - x * 2.7434408175790576e-06
        )
        return low + x4 * (high + x4 * 2.488731129121827e-07)
    inverse = 1.0 / x
    return (1.0 - (1.0 - exponential(-x)) * inverse) * inverse
