"""What is left of the Stribeck bump as power series about a grid of speeds: a fourth of the time of exponential and
power.

The ratio |v| / v_s is cut into cells, 64 to an octave, so that its leading bits are the number of its cell. With c the
middle of a cell the share exp(-ratio^delta) is f(d) = exp(-(c + d)^delta); from f' = -delta (c + d)^(delta - 1) f its
coefficients follow by recurrence, and the first eight give double precision for a delta up to two
(tests/sim_backend/test_friction.py). The table depends on delta alone and is made with the model. Ratios outside it, a
sharper curve, or a delta that goes with temperature take the law itself.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import bits_of, of_bits
from sim_backend.friction import stribeck_share
from sim_backend.layout import (
    AXIS_BLOCK,
    AXIS_SIZE,
    BUMP_CELLS,
    BUMP_DELTA,
    BUMP_OCTAVES,
    BUMP_TABLE,
    BUMP_TABLE_SIZE,
    BUMP_TERMS,
)

#: largest exponent with a table
MOST_DELTA = 2.0
#: a cell is what sign, exponent and six bits of the mantissa say; its middle has the next bit set and none behind it
_CELL_BITS = 52 - (BUMP_CELLS // BUMP_OCTAVES).bit_length() + 1
_MIDDLE = 1 << (_CELL_BITS - 1)
_TO_MIDDLE = ~((1 << _CELL_BITS) - 1)
#: the lowest ratio of the table is 2^-12: a joint held by a loop is seldom slower
_FIRST_CELL = (1023 - 12) << (52 - _CELL_BITS)


@lru_cache(maxsize=64)
def bump_table(delta: float) -> NDArray[np.float64]:
    """Coefficients of all cells, (BUMP_TABLE_SIZE,), in powers of the distance from the middle of the cell."""
    middles = (((_FIRST_CELL + np.arange(BUMP_CELLS)) << _CELL_BITS) | _MIDDLE).view(np.float64)
    powers = np.array([middle**delta for middle in middles.tolist()])
    # with ratio = middle (1 + w): derivative of the exponent, then of the share, in powers of w
    slopes = [-powers * delta]
    terms = [np.array([math.exp(-power) for power in powers.tolist()])]
    for k in range(1, BUMP_TERMS):
        terms.append(sum(slopes[j] * terms[k - 1 - j] for j in range(k)) / k)
        slopes.append(slopes[-1] * ((delta - k) / k))
    return np.ascontiguousarray(np.stack([term / middles**k for k, term in enumerate(terms)], axis=1).reshape(-1))


def put_bump_table(P: NDArray[np.float64], axis: int, delta: float) -> None:
    """Put an axis' table into P."""
    if delta <= MOST_DELTA:
        P[AXIS_BLOCK + axis * AXIS_SIZE + BUMP_DELTA] = delta
        first = BUMP_TABLE + axis * BUMP_TABLE_SIZE
        P[first : first + BUMP_TABLE_SIZE] = bump_table(delta)


@compiled
def has_bump_table(P: np.ndarray, axis: int, delta: float) -> bool:
    """Whether P has an axis' table for this delta."""
    return bool(P[AXIS_BLOCK + axis * AXIS_SIZE + BUMP_DELTA] == delta)


@compiled
def bump_share(P: np.ndarray, axis: int, tabled: bool, ratio: float, delta: float) -> float:
    """`stribeck_share`, from an axis' table where it has one (`tabled`)."""
    bits = bits_of(ratio)
    cell = (bits >> _CELL_BITS) - _FIRST_CELL
    if not tabled or cell < 0 or cell >= BUMP_CELLS:
        return stribeck_share(ratio, delta)
    d = ratio - of_bits((bits & _TO_MIDDLE) | _MIDDLE)
    c = BUMP_TABLE + axis * BUMP_TABLE_SIZE + cell * BUMP_TERMS
    d2 = d * d
    low = (P[c] + P[c + 1] * d) + d2 * (P[c + 2] + P[c + 3] * d)
    return float(low + (d2 * d2) * ((P[c + 4] + P[c + 5] * d) + d2 * (P[c + 6] + P[c + 7] * d)))
