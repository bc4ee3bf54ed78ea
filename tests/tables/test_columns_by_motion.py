"""Which columns of a file without a header are time, position and torque."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gimbal_hil.data.signals import words_by_motion
from tests.cases.joint import BENCH, Floats

LOG = replace(BENCH, rate_hz=200.0).log("a", 10.0)
RANDOM = np.random.default_rng(3)
ACCELERATION = np.gradient(LOG.rate, 0.005)
COLUMNS: dict[str, Floats] = {"1": LOG.time, "2": LOG.position, "3": LOG.torque}
FOUND = ("time_s=1", "AXIS.position=2", "AXIS.torque=3")


@pytest.mark.parametrize(
    "others",
    [
        {},
        {"4": LOG.rate},
        {"4": ACCELERATION, "5": LOG.rate, "6": 24.1 + 0.0 * LOG.time},
        {"4": RANDOM.normal(size=2000)},
    ],
    ids=["none", "rate", "all of the motion", "noise"],
)
def test_position_and_torque_are_those_that_move_so(others: dict[str, Floats]) -> None:
    assert words_by_motion(COLUMNS | others, "AXIS") == FOUND


def test_units_of_position_and_torque_change_nothing_and_that_of_time_is_told() -> None:
    other = {"1": 1e6 * LOG.time, "2": 57.3 * LOG.position, "3": -1e3 * -LOG.torque}
    assert words_by_motion(other, "AXIS") == ("time_s=1:us", *FOUND[1:])


def test_whole_seconds_and_the_rest_of_a_second_in_another_column_are_one_time() -> None:
    for size, unit in ((1e9, "ns"), (1e6, "us")):
        counts = 1.7e9 * size + np.round((0.3 + LOG.time) * size)
        parts = {"1": counts // size, "2": counts % size, "3": LOG.position, "4": LOG.torque}
        found = (f"time_s=1+2:{unit}", "AXIS.position=3", "AXIS.torque=4")
        assert words_by_motion(parts, "AXIS") == found, unit


@pytest.mark.parametrize(
    "columns",
    [
        COLUMNS | {"3": -LOG.torque},
        COLUMNS | {"3": LOG.rate},
        COLUMNS | {"3": ACCELERATION},
        COLUMNS | {"3": RANDOM.normal(size=2000)},
        COLUMNS | {"1": np.arange(2000.0)},
        COLUMNS | {"4": 1.8 * LOG.torque},
    ],
    ids=["mirrored", "rate", "acceleration", "noise", "a count for the time", "torque twice"],
)
def test_nothing_is_told_where_no_columns_or_several_do(columns: dict[str, Floats]) -> None:
    assert words_by_motion(columns, "AXIS") == ()
