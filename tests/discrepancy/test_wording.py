"""What a verdict says in words."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from gimbal_hil.knowledge.discrepancy.judgement import Status
from gimbal_hil.knowledge.discrepancy.verdict import wording


def told(effect: str, axis: str, *rivals: tuple[str, str]) -> Any:
    standing = SimpleNamespace(label=(effect, axis), silent=False, at_bound=())
    close = tuple(SimpleNamespace(label=label) for label in rivals)
    return SimpleNamespace(standing=standing, status=Status.AMBIGUOUS, close=close, probability=0.5, denials=())


def test_an_effect_on_two_axes_has_the_alternatives_of_its_own_axis() -> None:
    both = (told("coulomb", "AZ", ("viscous", "AZ")), told("coulomb", "EL", ("stribeck", "EL")))
    result: Any = SimpleNamespace(suspected_only=False, told=both)
    first, second = (f"{line.strip()}." for line in wording._doubts(result).split(".")[:2])
    # names of axes stay as they are written
    assert first.startswith("Coulomb on AZ cannot be told from viscous on AZ on this data")
    assert second.startswith("Coulomb on EL cannot be told from stribeck on EL on this data")


def test_an_effect_that_was_asked_for_and_not_tested_is_told_with_the_reason() -> None:
    result: Any = SimpleNamespace(request=SimpleNamespace(only=("gyro_bias",)))
    unseen = [{"name": name, "axis": "EL", "reason": "the data has no rate column"} for name in ("gyro_bias", "slip")]
    assert wording.told_unseen(result, unseen) == " Gyro bias on EL was not tested: the data has no rate column."
