"""The look for samples that repeat: what it answers is what its definition says."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.compiling import interpreted
from gimbal_hil.loop.host.layout import SAID_SIZE
from gimbal_hil.loop.host.repeating import _ALIKE, _LONGEST, _has_period

LOOK = interpreted(_has_period)


def has_period(said: list[float]) -> bool:
    """By its definition: the last `_ALIKE` samples are those of a period before."""
    last = said[-_ALIKE:]
    most = min(_LONGEST, len(said) - _ALIKE)
    return any(said[len(said) - _ALIKE - period : len(said) - period] == last for period in range(1, most + 1))


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 230), st.integers(101, 700), st.integers(0, 2**31), st.integers(1, 4), st.booleans())
def test_a_look_finds_every_period_and_no_other(period: int, count: int, seed: int, kinds: int, spoilt: bool) -> None:
    dice = np.random.default_rng(seed)
    said = np.resize(dice.integers(0, kinds, size=period).astype(float), count)
    if spoilt:
        said[-int(dice.integers(1, min(count, SAID_SIZE) + 1))] += 1.0
    ring = np.zeros(SAID_SIZE + 3)
    for place, value in enumerate(said.tolist()):
        ring[3 + place % SAID_SIZE] = value
    assert LOOK(ring, 3, count) == has_period(said.tolist())
