"""Runs in real time have ticks without an answer: a few are bridged and said, many are refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.data.signals.missed_rows import LONGEST_GAP, asked_late_rows, bridged

COUNT, PERIOD_S = 2000, 0.002
TIME_S = PERIOD_S * np.arange(COUNT)
POSITION = 0.5 * np.sin(2.0 * np.pi * 0.7 * TIME_S)
RATE = np.gradient(POSITION, PERIOD_S)
TORQUE = np.round(np.cos(40.0 * TIME_S), 2)


def columns(*gaps: tuple[int, int]) -> dict[str, np.ndarray]:
    """A run whose answers are missing in rows `first` to `first + rows` of each gap."""
    found = {"a.position": POSITION.copy(), "a.rate": RATE.copy(), "a.torque": TORQUE.copy(), "a.rate_ref": RATE.copy()}
    for first, rows in gaps:
        for name in found:
            # what acted in a row is told by the answer that ends it
            earlier = 1 if name == "a.torque" else 0
            found[name][first - earlier : first - earlier + rows] = np.nan
    return found


SENT = {"a.torque": TORQUE}


def test_short_gaps_are_bridged_with_the_torques_that_were_sent_and_counted() -> None:
    whole = bridged(columns((100, 1), (900, 6)), SENT, PERIOD_S)
    assert (whole.start, whole.stop) == (0, COUNT)
    np.testing.assert_array_equal(whole.columns["a.torque"], TORQUE)
    np.testing.assert_allclose(whole.columns["a.position"], POSITION, atol=2e-6)
    assert not np.isnan(whole.columns["a.rate_ref"]).any()
    assert len(whole.notes) == 1 and whole.notes[0].startswith("7 of 2000 rows had no answer in time: ")


def test_a_long_gap_leaves_the_longer_part_and_says_which() -> None:
    whole = bridged(columns((600, LONGEST_GAP + 1), (1500, 2)), SENT, PERIOD_S)
    assert (whole.start, whole.stop) == (600 + LONGEST_GAP + 1, COUNT)
    assert "no answer for 0.022 s" in whole.notes[0] and "1.22 to 4 s" in whole.notes[0]
    np.testing.assert_array_equal(whole.columns["a.torque"], TORQUE[whole.start :])


@pytest.mark.parametrize(
    "gaps", [[(row, 1) for row in range(10, 1990, 3)], [(row, 30) for row in range(300, 1900, 300)]]
)
def test_a_run_with_more_gaps_than_a_good_link_leaves_stays_as_it_is(gaps: list[tuple[int, int]]) -> None:
    given_columns = columns(*gaps)
    whole = bridged(given_columns, SENT, PERIOD_S)
    assert whole.columns is given_columns and whole.notes == ()


@given(st.lists(st.tuples(st.integers(2, COUNT - 40), st.integers(1, 30)), max_size=12))
def test_what_was_measured_is_never_changed(gaps: list[tuple[int, int]]) -> None:
    given_columns = columns(*gaps)
    whole = bridged(given_columns, SENT, PERIOD_S)
    for name, values in whole.columns.items():
        before = given_columns[name][whole.start : whole.stop]
        np.testing.assert_array_equal(values[~np.isnan(before)], before[~np.isnan(before)])
        assert len(values) == whole.stop - whole.start


def test_rows_whose_question_was_late_by_more_than_a_quarter_are_told() -> None:
    ticks = np.zeros(8, [("tick", "i8"), ("wake_latency_ns", "i8"), ("computing_ns", "i8")])
    ticks["tick"] = [10, 11, 12, 13, 15, 16, 17, 18]  # 14 was skipped
    ticks["computing_ns"] = 500_000
    ticks["wake_latency_ns"] = [0, 400_000, 600_000, 0, 0, 0, 0, 0]
    ticks["computing_ns"][4] = 2_000_000
    row_tick = np.arange(9, 18)
    assert row_tick[asked_late_rows(ticks, row_tick, 2_000_000)].tolist() == [12, 15]
