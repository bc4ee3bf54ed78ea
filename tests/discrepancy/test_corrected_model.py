"""Numbers of a corrected model: bristles hold break-away at or above Coulomb, a map without them takes what was
found.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from gimbal_hil.knowledge.discrepancy import Result, recalibrated_model
from gimbal_hil.knowledge.discrepancy.hypotheses.hypothesis import Hypothesis, KnownNumber, parameters_of
from gimbal_hil.knowledge.discrepancy.twin.number_slots import read_number
from gimbal_hil.knowledge.discrepancy.verdict.corrected import with_numbers
from sim_backend.model import AntennaModel, model_from_document, shipped_model
from tests.discrepancy.test_hypothesis_bounds import twin_of

TS, TC = ("arm", "friction.breakaway"), ("arm", "friction.coulomb")


def arm(breakaway: float = 2.0) -> AntennaModel:
    friction = {"coulomb": 2.0, "breakaway": breakaway, "stribeck_velocity": 0.1, "viscous": 1.0}
    axis = {"body": {"inertia": {"zz": 0.5}}, "friction": friction}
    return model_from_document({"schema": 1, "name": "arm", "kind": "rotary", "axes": {"arm": axis}}, "arm")


def result_of(model: AntennaModel, hypothesis: Hypothesis) -> Result:
    twin = twin_of(model)
    best = SimpleNamespace(hypothesis=hypothesis)
    return cast(Result, SimpleNamespace(model=model, best=best, under=SimpleNamespace(twin=twin)))


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
    moved = recalibrated_model(result_of(arm(), hypothesis))
    assert moved.number(*TC) != 2.0
    assert moved.number(*TS) == moved.number(*TC)


def test_a_product_of_inertia_that_a_fit_led_far_away_is_written_as_the_twin_held_it() -> None:
    model = shipped_model()
    path = "body.inertia.yz"
    far = KnownNumber("outer", path, 1.0, model.number("outer", "body.inertia.zz"))
    hypothesis = Hypothesis(floating=(far,), y=(3.0,))
    result = result_of(model, hypothesis)
    held = read_number(model, parameters_of(result.under.twin, hypothesis)[1], "outer", path)
    assert recalibrated_model(result).number("outer", path) == held < far.moved(model.number("outer", path), 3.0)
