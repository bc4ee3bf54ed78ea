"""Units as people write them."""

from __future__ import annotations

import math

import pytest

from gimbal_hil.data.tables import UNITS, unit_in_name, unit_size

OUNCE_INCH, POUND_INCH = 0.0070615518, 0.1129848290


@pytest.mark.parametrize(
    ("said", "si", "size"),
    [
        ("Nmm", "N m", 1e-3),
        ("mNm", "N m", 1e-3),
        ("N·m", "N m", 1.0),
        ("N-m", "N m", 1.0),
        ("oz-in", "N m", OUNCE_INCH),
        ("in-lb", "N m", POUND_INCH),
        ("lb-in", "N m", POUND_INCH),
        ("ft-lb", "N m", 12.0 * POUND_INCH),
        ("kgf cm", "N m", 0.0980665),
        ("kg·cm", "N m", 0.0980665),
        ("rev/min", "rad/s", math.tau / 60.0),
        ("RPM", "rad/s", math.tau / 60.0),
        ("dps", "rad/s", math.tau / 360.0),
        ("°/s", "rad/s", math.tau / 360.0),
        ("degrees/s", "rad/s", math.tau / 360.0),
        ("sec", "s", 1.0),
        ("msec", "s", 1e-3),
        ("degrees", "rad", math.tau / 360.0),
        ("Turns", "rad", math.tau),
        ("m/s²", "m/s^2", 1.0),
    ],
)
def test_a_unit_in_the_spelling_of_its_trade_is_known_without_a_library(
    monkeypatch: pytest.MonkeyPatch, said: str, si: str, size: float
) -> None:
    monkeypatch.setattr("gimbal_hil.data.tables.unit_words._registry", lambda: None)
    found = unit_size(said, si)
    assert found is not None and found[0] == pytest.approx(size, rel=1e-7)


@pytest.mark.parametrize("said", ["counts", "count", "V", "Hz", "percent", "rpm", "N m", "", "deg/", "(", "__import__"])
def test_what_is_no_angle_is_none(said: str) -> None:
    assert unit_size(said, "rad") is None


def test_the_table_says_what_a_library_of_units_says() -> None:
    pint = pytest.importorskip("pint", reason="the extra units is not installed")
    registry = pint.UnitRegistry()
    for si, names in UNITS.items():
        for name, size in names.items():
            if si not in ("", "degC") and name != "g":
                quantity = registry.Quantity(1.0, name.replace("ozf", "force_ounce").replace(" ", "*"))
                assert quantity.to(si.replace(" ", "*")).magnitude == pytest.approx(size, rel=1e-12), name


@pytest.mark.parametrize(
    ("said", "si", "size"),
    [
        ("rad/min", "rad/s", 1.0 / 60.0),
        ("gf cm", "N m", 9.80665e-5),
        ("grad", "rad", math.tau / 400.0),
        ("h", "s", 3600),
    ],
)
def test_other_units_are_asked_of_the_library(said: str, si: str, size: float) -> None:
    pytest.importorskip("pint", reason="the extra units is not installed")
    found = unit_size(said, si)
    assert found is not None and found[0] == pytest.approx(size, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "si", "unit"),
    [
        ("angle_deg", "rad", "deg"),
        ("theta/deg", "rad", "deg"),
        ("torque_mNm", "N m", "mNm"),
        ("time us", "s", "us"),
        ("arm.q.deg", "rad", "deg"),
        ("Moment (N·mm)", "N m", "N·mm"),
        ("tau_mN_m", "N m", "mN m"),
        ("tau_N.mm", "N m", "N mm"),
        ("gyro_deg/s", "rad/s", "deg/s"),
        # a name, a part of one, a place in a list, another quantity, and words that a library alone takes for units
        ("q_multi_turn", "rad", ""),
        ("deg", "rad", ""),
        ("q_m", "rad", ""),
        ("log_in", "m", ""),
        ("position[0]", "rad", ""),
        ("current_mA", "N m", ""),
        ("torque_cal", "N m", ""),
        ("torque (cal)", "N m", ""),
    ],
)
def test_a_name_that_ends_in_a_unit_states_it(name: str, si: str, unit: str) -> None:
    assert unit_in_name(name, si) == unit


@pytest.mark.parametrize(("name", "size"), [("M (µN·m)", 1e-6), ("M [gf.cm]", 9.80665e-5)])
def test_a_unit_in_brackets_may_be_one_that_only_a_library_knows(name: str, size: float) -> None:
    pytest.importorskip("pint", reason="the extra units is not installed")
    found = unit_size(unit_in_name(name, "N m"), "N m")
    assert found is not None and found[0] == pytest.approx(size)
