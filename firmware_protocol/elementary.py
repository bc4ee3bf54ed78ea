"""Sine and cosine, exponential and logarithm written out: the same bits on every machine and libm, and in line with
what calls them.

Tables of exactly rounded values and short polynomials (after Tang, ACM Transactions on Mathematical Software 15, 1989),
only additions, multiplications and the bits of a number. Errors stay below two units in the last place of the result,
or 3e-16 where that is more; tests/firmware_protocol/test_elementary.py holds them to it. A call of the C library costs
three times as much, and nothing overlaps it.
"""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol.compiling import compiled

#: added and taken off again it rounds a number below 2^51 to a whole one, whose two's complement is then in the low
#: bits
_ROUNDER = 6755399441055744.0
_ROUNDER_BITS = 0x4338000000000000
_MANTISSA, _ONE = (1 << 52) - 1, 0x3FF0000000000000


def _upper(value: float, bits: int) -> float:
    """The leading bits of a number, so that its products with small whole numbers are exact."""
    mantissa, exponent = math.frexp(value)
    return math.ldexp(math.floor(math.ldexp(mantissa, bits)), exponent - bits)


# --- exponential: 2^(k/64) as bits ------------------------------------------------------------------------------------
_POWERS = np.array([2.0 ** (k / 64) for k in range(64)]).view(np.int64)
_LN2 = 0.6931471805599453
_PER_LN2 = 64.0 / _LN2
_LN2_UPPER = _upper(_LN2 / 64, 36)
#: the rest of ln(2) / 64, from ln(2) - 0.6931471805599453 = 2.3190468138462996e-17
_LN2_LOWER = (_LN2 / 64 - _LN2_UPPER) + 2.3190468138462996e-17 / 64
# --- logarithm: 1 / c and log2(c) for the middles c of 256 intervals --------------------------------------------------
_INVERSES = np.array([1.0 / (1.0 + (k + 0.5) / 256) for k in range(256)])
_LOGARITHMS = np.array([-math.log2(inverse) for inverse in _INVERSES.tolist()])
_PER_LN = 1.4426950408889634
# --- sine and cosine of k 2 pi / 256 ----------------------------------------------------------------------------------
# from the first eighth, so that opposite angles are opposite to the last bit
_EIGHTH = [math.sin(math.pi * k / 128) for k in range(33)] + [math.cos(math.pi * k / 128) for k in range(31, -1, -1)]
_SINES = np.array([*_EIGHTH, *_EIGHTH[-2:0:-1], *(-v for v in [*_EIGHTH, *_EIGHTH[-2:0:-1]])])
_COSINES = np.roll(_SINES, -64)
_PER_TURN = 256.0 / (2.0 * math.pi)
_TURN = 2.0 * math.pi / 256
_TURN_UPPER = _upper(_TURN, 27)
_TURN_LOWER = (_TURN - _TURN_UPPER) + 2.4492935982947064e-16 / 256
#: beyond it the angle itself has no more meaning to 1e-10 rad than the reduction, and the library may do it
_MOST_ANGLE = 1e6


@compiled
def bits_of(x: float) -> int:
    """The 64 bits of a number as a whole number."""
    return int(np.float64(x).view(np.int64))


@compiled
def of_bits(bits: int) -> float:
    """The number that 64 bits stand for."""
    return float(np.int64(bits).view(np.float64))


@compiled
def _power(n: int, t: float) -> float:
    """2^(n/64) e^t for |t| < 0.0055."""
    t2 = t * t
    tail = t + t2 * ((0.5 + t * (1 / 6)) + t2 * (1 / 24 + t * (1 / 120)))
    scale = of_bits(_POWERS[n & 63] + ((n >> 6) << 52))
    return scale + scale * tail


@compiled
def exponential(x: float) -> float:
    """e^x; between -700 and 700 by table."""
    if not -700.0 < x < 700.0:
        return math.exp(x)
    k = x * _PER_LN2 + _ROUNDER
    whole = k - _ROUNDER
    return _power(bits_of(k) - _ROUNDER_BITS, (x - whole * _LN2_UPPER) - whole * _LN2_LOWER)


@compiled
def power_of_two(y: float) -> float:
    """2^y for y between -1000 and 1000."""
    k = y * 64.0 + _ROUNDER
    return _power(bits_of(k) - _ROUNDER_BITS, (y - (k - _ROUNDER) * (1 / 64)) * _LN2)


@compiled
def logarithm_of_two(x: float) -> float:
    """log2(x) of a normal number above zero; of zero -1023."""
    bits = bits_of(x)
    place = (bits >> 44) & 255
    r = of_bits((bits & _MANTISSA) | _ONE) * _INVERSES[place] - 1.0
    r2 = r * r
    tail = r - r2 * ((0.5 - r * (1 / 3)) + r2 * (0.25 - r * (1 / 5)))
    return float(((bits >> 52) - 1023) + _LOGARITHMS[place]) + tail * _PER_LN


@compiled
def sine_cosine(x: float) -> tuple[float, float]:
    """Sine and cosine of an angle in rad."""
    if not abs(x) < _MOST_ANGLE:
        return math.sin(x), math.cos(x)
    k = x * _PER_TURN + _ROUNDER
    whole = k - _ROUNDER
    r = (x - whole * _TURN_UPPER) - whole * _TURN_LOWER
    place = bits_of(k) & 255
    r2 = r * r
    # sine and one less than cosine of the rest, at most pi / 256
    s = r - r * r2 * ((1 / 6 - r2 * (1 / 120)) + r2 * r2 * (1 / 5040))
    c = -r2 * ((0.5 - r2 * (1 / 24)) + r2 * r2 * (1 / 720))
    sine, cosine = _SINES[place], _COSINES[place]
    return float(sine + (sine * c + cosine * s)), float(cosine + (cosine * c - sine * s))
