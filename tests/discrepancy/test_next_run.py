"""What is proposed for what nothing explains."""

from __future__ import annotations

import pytest

from gimbal_hil.knowledge.discrepancy.verdict.next_run import run_for
from gimbal_hil.knowledge.discrepancy.verdict.where import RegimeGroup
from sim_backend.effects import Variable


def test_every_variable_has_a_run_of_its_own() -> None:
    runs = [run_for("pan", variable, RegimeGroup.SPEED) for variable in Variable]
    assert len(set(runs)) == len(Variable) and all("of pan" in run for run in runs)


@pytest.mark.parametrize("group", RegimeGroup)
def test_every_regime_has_a_run_and_a_variable_counts_before_it(group: RegimeGroup) -> None:
    assert "of pan" in run_for("pan", None, group)
    assert run_for("pan", Variable.BASE_MOTION, group) == run_for("pan", Variable.BASE_MOTION, RegimeGroup.SPEED)


def test_what_grows_with_acceleration_is_not_asked_at_constant_speed() -> None:
    assert "constant" not in run_for("pan", None, RegimeGroup.EFFORT)
