"""Counter-based noise: a pure function of (seed, tick, channel), so that a state can be copied and continued.

A 32-bit integer hash of the counter and the Box-Muller transform. Only signed 64-bit integers below 2^63, so that the
interpreted and the compiled form give the same bits.
"""

from __future__ import annotations

import math

from firmware_protocol.compiling import compiled
from firmware_protocol.elementary import logarithm_of_two, sine_cosine

_CHANNELS = 16
_MINUS_TWO_LN2 = -2.0 * math.log(2.0)


@compiled
def _mixed(x: int) -> int:
    # xorshift-multiply avalanche, constants of C. Wellons' hash search (2018); masked after each product to stay below
    # 2^63
    x &= 0xFFFFFFFF
    x ^= x >> 16
    x = (x * 0x21F0AAAD) & 0xFFFFFFFF
    x ^= x >> 15
    x = (x * 0x735A2D97) & 0xFFFFFFFF
    x ^= x >> 15
    return x


@compiled
def uniform(seed: int, tick: int, channel: int) -> float:
    """A number in (0, 1), the same for the same arguments."""
    low = _mixed(tick * _CHANNELS + channel + _mixed(seed + 0x9E3779B9))
    high = _mixed(low + _mixed((tick >> 28) + seed) + channel)
    return ((high * 1048576 + (low & 0xFFFFF)) + 0.5) / 4503599627370496.0


@compiled
def normal(seed: int, tick: int, channel: int) -> float:
    """A standard normal variate, the same for the same arguments."""
    squared = _MINUS_TWO_LN2 * logarithm_of_two(uniform(seed, tick, 2 * channel))
    # next to one the logarithm may come out a rounding above zero
    return math.sqrt(max(squared, 0.0)) * sine_cosine(2.0 * math.pi * uniform(seed, tick, 2 * channel + 1))[1]
