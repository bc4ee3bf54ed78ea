"""Numbers of which logs would not have shown that they are half or twice the right ones."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gimbal_hil.knowledge.discrepancy.hypotheses import KnownNumber
from gimbal_hil.knowledge.discrepancy.judgement import earned
from gimbal_hil.knowledge.discrepancy.judgement.smallest import Shows


@pytest.mark.parametrize(
    ("shows_from", "own", "is_hidden"),
    # a level that is assumed, which counts as known to a half, moves to where it belongs and is told
    [(0.65, 0.02, True), (0.45, 0.02, False), (0.65, 0.5, False), (1.2, 0.5, True)],
)
def test_what_is_told_to_show_from_more_than_a_half_on_would_not_have_shown_as_half(
    shows_from: float, own: float, is_hidden: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    family = SimpleNamespace(label=("coulomb", "joint"))
    known = KnownNumber("joint", "friction.coulomb", own)
    model = SimpleNamespace(axes=("joint",))
    inquiry: Any = SimpleNamespace(twin=SimpleNamespace(model=model), families=(family,))
    null: Any = SimpleNamespace(held=SimpleNamespace(floating=()))
    monkeypatch.setattr(earned, "weighing_of", lambda *_: None)
    monkeypatch.setattr(earned, "slopes_of_hold_out", lambda *_: ())
    monkeypatch.setattr(earned, "_is_stated", lambda *_: True)
    monkeypatch.setattr(earned, "without_own", lambda *_: (None, (known,)))
    monkeypatch.setattr(earned, "_within_reach", lambda *_: known.moved(0.05, known.reach) / 0.05)
    monkeypatch.setattr(earned, "_shows", lambda *_: True)
    one = Shows("coulomb", "joint", "torque of joint", "coulomb", 0.05 * shows_from, "N m", 0.05)
    found = earned.hidden_errors(inquiry, null, (one,), frozenset({"coulomb"}))
    assert found == ((("coulomb", "joint"),) if is_hidden else ())
