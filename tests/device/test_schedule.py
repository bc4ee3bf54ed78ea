"""The antenna's clock: set-points are its edges, its own deadlines keep their phase, stalls are counted."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from sim_backend.server import TickCause, TickSchedule

PERIOD = 1_000_000


def test_without_set_points_the_antenna_ticks_at_absolute_deadlines() -> None:
    schedule = TickSchedule(PERIOD, 0)
    for number in range(1, 50):
        assert schedule.next_ns(False) == number * PERIOD
        assert schedule.due(number * PERIOD - 1, False) is None
        assert schedule.due(number * PERIOD + 300_000, False) is TickCause.OWN_CLOCK
    assert schedule.skipped == 0


def test_a_set_point_makes_a_tick_due_at_once() -> None:
    schedule = TickSchedule(PERIOD, 0)
    schedule.due(PERIOD // 2, True)
    for number in range(1, 50):
        instant = number * PERIOD + (number % 3) * 150_000
        assert schedule.due(instant - 1, False) is None
        assert schedule.due(instant, True) is TickCause.SET_POINT
    assert schedule.skipped == 0


def test_a_host_that_falls_silent_is_replaced_by_the_own_clock_after_half_a_period() -> None:
    schedule = TickSchedule(PERIOD, 0)
    schedule.due(PERIOD, True)
    assert schedule.next_ns(False) == PERIOD + 1_500_000
    assert schedule.due(PERIOD + 1_499_999, False) is None
    assert schedule.due(PERIOD + 1_500_000, False) is TickCause.OWN_CLOCK
    assert schedule.next_ns(False) == PERIOD + 2_500_000


def test_set_points_closer_than_half_a_period_share_a_tick() -> None:
    schedule = TickSchedule(PERIOD, 0)
    schedule.due(PERIOD, True)
    assert schedule.due(PERIOD + 400_000, True) is None
    assert schedule.next_ns(True) == PERIOD + 500_000
    assert schedule.due(PERIOD + 500_000, True) is TickCause.SET_POINT


def test_a_stall_skips_whole_periods_and_keeps_the_phase() -> None:
    schedule = TickSchedule(PERIOD, 0)
    assert schedule.due(57 * PERIOD + 250_000, False) is TickCause.OWN_CLOCK
    assert schedule.skipped == 56
    assert schedule.next_ns(False) == 58 * PERIOD


def test_a_stall_that_ends_with_a_set_point_counts_the_periods_in_between() -> None:
    schedule = TickSchedule(PERIOD, 0)
    schedule.due(PERIOD, True)
    assert schedule.due(21 * PERIOD, True) is TickCause.SET_POINT
    assert schedule.skipped == 19


@given(st.lists(st.tuples(st.integers(0, 3_000_000), st.booleans()), max_size=200))
def test_ticks_and_skipped_periods_add_up_to_the_time_that_passed(moments: list[tuple[int, bool]]) -> None:
    """Within half a period for each change between the host's clock and the antenna's own."""
    schedule = TickSchedule(PERIOD, 0)
    now, ticks, changes, last = 0, 0, 1, TickCause.OWN_CLOCK
    for pause, waits in moments:
        now += pause
        cause = schedule.due(now, waits)
        if cause is not None:
            ticks += 1
            changes += int(cause is not last or cause is TickCause.SET_POINT)
            last = cause
    accounted = (ticks + schedule.skipped) * PERIOD
    assert abs(now - accounted) <= changes * PERIOD // 2 + 3_500_000
