"""A friction level that wanders is noise on knots of 0.3 s; a level that wanders farther than joints do is not."""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.discrepancy.judgement.wander import _knots, _left

ROW_S, ROWS = 0.012, 3000


def wandering(share: float, seed: int) -> np.ndarray:
    """A level with a time constant of 2 s and this standard deviation, (ROWS,)."""
    rng = np.random.default_rng(seed)
    keep = np.exp(-ROW_S / 2.0)
    level = np.zeros(ROWS)
    for k in range(1, ROWS):
        level[k] = keep * level[k - 1] + share * np.sqrt(1.0 - keep**2) * rng.standard_normal()
    return level


def friction() -> np.ndarray:
    """500 floors of Coulomb friction that turns every three seconds, (ROWS, 1)."""
    return 500.0 * np.sign(np.sin(2.0 * np.pi * np.arange(ROWS) * ROW_S / 6.0 + 0.1))[:, None]


def left(share: float, seed: int = 1) -> float:
    noise = np.random.default_rng(seed + 100).standard_normal((ROWS, 1))
    rows = friction() * wandering(share, seed)[:, None] + noise
    return _left(rows[:, 0], _knots(friction()[:, 0], ROW_S))


def test_a_level_that_wanders_by_half_a_per_cent_leaves_the_noise() -> None:
    assert np.sqrt(np.mean((friction()[:, 0] * wandering(0.005, 1)) ** 2)) > 2.0
    assert left(0.005) < 1.25


def test_noise_alone_is_left_as_it_is() -> None:
    assert 0.9 < left(0.0) < 1.1


def test_a_level_that_wanders_by_ten_per_cent_is_not_called_noise() -> None:
    assert left(0.1) > 10.0


def test_a_gap_that_is_not_friction_stays() -> None:
    ripple = 5.0 * np.sin(2.0 * np.pi * np.arange(ROWS) * ROW_S * 4.0)[:, None]
    assert _left(ripple[:, 0], _knots(friction()[:, 0], ROW_S)) > 3.0
