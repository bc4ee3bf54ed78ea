"""A held column at the times of another one: a row is lost where a lost value acts in most of it, and no other."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.data.containers.joining import _mean_until_next

LOST = np.nan


@pytest.mark.parametrize(
    ("earlier_s", "expected"),
    [(0.0, [1.0, LOST, 3.0, 4.0]), (0.25, [1.0, LOST, 3.25, 4.0]), (-0.25, [1.0, LOST, 3.0, 3.0])],
    ids=["at the same times", "sent before", "sent after"],
)
def test_a_lost_value_costs_the_row_that_it_acts_in(earlier_s: float, expected: list[float]) -> None:
    at = np.arange(4.0)
    np.testing.assert_allclose(_mean_until_next(at - earlier_s, np.array([1.0, LOST, 3.0, 4.0]), at), expected)
