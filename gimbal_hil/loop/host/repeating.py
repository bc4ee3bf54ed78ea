"""Whether what an axis says was said before, to the bit: samples that repeat themselves tell nothing new."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.host.layout import AXIS_G, AXIS_G_SIZE, REPEATS, SAID, SAID_COUNT, SAID_SIZE

#: samples that must all be those of a period before, and the longest period; together what is kept
_ALIKE, _LONGEST = 100, SAID_SIZE - 100
#: samples between two looks
_EVERY = 16
#: makes one number of a position and a rate
_APART = 7919.0


@compiled
def forget_said(G: np.ndarray, axis: int) -> None:
    """Begin anew, after a silence."""
    g = AXIS_G + axis * AXIS_G_SIZE
    G[g + SAID_COUNT] = G[g + REPEATS] = 0


@compiled
def watch_repeats(position: float, rate: float, H: np.ndarray, G: np.ndarray, axis: int) -> None:
    """Take in what an axis says; REPEATS is 1 from when its last `_ALIKE` samples were those of a period before."""
    at, g = SAID + axis * SAID_SIZE, AXIS_G + axis * AXIS_G_SIZE
    H[at + G[g + SAID_COUNT] % SAID_SIZE] = position + _APART * rate
    G[g + SAID_COUNT] += 1
    if G[g + SAID_COUNT] % _EVERY == 0:
        G[g + REPEATS] = 1 if _has_period(H, at, G[g + SAID_COUNT]) else 0


@compiled
def _has_period(H: np.ndarray, at: int, count: int) -> bool:
    # most periods are refuted by the newest sample, so those are looked for by a walk around the ring
    newest = (count - 1) % SAID_SIZE
    before = newest
    for period in range(1, min(_LONGEST, count - _ALIKE) + 1):
        before = before - 1 if before > 0 else SAID_SIZE - 1
        if H[at + before] == H[at + newest] and _are_alike(H, at, count, period):
            return True
    return False


@compiled
def _are_alike(H: np.ndarray, at: int, count: int, period: int) -> bool:
    for place in range(count - _ALIKE, count):
        if H[at + place % SAID_SIZE] != H[at + (place - period) % SAID_SIZE]:
            return False
    return True
