"""How an estimate is written for a person."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gimbal_hil.knowledge.identification import AxisIdentification
from gimbal_hil.knowledge.identification.correlations import Correlations
from gimbal_hil.knowledge.identification.estimate import Determination, Estimate, Interval, withheld
from gimbal_hil.knowledge.identification.pages import _estimate_table
from gimbal_hil.surface.cli.identify import _lines
from sim_backend.model import shipped_model


@pytest.mark.parametrize(
    ("fitted", "low", "high", "text"),
    [
        (0.2412, 0.2399, 0.2425, "0.2399 to 0.2425"),
        (0.24121234, 0.24120834, 0.24121634, "0.2412083 to 0.2412163"),
        (0.2412, 0.2412, 0.2412, "0.2412 to 0.2412"),
        (0.2412, -math.inf, 0.3, "– to 0.3"),
        (0.0, -0.1, 0.1, "-0.1 to 0.1"),
        (1e-320, -1e10, 1e10, "-1e+10 to 1e+10"),
        (1e300, 1e-300, 2e-300, "1e-300 to 2e-300"),
        (1e300, -1.7e308, 1.7e308, "-1.7e+308 to 1.7e+308"),
    ],
)
def test_the_ends_of_an_interval_differ_as_written(fitted: float, low: float, high: float, text: str) -> None:
    estimate = Estimate("coulomb", fitted, Interval(low, high), "N m", Determination.IDENTIFIED, fitted)
    assert estimate.interval_text == text


def test_an_open_end_is_in_brackets_and_a_number_that_is_none_is_a_dash() -> None:
    half_open = Interval(0.1, math.inf, open_low=True)
    assert Estimate("coulomb", 0.2, half_open, "N m", Determination.NOT_IDENTIFIED, 0.2).interval_text == "(0.1) to –"
    nothing = withheld("coulomb", "N m", None, "why", "what")
    assert (nothing.value_text, nothing.fitted_text, nothing.end_texts) == ("–", "–", ("(0)", "(–)"))


NONE = Correlations((), np.zeros((0, 0)), np.zeros(0))


def test_terminal_and_page_write_an_interval_alike() -> None:
    estimate = Estimate("coulomb", 0.2, Interval(0.1, 0.5, open_high=True), "N m", Determination.WEAKLY_IDENTIFIED, 0.2)
    result = cast(
        AxisIdentification, SimpleNamespace(axis="outer", estimates=(estimate,), findings=(), correlations=NONE)
    )
    line = next(line for line in _lines([result]) if "coulomb" in line)
    assert "(0.1 to (0.5))" in line
    # where nothing was found there is no interval, not brackets in brackets
    nothing = SimpleNamespace(
        axis="outer", estimates=(withheld("coulomb", "N m", None, "why", "what"),), findings=(), correlations=NONE
    )
    line = next(line for line in _lines([cast(AxisIdentification, nothing)]) if "coulomb" in line)
    assert line.split() == ["coulomb", "–", "N", "m", "not", "identified"]
    assert _estimate_table(shipped_model(), result).rows[0][2:4] == ["0.1", "(0.5)"]
