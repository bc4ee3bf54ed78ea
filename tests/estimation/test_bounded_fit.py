"""Least squares inside bounds: never worse than at the start, and no direction that data hardly see runs away."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.estimation import bounded_fit
from gimbal_hil.knowledge.estimation.bounded_fit import Floats

_HELD = 0.01


def _columns(alike: float, size: float = 1000.0) -> Floats:
    """What four coordinates do to 400 rows: the second and third all but the same, with opposite signs."""
    rng = np.random.default_rng(3)
    one, two, three, little = rng.standard_normal((4, 400))
    return np.column_stack([one, size * two, -size * two + alike * little, three])


@pytest.mark.parametrize("alike", [0.0, 1e-9, 1e-6])
def test_two_coordinates_that_cancel_do_not_run_away_where_a_third_is_held_by_its_bound(alike: float) -> None:
    columns = _columns(alike)
    rows = columns @ np.array([1.0, 0.0, 0.015, 4.0]) + 0.1 * np.random.default_rng(4).standard_normal(len(columns))
    low, high = np.array([-9.0, -5000.0, -5000.0, -1.0]), np.array([9.0, 5000.0, 5000.0, 1.0])

    def residual_at(x: Floats) -> Floats:
        return np.concatenate([columns @ x - rows, _HELD * x])

    def jacobian_at(x: Floats, residual: Floats) -> Floats:
        return np.vstack([columns, _HELD * np.eye(4)])

    found = bounded_fit(residual_at, jacobian_at, np.zeros(4), low, high, rounds=30, enough=0.0)
    assert found.x[3] == 1.0 and found.x[2] - found.x[1] == pytest.approx(0.015, abs=1e-3)
    assert np.abs(found.x[1:3]).max() < 1.0


def test_what_begins_far_along_such_a_direction_is_led_back() -> None:
    columns = _columns(0.0, 100.0)

    def residual_at(x: Floats) -> Floats:
        return np.concatenate([columns @ x, _HELD * x])

    def jacobian_at(x: Floats, residual: Floats) -> Floats:
        return np.vstack([columns, _HELD * np.eye(4)])

    wide = np.full(4, 5000.0)
    found = bounded_fit(residual_at, jacobian_at, np.array([0.0, 4000.0, 4000.0, 0.0]), -wide, wide, 30, 0.0)
    assert np.abs(found.x).max() < 1.0 and found.cost < 1e-3 * 2.0 * (_HELD * 4000.0) ** 2
