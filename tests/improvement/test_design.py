"""Motions that are made for a question stay inside the limits, are plans that anybody can run, and are found again."""

from __future__ import annotations

import math
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gimbal_hil.knowledge.discrepancy import Hypothesis, known_numbers
from gimbal_hil.knowledge.discrepancy.inquiry.inquiry import State
from gimbal_hil.knowledge.executor import open_executor
from gimbal_hil.knowledge.experiments import load_plan, plan_from_document
from gimbal_hil.knowledge.improvement import budgets_of, design
from gimbal_hil.knowledge.improvement.apart import Apart, Coordinates, inert_numbers
from gimbal_hil.knowledge.improvement.choosing import WORTH, OpenQuestion, Option, Pair, reason
from gimbal_hil.knowledge.improvement.design import Design, DesignTask, designed, made_for
from gimbal_hil.knowledge.improvement.motion import (
    MADE,
    AxisMove,
    AxisRange,
    LapMotion,
    MotionSegment,
    drawn,
    experiment_of_motion,
    plan_of,
    ranges_of,
    varied,
)
from gimbal_hil.knowledge.improvement.rehearsal import rehearse
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.model import shipped_model

RANGES = (AxisRange(-0.8, 0.8, 2.0, 12.0), AxisRange(-0.3, 0.9, 3.0, 20.0))
SETTINGS = shipped_settings()
BUDGETS = budgets_of(SETTINGS, 900.0, 3, {}, {})
TASK = DesignTask(cast(OpenQuestion, None), SETTINGS, BUDGETS)
PAIR = Pair(cast(State, None), cast(State, None), (("cable_spring", "inner"), ("static_unbalance", "inner")))

#: how far a coordinate may go either way
FREE = (np.array([-np.inf]), np.array([np.inf]))


def peaks(motion: LapMotion) -> tuple[list[float], list[float], list[float], list[float]]:
    """Over two laps: largest rate (rad/s) and acceleration (rad/s^2) and both ends of the travel (rad) of each axis."""
    at, rate, acceleration, low, high = ([0.0, 0.0] for _ in range(5))
    for segment in 2 * motion.segments:
        for i, move in enumerate(segment.moves):
            if move.to_rad is None:
                turns = 2.0 * math.pi * move.swing_hz
                rate[i] = max(rate[i], turns * move.swing_rad)
                acceleration[i] = max(acceleration[i], turns**2 * move.swing_rad)
                continue
            way = abs(move.to_rad - at[i])
            rate[i] = max(rate[i], 1.875 * way / segment.over_s)
            acceleration[i] = max(acceleration[i], 10.0 / math.sqrt(3.0) * way / segment.over_s**2)
            at[i] = move.to_rad
            low[i], high[i] = min(low[i], at[i]), max(high[i], at[i])
    return rate, acceleration, low, high


@given(st.integers(0, 2**31), st.integers(0, 30))
@settings(max_examples=60, deadline=None)
def test_a_motion_keeps_to_rate_acceleration_travel_and_time_however_often_it_is_varied(seed: int, times: int) -> None:
    rng = np.random.default_rng(seed)
    motion = drawn(rng, RANGES, seed)
    for _ in range(times):
        motion = varied(rng, RANGES, motion)
    rate, acceleration, low, high = peaks(motion)
    for i, one in enumerate(RANGES):
        assert rate[i] <= one.rate_rad_s * (1.0 + 1e-9)
        assert acceleration[i] <= one.acceleration_rad_s2 * (1.0 + 1e-3)
        assert one.low_rad <= low[i] + 1e-12 and high[i] - 1e-12 <= one.high_rad
    lap_s = sum(segment.over_s for segment in motion.segments)
    assert lap_s >= 1.5 - 1e-9 and (motion.most_laps == 1 or motion.most_laps * lap_s <= 32.0)


def test_more_evidence_than_plenty_does_not_make_a_motion_better_and_a_shorter_one_is() -> None:
    motion = drawn(np.random.default_rng(1), RANGES, 1)
    little, plenty, chatter, shorter = (
        Design(motion, expected, WORTH, duration_s)
        for expected, duration_s in (
            (100.0 * WORTH, 20.0),
            (1e4 * WORTH, 20.0),
            (1e9 * WORTH, 20.0),
            (1e4 * WORTH, 10.0),
        )
    )
    assert little.merit < plenty.merit == chatter.merit < shorter.merit


def test_a_motion_is_a_plan_file_with_guards_and_can_be_run() -> None:
    motion = LapMotion(
        (
            MotionSegment((AxisMove(0.3), AxisMove(None, 0.01, 5.0)), 0.8),
            MotionSegment((AxisMove(0.0), AxisMove(-0.1)), 0.7),
        )
    )
    plan = plan_from_document(plan_of(motion, "what it is for", SETTINGS, BUDGETS), "made", SETTINGS.axis_names)
    assert plan.name == MADE and plan.text == "what it is for"
    assert all(segment.guards.outer.torque_nm is not None for segment in plan.segments[1:])
    rehearsal = rehearse(experiment_of_motion(motion, "", SETTINGS, BUDGETS), SETTINGS, shipped_model())
    assert rehearsal.stopped is None and rehearsal.table is not None
    low, high = rehearsal.travel_rad["outer"]
    assert high == pytest.approx(0.3, abs=0.02) and low > -0.02
    low, high = rehearsal.travel_rad["inner"]
    assert low == pytest.approx(-0.1, abs=0.01) and high == pytest.approx(0.01, rel=0.3)


def test_laps_are_written_one_after_the_other_and_begin_where_the_one_before_ended() -> None:
    lap = (MotionSegment((AxisMove(0.2), AxisMove()), 0.5), MotionSegment((AxisMove(), AxisMove(None, 0.01, 4.0)), 0.5))
    segments = plan_of(LapMotion(lap, 2), "", SETTINGS, BUDGETS)["segments"]
    assert [one["name"] for one in segments[2:]] == [f"segment {n}, lap {k}" for k in (1, 2) for n in (1, 2)]
    assert segments[2]["inner"] == {"mode": "position", "value_rad": 0.0}
    assert segments[3]["outer"] == {"mode": "position", "value_rad": 0.2} == segments[5]["outer"]


def test_so_many_laps_tell_what_as_many_tables_would() -> None:
    """Linear in the table where nothing can refit; where all can, no more than what data so far hold."""
    one = Apart(100.0, np.array([10.0]), np.array([[1.0]]), np.array([[4.0]]), *FREE)
    two = Apart(200.0, np.array([20.0]), np.array([[2.0]]), np.array([[4.0]]), *FREE)
    assert one.beyond(2) == pytest.approx(two.beyond(1)) and one.beyond(1) == pytest.approx(0.5 * (100.0 - 100.0 / 5.0))
    stiff = Apart(100.0, np.zeros(1), np.zeros((1, 1)), np.eye(1), *FREE)
    assert stiff.beyond(7) == pytest.approx(7.0 * stiff.beyond(1))


def test_a_difference_that_the_best_explanation_takes_back_itself_tells_nothing() -> None:
    rows = np.array([[3.0], [4.0]])
    of_rival, of_best = np.array([[1.0], [0.0]]), np.array([[0.0], [1.0]])
    rival, best = (Coordinates(columns, 1e-12 * np.eye(1), *FREE) for columns in (of_rival, of_best))
    # each by itself leaves what the other one would take, 16 and 9; a row counts for a half
    assert rival.apart(rows).beyond(1) == pytest.approx(8.0)
    assert rival.beside(best).apart(rows).beyond(1) == pytest.approx(0.0, abs=1e-9)


def test_numbers_that_did_nothing_so_far_may_make_up_for_a_motion_as_far_as_the_others() -> None:
    model = shipped_model().with_number("inner", "friction.viscous", 0.03, None, 0.001)
    every = known_numbers(model)
    inner = [known for known in every if known.axis == "inner"]
    null = Hypothesis(floating=tuple(inner[1:]), y=(0.0,) * (len(inner) - 1))
    more = inert_numbers(model, null)
    assert inner[0] in more and not set(more) & set(null.floating)
    assert {known.axis for known in more} == set(model.axes)


def test_an_explanation_does_what_it_can_about_a_difference_and_goes_no_further_than_it_may() -> None:
    """Friction over position that swings half a time a turn passes for a constant level only where little is moved."""
    slope, normal, held = np.array([-10.0, 1e-3]), np.diag([1.0, 1e-6]), np.zeros((2, 2))
    free, near = (Apart(101.0, slope, normal, held, -np.full(2, far), np.full(2, far)) for far in (1e9, 4.0))
    assert free.beyond(1) == pytest.approx(0.0)
    assert near.beyond(1) == pytest.approx(0.5 * (1.0 + 6.0**2 - 4.0 * 2e-3 + 16e-6), rel=1e-9)


def test_what_is_drawn_is_inside_the_budgets_and_what_the_loops_follow() -> None:
    narrow = budgets_of(SETTINGS, 900.0, 3, {}, {"inner": (-0.2, 0.6)})
    outer, inner = ranges_of(SETTINGS, narrow)
    assert -0.2 < inner.low_rad < 0.0 and 0.4 < inner.high_rad < 0.6
    assert outer.high_rad <= math.pi
    shaped = SETTINGS.axes["outer"].prefilter
    assert shaped is not None and shaped.rate_rad_s is not None and outer.rate_rad_s < shaped.rate_rad_s


def test_the_reason_says_what_was_made_and_what_it_is_worth() -> None:
    said = reason(PAIR, Option(MADE, "inner", 1234.0, 8.0))
    assert "made to separate cable spring on inner from static unbalance on inner" in said and "8 s" in said


def by_travel(task: DesignTask, motion: LapMotion) -> Design:
    """As if wide motion of the first axis showed it."""
    wide = sum(abs(segment.moves[0].to_rad or 0.0) for segment in motion.segments)
    return Design(motion, 100.0 * WORTH * wide, WORTH, sum(segment.over_s for segment in motion.segments))


def test_the_same_seed_gives_the_same_motion_and_one_that_beats_what_was_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(design, "_tried", by_travel)
    monkeypatch.setattr(design, "_whole", by_travel)
    with open_executor(1, None) as executor:
        one, again = designed(TASK, executor, seed=4), designed(TASK, executor, seed=4)
        only_drawn = designed(TASK, executor, seed=4, generations=0)
    assert one is not None and one == again
    assert only_drawn is not None and one.per_second > 1.2 * only_drawn.per_second


def test_where_nothing_shows_enough_or_all_is_refused_no_motion_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    with open_executor(1, None) as executor:
        monkeypatch.setattr(design, "_tried", lambda task, motion: Design(motion, 0.5 * WORTH, WORTH, 4.0))
        assert designed(TASK, executor) is None
        monkeypatch.setattr(design, "_tried", lambda task, motion: None)
        assert designed(TASK, executor) is None


def test_a_motion_that_the_model_as_it_is_may_not_make_leaves_no_plan(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(design, "_tried", by_travel)
    monkeypatch.setattr(design, "_whole", by_travel)
    weak = DesignTask(TASK.question, SETTINGS, budgets_of(SETTINGS, 900.0, 3, {"outer": 0.1}, {}))
    with open_executor(1, None) as executor:
        assert made_for(weak, PAIR, shipped_model(), tmp_path / "weak.yaml", executor) is None
        made = made_for(TASK, PAIR, shipped_model(), tmp_path / "made.yaml", executor)
    assert made is not None and made.is_made and not (tmp_path / "weak.yaml").exists()
    assert "cable spring on inner from static unbalance on inner" in load_plan(tmp_path / "made.yaml").text
