from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.knowledge.discrepancy.verdict.headlines import headline
from gimbal_hil.pages.report import between, counted, from_to, quantity

SIZES = {"n": 1e-9, "\u00b5": 1e-6, "m": 1e-3, "": 1.0}


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        (0.012, "N m", "12 mN m"),
        (0.0999999, "N m", "100 mN m"),
        (9.9999e-4, "N m", "1 mN m"),
        (8.0, "1/turn", "8 per turn"),
        (0.0123, "1", "0.0123"),
        (3.1e-4, "N m s/rad", "310 \u00b5N m s/rad"),
        (-4e-4, "m", "-400 \u00b5m"),
        (0.002, "kg m2", "0.002 kg m2"),
        (0.0, "N m", "0 N m"),
        (float("nan"), "m", "-"),
        (float("inf"), "m", "without bound"),
    ],
)
def test_a_number_is_said_with_three_digits_and_the_prefix_that_shows_them(value: float, unit: str, said: str) -> None:
    assert quantity(value, unit) == said


@given(st.floats(1e-9, 1e9), st.sampled_from(("N m", "rad", "N m s/rad", "rad/s")))
def test_what_is_said_is_the_number_to_three_digits(value: float, unit: str) -> None:
    found = re.fullmatch(rf"([-+.e\d]+) ([n\u00b5m]?){re.escape(unit)}", quantity(value, unit))
    assert found and float(found[1]) * SIZES[found[2]] == pytest.approx(value, rel=6e-3)


def test_a_number_its_interval_and_what_it_is_compared_with_have_one_prefix() -> None:
    assert between(0.03, 0.0299, 0.0301, "N m") == "30 mN m (29.9 to 30.1)"
    assert between(12.0, 11.95, 12.05, "1/turn") == "12 per turn (11.95 to 12.05)"
    assert between(0.184, 0.183, 0.185, "N m s/rad", nominal=0.0336) == (
        "0.184 N m s/rad (0.183 to 0.185; model: 0.0336 N m s/rad)"
    )
    # an interval that digits do not show, or that nobody knows, is not told
    assert between(0.03, 0.03, 0.03, "N m") == "30 mN m"
    # a value with fewer digits than its ends would lie beside them
    assert between(0.050005, 0.050003, 0.050007, "N m") == "50.005 mN m (50.003 to 50.007)"
    assert between(1.0, 0.0, float("inf"), "1") == "1"
    assert from_to(0.0192, 0.000473, "N m") == "19.2 \u2192 0.473 mN m"
    assert from_to(0.145, 0.000518, "N m") == "145 \u2192 0.518 mN m" and from_to(0.5, 0.0, "rad") == "0.5 \u2192 0 rad"


def test_a_large_number_has_no_exponent() -> None:
    assert quantity(1256.637, "rad/s") == "1257 rad/s" and quantity(-43210.4, "N m/rad") == "-43210 N m/rad"
    assert quantity(999.6, "1") == "1000" and quantity(999.4, "1") == "999"


def test_a_cause_is_told_by_where_how_large_and_how_sure_and_not_by_its_phase() -> None:
    def number(value: float, unit: str, nominal: float | None = None) -> dict[str, object]:
        return {"value": value, "low": value, "high": value, "unit": unit, "nominal": nominal}

    ripple = {"amplitude": number(0.012, "N m"), "order": number(8.0, "1/turn"), "phase": number(0.3, "rad")}
    cogging = {"name": "cogging", "axis": "elevation", "probability": 0.953, "parameters": ripple}
    assert headline(cogging) == "Cogging on elevation: amplitude 12 mN m, 8 per turn; probability 0.95"
    twice = cogging | {"entries": [ripple, ripple | {"order": number(16.0, "1/turn")}]}
    assert "12 mN m, 8 per turn and amplitude 12 mN m, 16 per turn" in headline(twice)
    moved = {"coulomb": number(0.31, "N m", 0.25), "breakaway": number(0.3, "N m", 0.3)}
    friction = {"name": "coulomb", "axis": "pan", "probability": 0.6, "parameters": moved}
    alike = friction | {"parameters": moved | {"breakaway": number(0.3, "N m", 0.30001)}}
    assert "breakaway" not in headline(alike)
    assert headline(friction) == "Coulomb on pan: coulomb 0.31 N m (model: 0.25 N m); probability 0.60"


def test_one_of_a_thing_is_no_plural() -> None:
    said = [
        counted(0, "row"),
        counted(1, "row"),
        counted(2, "row"),
        counted(1, "axis", "axes"),
        counted(2, "axis", "axes"),
    ]
    assert said == ["0 rows", "1 row", "2 rows", "1 axis", "2 axes"]
