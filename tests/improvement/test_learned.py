"""What a diagnosis teaches about numbers: a prior for the next search, and what the model file says of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy import Kind, Verdict, attributed, refusal
from gimbal_hil.knowledge.discrepancy.verdict.gaps import Gap
from gimbal_hil.knowledge.improvement import loop
from gimbal_hil.knowledge.improvement.learned import learned
from gimbal_hil.knowledge.improvement.loop import _Loop
from gimbal_hil.knowledge.improvement.task import NextStep
from sim_backend.model import AntennaModel, load_model, shipped_model
from tests.improvement.sessions import improved, task_of, virtual

START = shipped_model()
MOMENTS = [f"body.inertia.{c}" for c in ("xx", "yy", "zz")]
PRODUCTS = [f"body.inertia.{c}" for c in ("xy", "xz", "yz")]


def moved(path: str, to: float, half_width: float, named: bool, axis: str = "inner") -> dict[str, Any]:
    """A number as a verdict lists it."""
    stated = START.uncertainty(axis, path)
    # as they come of arrays
    ends = {"low": np.float64(to - half_width), "high": np.float64(to + half_width), "uncertainty": stated}
    return {"axis": axis, "path": path, "from": START.number(axis, path), "to": to, "named": named, **ends}


def verdict(entry: dict[str, Any], effect: str | None = None, status: str = "named") -> Verdict:
    """A verdict that moved one number, as an effect that it tells or inside what was said of it."""
    effects = () if effect is None else ({"name": effect, "axis": entry["axis"], "status": status},)
    return replace(refusal(""), recalibrated=(entry,), effects=effects)


def test_a_named_moment_is_known_no_better_than_it_turned_out_and_the_whole_tensor_with_it() -> None:
    yy = START.number("inner", "body.inertia.yy")
    taught = learned(START, verdict(moved("body.inertia.yy", 1.2 * yy, 1e-5, True), "inertia"))
    assert taught.number("inner", "body.inertia.yy") == pytest.approx(1.2 * yy)
    assert taught.uncertainty("inner", "body.inertia.yy") == pytest.approx(0.2 * yy)
    assert "identified" not in (taught.numbers["inner", "body.inertia.yy"].source or "")
    for path in ("body.inertia.xx", "body.inertia.zz"):
        assert taught.number("inner", path) == START.number("inner", path)
        assert taught.uncertainty("inner", path) == pytest.approx(0.2 * START.number("inner", path))
        assert taught.numbers["inner", path].source == START.numbers["inner", path].source
    together = sum(START.number("inner", path) ** 2 for path in PRODUCTS) ** 0.5
    assert [taught.uncertainty("inner", path) for path in PRODUCTS] == pytest.approx([0.2 * together] * 3)
    other = {path: taught.uncertainty("outer", path) for path in (*MOMENTS, *PRODUCTS)}
    assert other == {path: START.uncertainty("outer", path) for path in other}


def test_a_named_friction_says_nothing_of_other_numbers() -> None:
    viscous = START.number("inner", "friction.viscous")
    taught = learned(START, verdict(moved("friction.viscous", 1.5 * viscous, 1e-4, True), "viscous"))
    changed = {place for place in START.numbers if taught.uncertainty(*place) != START.uncertainty(*place)}
    assert changed == {("inner", "friction.viscous")}


@pytest.mark.parametrize(("effect", "status", "named"), [("inertia", "ambiguous", True), (None, "", False)])
def test_what_is_not_named_teaches_nothing(effect: str | None, status: str, named: bool) -> None:
    yy = START.number("inner", "body.inertia.yy")
    assert learned(START, verdict(moved("body.inertia.yy", 1.2 * yy, 1e-5, named), effect, status)) is START


@pytest.mark.parametrize("share", [0.2, 3.0])
def test_only_a_number_known_better_than_before_is_called_identified(share: float) -> None:
    path = "friction.coulomb"
    stated = START.uncertainty("inner", path)
    to, half_width = START.number("inner", path) + 0.5 * stated, share * stated
    after: AntennaModel = START.with_number("inner", path, to, "identified by somebody")
    told = attributed(START, after, verdict(moved(path, to, half_width, False)))
    assert path.rsplit(".", maxsplit=1)[-1] in told.to_yaml()
    source, is_better = told.numbers["inner", path].source or "", share < 1.0
    assert told.number("inner", path) == to
    assert source.startswith("identified") == is_better
    assert told.uncertainty("inner", path) == pytest.approx(half_width if is_better else stated)


def test_a_number_of_which_a_verdict_says_nothing_keeps_source_and_uncertainty() -> None:
    after = START.with_number("inner", "friction.sigma1", 7.0, "identified by somebody")
    told = attributed(START, after, refusal(""))
    assert told.numbers["inner", "friction.sigma1"].source == START.numbers["inner", "friction.sigma1"].source
    assert told.uncertainty("inner", "friction.sigma1") == START.uncertainty("inner", "friction.sigma1")


def test_a_named_number_with_a_gap_left_is_searched_again_from_what_was_learned_before_anything_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    yy = START.number("inner", "body.inertia.yy")
    left = Gap(
        "inner", "torque", "N m", (0.0, 25.0), 0.3, 0.3, 0.01, 0.001, 0.001, "", 0.0, None, None, None, 0.3, 0.3
    )  # fmt: skip
    told = replace(
        verdict(moved("body.inertia.yy", 1.2 * yy, 1e-5, True), "inertia"), kind=Kind.AMBIGUOUS, gaps=(left,)
    )
    begun: list[AntennaModel] = []

    def searched(self: _Loop, number: int) -> SimpleNamespace:
        begun.append(self.base)
        return SimpleNamespace(model=self.base)

    monkeypatch.setattr(_Loop, "_first_surveys", lambda self: None)
    monkeypatch.setattr(_Loop, "_searched", searched)
    for number in (1, 2):
        (tmp_path / f"round_{number}").mkdir()
    monkeypatch.setattr(_Loop, "_keep", lambda self, *_: None)
    monkeypatch.setattr(_Loop, "_decide", lambda self, *_: (NextStep.AT_THE_FLOOR, None, None))
    monkeypatch.setattr(loop, "verdict_of", lambda diagnosis: told)
    done = improved(task_of(tmp_path), virtual(START))
    assert [one.decision for one in done.diagnoses] == [NextStep.AGAIN.value, NextStep.AT_THE_FLOOR.value]
    assert begun[0].document == START.document
    assert begun[1].number("inner", "body.inertia.yy") == pytest.approx(1.2 * yy)
    assert load_model(tmp_path / "round_1" / "base.yaml").uncertainty("inner", "body.inertia.xx") > 0.1 * yy / 3.0
