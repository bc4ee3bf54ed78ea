"""Numbers that logs say nothing of get a motion in which half or twice of each would leave a gap."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.knowledge.improvement.choosing import Apart
from gimbal_hil.knowledge.improvement.showing import HiddenShown
from gimbal_hil.surface.cli.app import run
from sim_backend.model import shipped_model


def apart(squares: float, taken: float) -> Apart:
    """An error that leaves so many squares, of which another number that nothing holds takes a share."""
    return Apart(squares, np.array([np.sqrt(squares * taken)]), np.array([[1.0]]), np.array([[0.0]]))


@given(st.lists(st.tuples(st.floats(1e-3, 1e9), st.floats(0.0, 0.99)), min_size=1, max_size=6), st.integers(1, 20))
def test_all_numbers_together_are_never_said_to_show_more_than_the_one_that_shows_least(
    errors: list[tuple[float, float]], times: int
) -> None:
    shown = HiddenShown(tuple(apart(*one) for one in errors), 500, 1.5)
    least = min(one.beyond(times) for one in shown.errors)
    assert 0.0 < shown.expected(times) <= least * (1.0 + 1e-9)
    assert shown.expected(2 * times) > shown.expected(times)
    assert shown.needed(2 * times) == pytest.approx(2.0 * shown.needed(times))


def test_an_error_that_other_numbers_take_whole_shows_nothing() -> None:
    assert HiddenShown((apart(50.0, 0.2), apart(50.0, 1.0)), 500, 1.5).expected() == 0.0


@pytest.mark.heavy
def test_a_verdict_that_cannot_judge_is_decided_by_the_motion_that_it_writes(tmp_path: Path) -> None:
    """Only the outer axis moved; the inner one's numbers show in the motion that was made, right or wrong."""
    for seed, name in enumerate(("searched", "held")):
        words = ["plateaus", "--axis", "outer", "--short", "--seed", str(seed), "--out", str(tmp_path / name)]
        assert run("experiment", words) == 0
    logs = ["--measured", str(tmp_path / "searched"), "--workers", "1"]
    out, made = tmp_path / "out", tmp_path / "made"
    assert run("discrepancy", [*logs, "--holdout", str(tmp_path / "held"), "--out", str(out), "--settle"]) == 0
    open_one = json.loads((out / "verdict.json").read_text())
    hidden = {(one["name"], one["axis"]) for one in open_one["would_not_show"]}
    assert open_one["verdict"] == "cannot_judge"
    assert hidden == {("coulomb", "inner"), ("inertia", "inner"), ("viscous", "inner")}
    assert run("experiment", [str(out / "settle.yaml"), "--out", str(made)]) == 0

    judged = [*logs, "--holdout", str(made)]
    assert run("discrepancy", [*judged, "--out", str(tmp_path / "right")]) == 0
    right = json.loads((tmp_path / "right" / "verdict.json").read_text())
    assert right["verdict"] == "no_discrepancy" and not right["would_not_show"], right["text"]

    model = shipped_model()
    levels = {path: 1.5 * model.number("inner", path) for path in ("friction.coulomb", "friction.breakaway")}
    wrong = model.with_numbers("inner", levels)
    (tmp_path / "wrong.yaml").write_text(wrong.to_yaml(), encoding="utf-8")
    assert run("discrepancy", [*judged, "--model", str(tmp_path / "wrong.yaml"), "--out", str(tmp_path / "told")]) == 0
    told = json.loads((tmp_path / "told" / "verdict.json").read_text())
    assert ("coulomb", "inner") in {(one["name"], one["axis"]) for one in told["effects"]}, told["text"]
