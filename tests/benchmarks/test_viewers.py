"""The comparison with and without viewers is measured turn by turn, and viewers cost no miss of the loop's own."""

from __future__ import annotations

import pytest

from tests.benchmarks.viewers import Stretch, measured, ratios

pytestmark = pytest.mark.realtime


def test_neighbouring_stretches_are_compared_whichever_came_first() -> None:
    pairs = [(Stretch(0, 10, 2.0, 40.0, 0, 0), Stretch(9, 10, 3.0, 20.0, 0, 0)), (Stretch(0, 10, 4.0, 10.0, 0, 0),) * 2]
    assert ratios(pairs, "p50_us") == (1.25, 1.0, 1.5) and ratios(pairs, "p99_us") == (0.75, 0.5, 1.0)


@pytest.mark.heavy
def test_a_short_comparison_counts_its_ticks_and_finds_no_miss_that_viewers_caused() -> None:
    pairs = measured(2, 1.5, 5)
    for alone, looked in pairs:
        assert (alone.viewers, looked.viewers) == (0, 5)
        assert alone.ticks > 500 and looked.ticks > 500
        assert 0.0 < alone.p50_us <= alone.p99_us
        assert looked.missed_own == 0
