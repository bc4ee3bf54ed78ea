"""What could stand in the place of a cause is a matter of the two and of the data, not of what else is missing."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy.hypotheses import Fit, Hypothesis
from gimbal_hil.knowledge.discrepancy.search import candidates, search
from gimbal_hil.knowledge.discrepancy.search.screening import Proposal
from gimbal_hil.knowledge.discrepancy.search.search import Path, Round
from gimbal_hil.knowledge.discrepancy.twin import Floats

DELAY, LAG, CENTRE = ("transport_delay", "outer"), ("actuator_lag", "outer"), ("static_unbalance", "inner")


@dataclass(frozen=True)
class _Family:
    label: tuple[str, str]
    knobs: tuple = ()
    ripple: Any = None
    starts: tuple = ((),)

    @property
    def axis(self) -> str:
        return self.label[1]


@dataclass(frozen=True)
class _Hypothesis:
    labels: tuple = ()
    floating: tuple = ()
    causes: tuple = field(default=())

    def plus(self, cause: Any) -> _Hypothesis:
        return _Hypothesis((*self.labels, cause.family.label))


def _state(residual: Floats, *labels: tuple[str, str]) -> Any:
    hypothesis: Any = _Hypothesis(labels)
    return SimpleNamespace(fit=Fit(hypothesis, residual, np.zeros((residual.size, 0)), 0.0), hypothesis=hypothesis)


def _asked(monkeypatch: pytest.MonkeyPatch, gap_elsewhere: float, tried: frozenset | None) -> tuple[list, list]:
    """What each family is screened against, and which of them are fitted in the place of a delay."""
    rng = np.random.default_rng(4)
    does, other = rng.standard_normal((2, 400))
    left = gap_elsewhere * np.column_stack([np.zeros(400), other])
    delay, without = _state(left, DELAY), _state(left + np.column_stack([does, np.zeros(400)]))
    screened: list[Floats] = []
    fitted: list[tuple[str, str]] = []

    def propose(fit: Fit, heard: Any, weighing: Any) -> list[Proposal]:
        screened.append(fit.residual)
        gains = {LAG: fit.residual[:, 0] @ does, CENTRE: fit.residual[:, 1] @ other}
        found = [Proposal(_Family(label), float(gain), ()) for label, gain in gains.items()]  # type: ignore[arg-type]
        return sorted(found, key=lambda p: -p.gain)

    def refined(inquiry: Any, before: Any, starts: list[Any], *_: Any) -> list[Fit]:
        fitted.extend(start.labels[-1] for start in starts)
        return []

    for name, stand_in in {
        "propose": propose,
        "_refined": refined,
        "weighing_of": lambda *_: None,
        "weighed_cost": lambda *_: 1.0,
        "listen": lambda *_: [],
        "_IN_PLACE": 1,
    }.items():
        monkeypatch.setattr(candidates, name, stand_in)
    inquiry: Any = SimpleNamespace(families=(_Family(LAG), _Family(CENTRE), _Family(DELAY)))
    candidates.candidates(inquiry, without, (), delay, tried)
    return screened, fitted


@pytest.mark.parametrize("gap_elsewhere", [0.0, 30.0])
def test_a_lag_is_asked_about_beside_a_delay_whatever_the_other_axis_lacks(
    monkeypatch: pytest.MonkeyPatch, gap_elsewhere: float
) -> None:
    screened, fitted = _asked(monkeypatch, gap_elsewhere, frozenset())
    assert fitted == [LAG]
    assert np.std(screened[0][:, 0]) > 0.5 and not screened[0][:, 1].any()


def test_what_was_tried_on_the_way_is_not_fitted_again(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _asked(monkeypatch, 30.0, frozenset({LAG}))[1] == []


def test_a_better_cause_is_looked_for_in_all_that_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _asked(monkeypatch, 30.0, None)[1] == [CENTRE]


def test_alternatives_are_those_of_the_way_and_those_that_do_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    start, delay, centre, lag = (
        SimpleNamespace(hypothesis=Hypothesis() if not labels else _Hypothesis(labels))
        for labels in ((), (DELAY,), (CENTRE,), (LAG,))
    )
    told: list[frozenset] = []

    def more(inquiry: Any, without: Any, heard: Any, state: Any, tried: frozenset) -> list[Any]:
        told.append(tried)
        return [lag]

    monkeypatch.setattr(search, "candidates", more)
    path: Any = Path(delay, (Round(start, (delay, centre), {}),), ())  # type: ignore[arg-type]
    assert search.in_its_place(SimpleNamespace(), path, start, delay, DELAY) == [centre, lag]  # type: ignore[arg-type]
    assert told == [frozenset({CENTRE})]
