"""What is told as off is asked of `identify` too, and where the two exclude each other nothing is named."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.discrepancy.inquiry import Policy
from gimbal_hil.knowledge.discrepancy.judgement import agreement
from gimbal_hil.knowledge.discrepancy.judgement.deciding import Decision, Kind, Status, Told
from gimbal_hil.knowledge.discrepancy.verdict.wording import _denied
from gimbal_hil.knowledge.identification import Determination, Estimate, Interval
from tests.discrepancy.static_rig import AXIS, Rig, log, model
from tests.discrepancy.test_deciding import SOUND

STATED = 2.0


def told_as(value: float, *beside: str) -> Decision:
    labels = [("inertia", AXIS), *((name, AXIS) for name in beside)]
    told = tuple(
        Told(replace(SOUND, entries=(k,), label=label), Status.NAMED, (), 0.97, 0.97, shown=True)
        for k, label in enumerate(labels)
    )
    state: Any = SimpleNamespace(hypothesis=SimpleNamespace(value=value))
    return Decision(Kind.NAMED, state, told, ())


@pytest.fixture
def inquiry(monkeypatch: pytest.MonkeyPatch) -> Any:
    def within(_: Any, state: Any, index: int) -> dict[str, tuple[float, float]]:
        value = state.hypothesis.value
        return {"inertia": (0.97 * value, 1.03 * value)}

    monkeypatch.setattr(agreement, "values_of", lambda m, t, hypothesis, index: {"inertia": (hypothesis.value, STATED)})
    monkeypatch.setattr(agreement, "parameter_intervals", within)
    return SimpleNamespace(
        logs=(log(Rig(), "laps", seconds=2.0),), twin=SimpleNamespace(model=model()), policy=Policy()
    )


def says(value: float, verdict: Determination = Determination.IDENTIFIED) -> tuple[Estimate, ...]:
    return (Estimate("inertia", value, Interval(0.95 * value, 1.05 * value), "kg", verdict, value),)


@pytest.mark.parametrize(
    ("told", "identified", "named"),
    [
        # a third of the mass, where a regression has all of it
        (0.68, says(2.02), False),
        # the regression agrees that it is off, if not to the percent
        (0.68, says(0.9), True),
        # or its interval holds what was told
        (1.9, says(1.97), True),
        (0.68, says(2.02, Determination.WEAKLY_IDENTIFIED), True),
        (0.68, (), True),
    ],
)
def test_a_number_that_identify_denies_to_be_off_is_no_name_and_neither_is_what_stands_beside_it(
    inquiry: Any, monkeypatch: pytest.MonkeyPatch, told: float, identified: tuple[Estimate, ...], named: bool
) -> None:
    monkeypatch.setattr(agreement, "numbers_of_motion", lambda *_: identified)
    found = agreement.with_identification(inquiry, told_as(told, "load_dependent_friction"))
    statuses = {one.status for one in found.told}
    assert statuses == ({Status.NAMED} if named else {Status.AMBIGUOUS})
    assert found.kind is (Kind.NAMED if named else Kind.AMBIGUOUS)
    if not named:
        (denial,) = found.told[0].denials
        assert "2.02 kg (1.919 to 2.121)" in _denied(denial) and "0.68" in _denied(denial)


def test_a_number_is_known_no_better_than_either_method_allows(inquiry: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    mine = {"inertia": (1.843, 1.957)}
    for said, told in ((2.0, (1.843, 2.1)), (1.9, (1.805, 1.995)), (4.0, (1.843, 1.957))):
        monkeypatch.setattr(agreement, "numbers_of_motion", lambda *_, said=said: says(said))
        found = agreement.with_identification(inquiry, told_as(1.9))
        assert agreement.intervals_of_both(found, ("inertia", AXIS), mine)["inertia"] == pytest.approx(told)


def test_logs_that_no_regression_can_use_deny_nothing(inquiry: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any) -> Any:
        raise BadInputError("log", "too short", "more rows")

    monkeypatch.setattr(agreement, "numbers_of_motion", refused)
    assert agreement.with_identification(inquiry, told_as(0.68)).kind is Kind.NAMED


def test_what_only_a_search_knows_is_not_asked(inquiry: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(agreement, "numbers_of_motion", lambda *_: pytest.fail("nothing to ask"))
    decision = told_as(0.68, "cable_spring")
    assert agreement.with_identification(inquiry, replace(decision, told=decision.told[1:])).kind is Kind.NAMED


def test_the_numbers_of_a_sliding_axis_are_identified_from_its_motion_alone(inquiry: Any) -> None:
    inquiry.logs = (log(Rig(), "sweep", seconds=12.0),)
    found = agreement._identified(inquiry, AXIS)
    rig = Rig()
    for name, true in (("inertia", rig.mass), ("coulomb", rig.coulomb), ("viscous", rig.viscous)):
        assert found[name].value == pytest.approx(true, rel=0.1), name
