"""What the round trip through MuJoCo makes of an answer: no name is excused by one that stands beside it."""

from __future__ import annotations

from typing import Any

import pytest

from tests.model_exports.round_trip import judged

_ASYMMETRY, _COULOMB, _BEND = ("outer", "coulomb_asymmetry"), ("outer", "coulomb"), ("inner", "structural_resonance")


def _answer(verdict: str, *told: tuple[tuple[str, str], str], rivals: tuple[tuple[str, str], ...] = ()) -> Any:
    effects = [{"axis": axis, "name": name, "status": status} for (axis, name), status in told]
    return {
        "verdict": verdict,
        "effects": effects,
        "alternatives": [{"axis": axis, "name": name} for axis, name in rivals],
    }


@pytest.mark.parametrize(
    ("answer", "left_out", "expected"),
    [
        (_answer("no_discrepancy"), set(), "nothing named"),
        (_answer("ambiguous", (_COULOMB, "ambiguous")), set(), "guessed though held"),
        (_answer("named", (_COULOMB, "named")), set(), "FALSE NAME"),
        (_answer("named", (_BEND, "named")), set(), "held nearly, told"),
        (_answer("named", (_ASYMMETRY, "named")), {_ASYMMETRY}, "left out, named"),
        (_answer("named", (_ASYMMETRY, "named"), (_COULOMB, "named")), {_ASYMMETRY}, "FALSE NAME"),
        (_answer("ambiguous", (_ASYMMETRY, "ambiguous"), (_COULOMB, "named")), {_ASYMMETRY}, "FALSE NAME"),
        (_answer("ambiguous", (_COULOMB, "ambiguous"), rivals=(_ASYMMETRY,)), {_ASYMMETRY}, "left out, in its class"),
        (_answer("ambiguous", (_COULOMB, "ambiguous")), {_ASYMMETRY}, "left out, another guessed"),
        (_answer("unexplained"), {_ASYMMETRY}, "left out, no name"),
        (_answer("no_discrepancy"), {_ASYMMETRY}, "FALSE ALL-CLEAR"),
    ],
)
def test_each_answer_has_its_worth(answer: Any, left_out: set[tuple[str, str]], expected: str) -> None:
    assert judged(answer, left_out, {_BEND}) == expected


def test_the_same_effect_of_another_axis_is_a_false_name() -> None:
    answer = _answer("named", (("inner", "coulomb_asymmetry"), "named"))
    assert judged(answer, {_ASYMMETRY}, set()) == "FALSE NAME"
