"""Friction that grows with the torque that position takes: no Coulomb level holds it, and it is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gimbal_hil.knowledge.identification import Determination
from gimbal_hil.knowledge.identification.axis_motion import regression_rule
from gimbal_hil.knowledge.identification.rigid_axis import RigidAxisFit, fit_rigid_axis
from tests.cases.joint import BENCH, TRUE


def fitted(weight: float, under_load: float, is_known: bool, per_direction: bool = False) -> RigidAxisFit:
    """The regression of a joint under a weight, which its model has or lacks; the own simulator makes the log."""
    log = replace(BENCH, weight=weight, under_load=under_load).log()
    known = -weight * np.sin(log.position) if is_known else None
    rule = replace(regression_rule(1.0 / BENCH.rate_hz), per_direction=per_direction)
    return fit_rigid_axis(log.time, log.position, log.torque, rule, known=known)


@pytest.mark.parametrize("is_known", [True, False], ids=["in-the-model", "not-in-the-model"])
def test_numbers_are_those_without_a_load(is_known: bool) -> None:
    fit = fitted(0.3, 0.1, is_known)
    (told,) = [warning for warning in fit.warnings if warning.rule == "friction_under_load"]
    assert "by 0.1" in told.text or "by 0.09" in told.text
    for one in fit.estimates:
        if one.name != "offset":
            assert one.verdict is Determination.IDENTIFIED and one.interval.covers(TRUE[one.name]), one
    # as a mean over the log it would be 0.07
    assert fit.value("coulomb") == pytest.approx(TRUE["coulomb"], rel=0.02)
    assert not fit.timing.used


def test_a_load_that_changes_no_friction_is_not_told() -> None:
    assert not [one for one in fitted(0.3, 0.0, True).warnings if one.rule == "friction_under_load"]


def test_without_a_load_there_is_none_to_grow_with() -> None:
    fit = fitted(0.0, 0.0, False)
    assert not fit.warnings and fit.value("coulomb") == pytest.approx(TRUE["coulomb"], rel=0.02)


@pytest.mark.parametrize(("under_load", "told"), [(0.1, True), (0.015, False)])
def test_levels_of_each_direction_are_without_a_load_too(under_load: float, told: bool) -> None:
    fit = fitted(0.15, under_load, True, per_direction=True)
    for one in ("coulomb_positive", "coulomb_negative"):
        assert fit.value(one) == pytest.approx(TRUE["coulomb"], rel=0.02)
    # friction under load is told by what it is of the Coulomb levels, and of no other number
    assert bool([one for one in fit.warnings if one.rule == "friction_under_load"]) is told
