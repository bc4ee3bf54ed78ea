from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from gimbal_hil.loop.timing.histogram import Histogram, upper_bound_ns

VALUES = st.lists(st.integers(0, 2**39), min_size=1, max_size=200)


@settings(deadline=None)
@given(VALUES, st.sampled_from([0.01, 0.5, 0.99, 0.999, 1.0]))
def test_a_quantile_is_right_to_one_sixteenth(values: list[int], share: float) -> None:
    histogram = Histogram()
    for value in values:
        histogram.add(value)
    ordered = sorted(values)
    exact = next(value for rank, value in enumerate(ordered, 1) if rank >= share * len(values))
    assert exact <= histogram.quantile_ns(share) <= exact * 17 / 16


@settings(deadline=None)
@given(VALUES)
def test_nothing_is_lost_and_the_largest_is_exact(values: list[int]) -> None:
    histogram = Histogram()
    for value in values:
        histogram.add(value)
    assert histogram.count == sum(histogram.counts) == len(values)
    assert histogram.largest_ns == max(values)
    assert histogram.total_ns == sum(values)
    assert histogram.cumulative((2**40,)) == [len(values)]


def test_bins_cover_the_range_without_gap() -> None:
    bounds = [upper_bound_ns(index) for index in range(500)]
    assert bounds == sorted(set(bounds))
    histogram = Histogram()
    for bound in bounds:
        histogram.add(bound)
        histogram.add(bound + 1)
    assert max(histogram.counts[:500]) <= 2


def test_negative_and_enormous_values_are_counted_at_the_ends() -> None:
    histogram = Histogram()
    histogram.add(-5)
    histogram.add(10**15)
    assert histogram.counts[0] == 1 and histogram.counts[-1] == 1
    assert Histogram().quantile_ns(0.5) == 0
