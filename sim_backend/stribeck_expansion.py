"""What is left of the Stribeck bump at speeds near one centre, as a power series: a fourth of the time of exponential and power.

With speed = centre (1 + w) the share exp(-ratio^delta) is f(w) = exp(-u (1 + w)^delta), u = (centre / v_s)^delta. From
f' = -u delta (1 + w)^(delta - 1) f its coefficients follow by recurrence. Within REACH of the centre (REACH / delta for a delta above
one) the first nine give double precision (tests/sim_backend/test_friction.py); outside, the steps compute the share itself. A joint
that slides steadily keeps its centre for long; the centre belongs to the state, so a copied state goes on with the same bits.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import exponential
from sim_backend.friction import stribeck_power
from sim_backend.layout import (
    ACCELERATION,
    BUMP,
    BUMP_GONE_SPEED,
    BUMP_REACH,
    BUMP_SERIES,
    BUMP_SIZE,
    DELTA,
    IN_FORCE,
    IN_FORCE_SIZE,
    PER_CENTRE,
    RATE,
    VS,
)

#: largest |w|, times delta where that is above one: the tenth term is then below 1e-16
REACH = 0.02
Series = tuple[float, float, float, float, float, float, float, float, float, float, float]


@compiled
def centre_bump(X: np.ndarray, axis: int, tick_s: float) -> None:
    """Once a tick: move the centre to the speed in the middle of the tick, where the old one will not do and the new one will."""
    f, b = IN_FORCE + axis * IN_FORCE_SIZE, BUMP + axis * BUMP_SIZE
    half_change = 0.5 * tick_s * abs(X[ACCELERATION + axis])
    middle = abs(X[RATE + axis] + 0.5 * tick_s * X[ACCELERATION + axis])
    if middle - half_change > X[f + BUMP_GONE_SPEED]:
        return
    per_centre, reach = X[b + PER_CENTRE], X[b + BUMP_REACH]
    # standing still has no centre: its speed changes by more than itself
    if abs(middle * per_centre - 1.0) + half_change * per_centre > reach and 2.0 * half_change * max(X[f + DELTA], 1.0) < REACH * middle:
        expand_bump(X, axis, middle)


@compiled
def expand_bump(X: np.ndarray, axis: int, centre: float) -> None:
    """Put the series about a speed (rad/s, above 0) into X."""
    f, b = IN_FORCE + axis * IN_FORCE_SIZE, BUMP + axis * BUMP_SIZE
    delta = X[f + DELTA]
    power = stribeck_power(centre / X[f + VS], delta)
    # s1 + s2 w + ... is the derivative of the exponent
    s1 = -power * delta
    s2 = s1 * (delta - 1.0)
    s3 = s2 * ((delta - 2.0) * (1 / 2))
    s4 = s3 * ((delta - 3.0) * (1 / 3))
    s5 = s4 * ((delta - 4.0) * (1 / 4))
    s6 = s5 * ((delta - 5.0) * (1 / 5))
    s7 = s6 * ((delta - 6.0) * (1 / 6))
    s8 = s7 * ((delta - 7.0) * (1 / 7))
    c0 = exponential(-power)
    c1 = s1 * c0
    c2 = (s1 * c1 + s2 * c0) * (1 / 2)
    c3 = ((s1 * c2 + s2 * c1) + s3 * c0) * (1 / 3)
    c4 = ((s1 * c3 + s2 * c2) + (s3 * c1 + s4 * c0)) * (1 / 4)
    c5 = ((s1 * c4 + s2 * c3) + (s3 * c2 + s4 * c1) + s5 * c0) * (1 / 5)
    c6 = ((s1 * c5 + s2 * c4) + (s3 * c3 + s4 * c2) + (s5 * c1 + s6 * c0)) * (1 / 6)
    c7 = ((s1 * c6 + s2 * c5) + (s3 * c4 + s4 * c3) + (s5 * c2 + s6 * c1) + s7 * c0) * (1 / 7)
    c8 = ((s1 * c7 + s2 * c6) + (s3 * c5 + s4 * c4) + (s5 * c3 + s6 * c2) + (s7 * c1 + s8 * c0)) * (1 / 8)
    X[b + PER_CENTRE], X[b + BUMP_REACH] = 1.0 / centre, REACH / max(delta, 1.0)
    c = b + BUMP_SERIES
    X[c], X[c + 1], X[c + 2], X[c + 3], X[c + 4], X[c + 5], X[c + 6], X[c + 7], X[c + 8] = c0, c1, c2, c3, c4, c5, c6, c7, c8


@compiled
def bump_series(X: np.ndarray, axis: int) -> Series:
    """1 / centre (0 without one), the largest |w|, and the coefficients."""
    b = BUMP + axis * BUMP_SIZE
    c = b + BUMP_SERIES
    return (
        X[b + PER_CENTRE], X[b + BUMP_REACH], X[c], X[c + 1], X[c + 2], X[c + 3], X[c + 4], X[c + 5], X[c + 6], X[c + 7], X[c + 8]
    )  # fmt: skip


@compiled
def share_near(w: float, series: Series) -> float:
    """The share at centre (1 + w)."""
    _, _, c0, c1, c2, c3, c4, c5, c6, c7, c8 = series
    w2 = w * w
    w4 = w2 * w2
    return ((c0 + c1 * w) + w2 * (c2 + c3 * w)) + w4 * (((c4 + c5 * w) + w2 * (c6 + c7 * w)) + w4 * c8)


@compiled
def forget_bump(X: np.ndarray, axis: int) -> None:
    """No centre: friction's numbers have changed."""
    X[BUMP + axis * BUMP_SIZE + PER_CENTRE] = 0.0
    X[BUMP + axis * BUMP_SIZE + BUMP_REACH] = 0.0
