"""Numbers of which logs would not have shown that they are half or twice the right ones."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gimbal_hil.knowledge.discrepancy.judgement import earned
from gimbal_hil.knowledge.discrepancy.judgement.smallest import Shows


@pytest.mark.parametrize(("shows_from", "is_hidden"), [(0.65, True), (0.45, False)])
def test_what_is_told_to_show_from_more_than_a_half_on_would_not_have_shown_as_half(
    shows_from: float, is_hidden: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    family = SimpleNamespace(label=("coulomb", "joint"))
    inquiry: Any = SimpleNamespace(twin=SimpleNamespace(model=SimpleNamespace(axes=("joint",))), families=(family,))
    null: Any = SimpleNamespace(held=SimpleNamespace(floating=()))
    monkeypatch.setattr(earned, "weighing_of", lambda *_: None)
    monkeypatch.setattr(earned, "slopes_of_hold_out", lambda *_: ())
    monkeypatch.setattr(earned, "_is_stated", lambda *_: True)
    monkeypatch.setattr(earned, "_shows", lambda *_: True)
    one = Shows("coulomb", "joint", "torque of joint", "coulomb", 0.05 * shows_from, "N m", 0.05)
    found = earned.hidden_errors(inquiry, null, (one,), frozenset({"coulomb"}))
    assert found == ((("coulomb", "joint"),) if is_hidden else ())
