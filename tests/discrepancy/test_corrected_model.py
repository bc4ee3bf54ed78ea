"""Numbers of a corrected model: bristles hold break-away at or above Coulomb, a map without them takes what was
found.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from gimbal_hil.discrepancy import Result, recalibrated_model
from gimbal_hil.discrepancy.hypotheses.hypothesis import Hypothesis, KnownNumber
from gimbal_hil.discrepancy.verdict.corrected import with_numbers
from sim_backend.model import AntennaModel, model_from_document, shipped_model

TS, TC = ("arm", "friction.breakaway"), ("arm", "friction.coulomb")


def arm(breakaway: float = 2.0) -> AntennaModel:
    friction = {"coulomb": 2.0, "breakaway": breakaway, "stribeck_velocity": 0.1, "viscous": 1.0}
    axis = {"body": {"inertia": {"zz": 0.5}}, "friction": friction}
    return model_from_document({"schema": 1, "name": "arm", "kind": "rotary", "axes": {"arm": axis}}, "arm")


def test_a_dip_towards_standstill_stays_in_a_map_without_bristles() -> None:
    found = with_numbers(arm(), {TS: 1.2, TC: 2.1})
    assert (found.number(*TS), found.number(*TC)) == (1.2, 2.1)


def test_with_bristles_break_away_is_at_least_coulomb() -> None:
    model = shipped_model()
    ts, tc = ("outer", "friction.breakaway"), ("outer", "friction.coulomb")
    found = with_numbers(model, {tc: 2.0 * model.number(*tc)})
    assert found.number(*ts) == found.number(*tc) == pytest.approx(2.0 * model.number(*tc))


@pytest.mark.parametrize("y", [-0.2, 0.2])
def test_coulomb_friction_that_was_off_does_not_become_a_bump_or_a_dip(y: float) -> None:
    hypothesis = Hypothesis(floating=(KnownNumber("arm", "friction.coulomb", 0.1),), y=(y,))
    result = cast(Result, SimpleNamespace(model=arm(), best=SimpleNamespace(hypothesis=hypothesis)))
    moved = recalibrated_model(result)
    assert moved.number(*TC) != 2.0
    assert moved.number(*TS) == moved.number(*TC)
