"""How an estimate is written for a person."""

from __future__ import annotations

import math

import pytest

from gimbal_hil.identification.estimate import Determination, Estimate, Interval


@pytest.mark.parametrize(
    ("fitted", "low", "high", "text"),
    [
        (0.2412, 0.2399, 0.2425, "0.2399 to 0.2425"),
        (0.24121234, 0.24120834, 0.24121634, "0.2412083 to 0.2412163"),
        (0.2412, 0.2412, 0.2412, "0.2412 to 0.2412"),
        (0.2412, -math.inf, 0.3, "-inf to 0.3"),
        (0.0, -0.1, 0.1, "-0.1 to 0.1"),
    ],
)
def test_the_ends_of_an_interval_differ_as_written(fitted: float, low: float, high: float, text: str) -> None:
    estimate = Estimate("coulomb", fitted, Interval(low, high), "N m", Determination.IDENTIFIED, fitted)
    assert estimate.interval_text == text
