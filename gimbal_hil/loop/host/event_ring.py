"""Events of the host core: a ring of whole numbers in `G` that compiled code writes and Python reads."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled
from gimbal_hil.loop.host.layout import EVENT_CAPACITY, EVENT_COUNT, EVENT_SIZE, EVENTS, LAST_TICK, STATE, STATE_AGE
from gimbal_hil.loop.host.states import EventCode, number

_STATE = number(EventCode.STATE)


@compiled
def report(G: np.ndarray, code: int, first: int, second: int, third: int) -> None:
    """Append an event of this tick, over the oldest one when the ring is full."""
    at = EVENTS + (G[EVENT_COUNT] % EVENT_CAPACITY) * EVENT_SIZE
    G[at], G[at + 1], G[at + 2], G[at + 3], G[at + 4] = G[LAST_TICK], code, first, second, third
    G[EVENT_COUNT] += 1


@compiled
def enter_state(G: np.ndarray, state: int, cause: int) -> None:
    """Go over to a state and say so."""
    report(G, _STATE, G[STATE], state, cause)
    G[STATE], G[STATE_AGE] = state, 0
