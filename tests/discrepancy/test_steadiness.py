"""A cause is of one strength in every stretch of every log; what fits best with some mean of its strengths is none."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.hypotheses import BROKEN
from gimbal_hil.knowledge.discrepancy.judgement.steadiness import unevenness
from gimbal_hil.knowledge.discrepancy.twin import Floats

_ROWS = 3000


def _does(seed: int, rows: int = _ROWS) -> Floats:
    """What a cause does: a torque that changes its sign every second or so."""
    rng = np.random.default_rng(seed)
    return 5.0 * np.sin(np.cumsum(0.05 + 0.05 * rng.random(rows)))


def _slow(seed: int, correlated: int, rows: int = _ROWS) -> Floats:
    """Noise of rms one over so many rows."""
    rng = np.random.default_rng(seed)
    steps = np.convolve(rng.standard_normal(rows + correlated - 1), np.ones(correlated), "valid")
    return np.asarray(steps / np.sqrt(correlated))


def _uneven(does: list[Floats], left: list[Floats], also: float = 0.0) -> float:
    """What the module says of two fitted logs and one of the hold-out; beside a channel of noise on which the cause
    does `also` times as much.
    """
    fitted, held = slice(0, 2), slice(2, 3)
    lengths = [len(one) for one in does]

    def state(rows: list[Floats]) -> Any:
        return SimpleNamespace(fitted=np.concatenate(rows[fitted]), held=np.concatenate(rows[held]))

    inquiry: Any = SimpleNamespace(
        held_counts=tuple(lengths[held]),
        split=lambda rows: np.split(rows, np.cumsum(lengths[fitted])[:-1]),
        in_order=lambda one: one.held,
    )
    beside = [np.random.default_rng(1000 + k).standard_normal(length) for k, length in enumerate(lengths)]
    bare = [np.stack([n + also * d, d + x], 1) for d, x, n in zip(does, left, beside, strict=True)]
    return unevenness(inquiry, state(bare), state([np.stack([n, x], 1) for n, x in zip(beside, left, strict=True)]))


@pytest.mark.parametrize(("level", "correlated"), [(0.0, 1), (1.0, 1), (4.0, 1), (4.0, 5), (4.0, 20), (0.5, 200)])
def test_a_cause_that_is_always_there_is_steady_whatever_else_is_left(level: float, correlated: int) -> None:
    for seed in range(10):
        does = [_does(10 * seed + k) for k in range(3)]
        left = [level * _slow(100 + 10 * seed + k, correlated) for k in range(3)]
        assert _uneven(does, left) < 0.1


def test_it_is_read_where_the_cause_does_most() -> None:
    # a slope over next to nothing, beside noise, says nothing
    does = [_does(k) for k in range(3)]
    left = [0.5 * _slow(10 + k, 5) for k in range(3)]
    assert _uneven(does, left, also=1e-4) == _uneven(does, left) < 0.1


def test_what_is_there_for_a_part_of_a_log_only_is_uneven() -> None:
    does = [_does(k) for k in range(3)]
    left = [0.5 * _slow(10 + k, 5) for k in range(3)]
    # the torque came after a third of the first log; elsewhere the fitted strength is a little below its own
    left = [noise + 0.09 * one for noise, one in zip(left, does, strict=True)]
    left[0][: _ROWS // 3] -= does[0][: _ROWS // 3]
    assert _uneven(does, left) > 0.2


def test_what_grows_slowly_is_uneven() -> None:
    does = [_does(k) for k in range(3)]
    left = [0.5 * _slow(10 + k, 5) + np.linspace(-0.5, 0.5, _ROWS) * one for k, one in enumerate(does)]
    assert _uneven(does, left) == pytest.approx(0.27, abs=0.06)


def test_another_strength_in_the_hold_out_is_uneven() -> None:
    does = [_does(k) for k in range(3)]
    left = [0.5 * _slow(10 + k, 5) for k in range(3)]
    left[2] -= 0.6 * does[2]
    assert _uneven(does, left) > 0.2


@pytest.mark.parametrize("rows", [0, 5, 20])
def test_a_log_without_room_for_stretches_says_nothing(rows: int) -> None:
    does = [_does(k, rows) for k in range(3)]
    # as uneven as can be: with room it would say so
    assert _uneven(does, [np.linspace(-1.0, 1.0, rows) * one for one in does]) == 0.0


def test_what_does_nothing_has_no_strength() -> None:
    left = [_slow(k, 3) for k in range(3)]
    assert _uneven([np.zeros(_ROWS)] * 3, left) == 0.0


def test_a_log_that_the_twin_cannot_carry_without_the_cause_says_nothing_and_hides_nothing() -> None:
    does = [_does(k) for k in range(3)]
    left = [0.5 * _slow(10 + k, 5) for k in range(3)]
    # in the other logs the cause is there for two thirds of the time
    for one, noise in zip(does[1:], left[1:], strict=True):
        noise += 0.3 * one
        noise[: _ROWS // 3] -= 0.9 * one[: _ROWS // 3]
    assert (uneven := _uneven(does, left)) > 0.3
    does[0][-1000:] = BROKEN - left[0][-1000:]
    assert _uneven(does, left) > uneven
    does = [np.full(_ROWS, 2.0 * BROKEN)] * 3
    assert _uneven(does, left) == 0.0
