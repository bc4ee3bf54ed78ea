"""The page of an identification begins with one answer for all its axes."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gimbal_hil.knowledge.identification.estimate import Determination, Estimate, Interval
from gimbal_hil.knowledge.identification.pages import _answer, _tone


def axis(name: str, *halves: float, findings: tuple[str, ...] = ()) -> Any:
    """Viscous numbers of 1 with these half widths; an axis with none has nothing identified."""
    verdict = Determination.IDENTIFIED if halves else Determination.NOT_IDENTIFIED
    estimates = [
        Estimate("viscous", 1.0, Interval(1.0 - half, 1.0 + half), "N m s/rad", verdict, 1.0)
        for half in halves or (0.5,)
    ]
    return SimpleNamespace(axis=name, estimates=estimates, findings=findings)


def test_the_number_that_is_known_least_is_told_with_its_axis() -> None:
    both = [axis("outer", 0.001), axis("inner", 0.002, 0.006)]
    said = _answer(both).replace("\u00a0", " ")
    assert said == "Outer and inner: 3 of 3 numbers identified, the least sure, viscous friction of inner, to ± 0.6 %."
    assert _answer([axis("joint", 0.01)]).replace("\u00a0", " ").endswith("identified, viscous friction to ± 1 %.")
    assert _answer([axis("joint")]) == "No number of joint can be had from these logs: the model keeps its own."


@pytest.mark.parametrize(
    ("results", "tone"),
    [
        ([axis("joint", 0.01)], "good"),
        ([axis("joint", 0.01), axis("other")], "neutral"),
        ([axis("joint", 0.01, findings=("not passive",))], "warning"),
    ],
)
def test_what_speaks_against_a_log_colours_the_answer(results: list[Any], tone: str) -> None:
    assert _tone(results) == tone
