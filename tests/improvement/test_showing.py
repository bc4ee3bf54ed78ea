"""Numbers that logs say nothing of get a motion in which half or twice of each would leave a gap."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gimbal_hil.knowledge.discrepancy import NumberError, Twin
from gimbal_hil.knowledge.executor import WorkExecutor, open_executor
from gimbal_hil.knowledge.experiments import load_plan
from gimbal_hil.knowledge.improvement import budgets_of, design, showing
from gimbal_hil.knowledge.improvement.apart import Apart
from gimbal_hil.knowledge.improvement.design import Design, DesignTask
from gimbal_hil.knowledge.improvement.motion import drawn, ranges_of
from gimbal_hil.knowledge.improvement.showing import HiddenNumbers, HiddenShown, shown_by_one
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.surface.cli.app import run
from sim_backend.model import shipped_model

#: how far the one coordinate may go either way
FREE = (np.array([-np.inf]), np.array([np.inf]))


def apart(squares: float, taken: float) -> Apart:
    """An error that leaves so many squares, of which another number that nothing holds takes a share."""
    return Apart(squares, np.array([np.sqrt(squares * taken)]), np.array([[1.0]]), np.array([[0.0]]), *FREE)


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


def errors(*names: str) -> HiddenNumbers:
    """A question about so many numbers of the inner axis."""
    made = tuple(cast(NumberError, SimpleNamespace(label=(name, "inner"))) for name in names)
    return HiddenNumbers(made, shipped_model(), cast(Twin, None), np.ones(1), 1.5)


def shows(*together: set[str]) -> Callable[..., Design | None]:
    """Motions that show these sets of numbers and what lies in them, more of them by those that come first."""

    def search(task: DesignTask, executor: WorkExecutor, **_: object) -> Design | None:
        asked = {error.label[0] for error in cast(HiddenNumbers, task.question).errors}
        rank = next((k for k, numbers in enumerate(together) if asked <= numbers), None)
        motion = drawn(np.random.default_rng(1), ranges_of(task.settings, task.budgets), 1)
        return None if rank is None else Design(motion, 500.0 / (1.0 + rank), 1.0, 10.0)

    return search


@pytest.mark.parametrize(
    ("together", "shown", "not_shown"),
    [
        ([{"inertia", "coulomb", "viscous"}], "inertia coulomb viscous", ""),
        ([{"inertia", "coulomb"}], "inertia coulomb", "viscous"),
        # all three by themselves, but not together: without the weakest
        ([{"coulomb", "viscous"}, {"inertia"}], "coulomb viscous", "inertia"),
        ([{"viscous"}, {"coulomb"}], "viscous", "inertia coulomb"),
    ],
)
def test_where_no_motion_shows_a_number_one_is_made_for_the_others(
    together: list[set[str]], shown: str, not_shown: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for module in (design, showing):
        monkeypatch.setattr(module, "designed", shows(*together))
    asked, settings = errors("inertia", "coulomb", "viscous"), shipped_settings()
    task = DesignTask(asked, settings, budgets_of(settings, 120.0, 1, {}, {}))
    with open_executor(1, None) as executor:
        found = shown_by_one(task, asked, tmp_path / "made.yaml", executor)
        assert found is not None
        assert sorted(name for name, _ in found.shows) == sorted(shown.split())
        assert [name for name, _ in found.not_shown] == not_shown.split()
        assert all(f"{name} of inner" in load_plan(tmp_path / "made.yaml").text for name in shown.split())
        monkeypatch.setattr(design, "designed", shows())
        monkeypatch.setattr(showing, "designed", shows())
        assert shown_by_one(task, asked, tmp_path / "none.yaml", executor) is None
    assert not (tmp_path / "none.yaml").exists()


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
