"""What an improvement says of its end, and whether its page is green."""

from __future__ import annotations

import pytest

from gimbal_hil.knowledge.discrepancy import Kind
from gimbal_hil.knowledge.improvement.journal import Diagnosed, Ended
from gimbal_hil.knowledge.improvement.page import _conclusion
from gimbal_hil.knowledge.improvement.task import Ending, ending_text


def diagnosed(verdict: Kind, text: str) -> Diagnosed:
    gap = {"axis": "joint", "signal": "torque", "before": 0.9, "after": 0.9, "noise_floor": 1.0}
    return Diagnosed(1, verdict.value, "An answer.", [gap], [], [], "at the floor", None, [], "", None, 1.0, text)


@pytest.mark.parametrize(("verdict", "tone"), [(Kind.NO_DISCREPANCY, "good"), (Kind.CANNOT_JUDGE, "warning")])
def test_a_model_at_the_floor_of_logs_that_cannot_judge_it_is_not_green(verdict: Kind, tone: str) -> None:
    rounds = [diagnosed(verdict, "Half or twice the right inertia would not have shown.")]
    text, more = ending_text(Ending.AT_THE_FLOOR, rounds, "")
    assert "0.90 floors" in text and ("would not have shown" in more) is (verdict is Kind.CANNOT_JUDGE)
    shown = _conclusion(Ended("at_the_floor", text, 10.0, 1, more), rounds)
    assert (shown.text, shown.tone, shown.more) == (text, tone, more)
