"""The integer arithmetic of `words` and `receiver`, compiled to be folded into whatever calls it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

from firmware_protocol import receiver, words

Integers = NDArray[np.int64]
Octets = NDArray[np.uint8]
F = TypeVar("F", bound=Callable[..., Any])


def leaf(function: F) -> F:
    """Compile a law of a few instructions that is always put in line, so that literals of the caller fold into it."""
    return cast(F, numba.njit(error_model="numpy", forceinline=True)(function))


quantise = leaf(words.quantise)
crc12 = leaf(words.crc12)
read_fields = leaf(words.read_fields)
read_pair = leaf(words.read_pair)
judge_counter = leaf(receiver.judge_counter)
judge_status = leaf(receiver.judge_status)
more_trouble = leaf(receiver.more_trouble)
memory_ticks = leaf(receiver.memory_ticks)
