"""The pages of tuning tell a gain where there is one, and say so where there is none."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from gimbal_hil.knowledge.tuning import Aim, AxisTuning, LoopFigures, Tuning
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.pages.report import Page
from gimbal_hil.pointing.arena import (
    BEFORE,
    FIRST,
    IMPROVED,
    ArenaResult,
    Entrant,
    Paid,
    TrialOutcome,
    chosen,
    controller_settings,
    gained_blocks,
    gained_text,
    paid_blocks,
    paid_text,
    shipped_scenarios,
)
from gimbal_hil.surface.cli.tune_report import TuningAsked, report
from sim_backend.model import shipped_model

SCENARIOS = tuple(chosen(shipped_scenarios(), words)[0] for words in ("case 5", "0.003 rad/s"))


def arena(errors: dict[str, tuple[float, float]]) -> ArenaResult:
    """Line-of-sight errors (rad) of controllers by name in both scenarios; a NaN tripped."""
    outcomes = [
        TrialOutcome(one.name, name, "realistic", 1, "travel" if value != value else "", value)
        for name, values in errors.items()
        for one, value in zip(SCENARIOS, values, strict=True)
    ]
    entrants = tuple(Entrant(name, shipped_settings(), name) for name in errors)
    return ArenaResult(SCENARIOS, ("realistic",), (("outer", "inner"),), entrants, 1, tuple(outcomes))


FIGURES = LoopFigures(0.41, 100.0, 20e-6, 1e-6, True)
TUNING = Tuning(
    (AxisTuning("outer", LoopFigures(0.0, 0.0, float("inf"), float("inf"), False), FIGURES, None, {}),), {}, {}
)


def test_the_gain_is_how_many_times_smaller_the_error_is(tmp_path: Path) -> None:
    found = arena({"before": (80e-6, 10e-6), "tuned": (20e-6, 5e-6)})
    said = gained_text(found)
    assert said.startswith(
        "Tuned, the line-of-sight error on the antenna realistic is 3.0 times smaller in the median of 2 scenarios, "
        "and at least 2.0"
    )
    page = Page("Tuning", "", gained_blocks(found, TUNING, ["outer gyro.bandwidth 1257 rad/s"]))
    text = page.write(tmp_path / "page.html").read_text()
    assert 'class="callout good"' in text and "4.0" in text and "gyro.bandwidth 1257" in text and "not stable" in text


WORSE = "In one it is 2.00 times larger: base: table 3.1, case 5."


@pytest.mark.parametrize(
    ("after", "words"),
    [
        ((160e-6, 5e-6), WORSE),
        ((float("nan"), float("nan")), "No scenario was run"),
        (
            (float("nan"), 5e-6),
            "2.0 times smaller in the only scenario that ended",
        ),
    ],
)
def test_a_row_that_got_worse_or_tripped_is_said(after: tuple[float, float], words: str) -> None:
    found = arena({"before": (80e-6, 10e-6), "tuned": after})
    assert words in gained_text(found)
    assert 'class="callout warning"' in Page("a", "b", gained_blocks(found, TUNING, [])).render()


def paid(improved: tuple[float, float]) -> Paid:
    found = arena(
        {BEFORE: (80e-6, 10e-6), FIRST: (20e-6, 5e-6), IMPROVED: improved, "without inner friction": (20e-6, 5e-6)}
    )
    return Paid(found, "realistic", ("inner friction",))


def test_an_improved_model_that_points_worse_than_before_is_no_good_news() -> None:
    worse, better = (paid((value, 2.5e-6)) for value in (160e-6, 10e-6))
    assert WORSE in paid_text(worse) and 'class="callout warning"' in Page("a", "b", paid_blocks(worse)).render()
    assert 'class="callout good"' in Page("a", "b", paid_blocks(better)).render()


def test_the_first_model_is_tuned_for_what_the_improved_one_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[float, Aim]] = []

    def tuning(settings: object, model: object, name: str, margin: float, aim: Aim = Aim.TRACKING) -> Tuning:
        asked.append((margin, aim))
        return TUNING

    monkeypatch.setattr("gimbal_hil.knowledge.tuning.tuned", tuning)
    monkeypatch.setattr("gimbal_hil.pointing.arena.what_paid", lambda *rest: paid((10e-6, 2.5e-6)))
    after = controller_settings("bodies")
    report(tmp_path, shipped_settings(), after, shipped_model("realistic"), TuningAsked(0.5, Aim.POINTING, 1))
    assert asked == [(0.5, Aim.POINTING)]


def test_no_share_is_told_of_a_gain_that_is_none() -> None:
    alike = paid((20.2e-6, 4.95e-6))
    assert not alike.gains and "%" not in paid_text(alike)
    better = paid((10e-6, 2.5e-6))
    assert better.gains and better.gained == pytest.approx(0.75) and "100.0 %" in paid_text(better)
    assert dataclasses.replace(better, parts=()).gains
