"""What the report's figures are made of."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.verdict.gaps import Gap, _rms_within, closed_most, largest
from gimbal_hil.knowledge.discrepancy.verdict.page_figures import gap_figure, sliced_mean, with_the_rest
from gimbal_hil.knowledge.discrepancy.verdict.where import Regime, RegimeGroup


def regime(group: RegimeGroup, text: str, gap: float, time: float) -> Regime:
    return Regime("outer", "torque", text, group, gap, gap - 0.05, gap + 0.05, time)


def test_the_bars_of_every_group_add_up_to_one() -> None:
    found = with_the_rest(
        [
            regime(RegimeGroup.SPEED, "slow", 0.5, 0.2),
            regime(RegimeGroup.SPEED, "fast", 0.3, 0.6),
            regime(RegimeGroup.TIME, "second half", 0.55, 0.5),
            regime(RegimeGroup.POSITION, "low", 0.4, 0.5),
            regime(RegimeGroup.POSITION, "high", 0.6, 0.5),
        ]
    )
    for group in (RegimeGroup.SPEED, RegimeGroup.TIME, RegimeGroup.POSITION):
        own = [r for r in found if r.group == group]
        assert sum(r.share_of_gap for r in own) == pytest.approx(1.0)
        assert sum(r.share_of_time for r in own) == pytest.approx(1.0)
        # bars of one group stand together
        assert [found.index(r) for r in own] == list(range(found.index(own[0]), found.index(own[0]) + len(own)))
    rest = {r.group: r for r in found if r.regime == "the rest"}
    assert set(rest) == {RegimeGroup.SPEED, RegimeGroup.TIME}
    assert (rest[RegimeGroup.TIME].low, rest[RegimeGroup.TIME].high) == pytest.approx((0.40, 0.50))


def test_a_ripple_of_seven_periods_a_turn_stands_in_the_mean_over_position_above_noise_ten_times_its_size() -> None:
    rng = np.random.default_rng(3)
    position = rng.uniform(-np.pi, np.pi, 400_000)
    left = 0.02 * np.sin(7.0 * position) + rng.normal(0.0, 0.2, len(position))
    place, mean = sliced_mean(position, left)
    spectrum = np.abs(np.fft.rfft(mean))
    assert int(np.argmax(spectrum)) == 7
    assert 2.0 * spectrum[7] / len(mean) == pytest.approx(0.02, rel=0.1)
    assert place[0] > -np.pi and place[-1] < np.pi


def test_slices_with_few_rows_are_joined_with_the_next_and_no_row_is_lost() -> None:
    rng = np.random.default_rng(1)
    for count in (1, 3, 4, 5, 100, 3000):
        x, y = rng.standard_normal(count) ** 3, rng.standard_normal(count)
        place, mean = sliced_mean(x, y)
        assert np.all(np.isfinite(mean)) and np.all(np.diff(place) > 0.0)
        assert len(mean) <= max(1, count // 4)
    place, mean = sliced_mean(np.array([0.0] * 4 + [0.5] + [1.0] * 4), np.array([1.0] * 4 + [5.0] + [0.0] * 4))
    assert mean == pytest.approx([1.0, 1.0]) and place == pytest.approx([0.0, 0.9])


def test_the_page_shows_the_gap_that_its_text_speaks_of() -> None:
    def gap(signal: str, before: float, after: float) -> Gap:
        return Gap(
            "outer", signal, "N m", (0.0, 40.0), before, before, after, 1.0, 1.0, "", 0.0, *[None] * 3, before, before
        )

    torque, rate = gap("torque", 90.0, 30.0), gap("rate_error", 190.0, 190.0)
    assert closed_most((rate, torque)) is torque and largest((torque, rate)) is rate


def test_a_gap_that_closes_to_the_floor_is_drawn_before_and_after() -> None:
    channels = [("torque", 136.0, 1.08), ("rate_error", 1.0, 1.0)]
    gaps = [
        {"axis": "EL", "signal": signal, "before": before, "after": after, "processing_floor": 0.0, "noise_floor": 1.0}
        for signal, before, after in channels
    ]
    drawn = gap_figure({"gaps": gaps, "effects": [{}], "laws": []}).to_dict()
    assert [bars["name"] for bars in drawn["data"] if bars.get("type") == "bar"] == ["before", "after"]


def test_the_interval_of_a_gap_holds_it_where_a_few_rows_have_it_all() -> None:
    squares = np.concatenate([np.full(990, 0.1), np.full(57, 800.0)])
    low, high = _rms_within(squares, 200)
    assert low < np.sqrt(squares.mean()) < high
