"""Identified numbers in a model file."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest
import yaml

from gimbal_hil.knowledge.identification import AxisIdentification, Determination, Estimate, Interval, updated_model
from sim_backend.model import AntennaModel, model_from_document

OFFSET = 0.02


def arm(**friction: float) -> AntennaModel:
    numbers = {"coulomb": 2.0, "breakaway": 2.5, "stribeck_velocity": 0.1, "viscous": 1.0} | friction
    axis = {"body": {"inertia": {"zz": 0.5}}, "friction": numbers, "actuator": {"offset": OFFSET}}
    return model_from_document({"schema": 1, "name": "arm", "kind": "rotary", "axes": {"arm": axis}}, "arm")


def found(**values: float) -> AxisIdentification:
    estimates = tuple(
        Estimate(n, v, Interval(0.9 * v, 1.1 * v), "", Determination.IDENTIFIED, v) for n, v in values.items()
    )
    return cast(AxisIdentification, SimpleNamespace(axis="arm", estimates=estimates))


def test_a_break_away_below_coulomb_stays_where_there_are_no_bristles() -> None:
    model = updated_model(arm(), [found(breakaway=1.5, coulomb=2.2)])
    assert (model.number("arm", "friction.breakaway"), model.number("arm", "friction.coulomb")) == (1.5, 2.2)


@pytest.mark.parametrize("coulomb", [1.8, 2.2])
def test_coulomb_alone_makes_neither_a_bump_nor_a_dip(coulomb: float) -> None:
    model = updated_model(arm(breakaway=2.0), [found(coulomb=coulomb)])
    assert model.number("arm", "friction.breakaway") == model.number("arm", "friction.coulomb") == coulomb
    assert "not identified" in str(model.numbers["arm", "friction.breakaway"].source)


def test_a_break_away_that_was_not_identified_stays_where_it_stood_above_coulomb() -> None:
    model = updated_model(arm(breakaway=2.5), [found(coulomb=2.2)])
    assert (model.number("arm", "friction.breakaway"), model.number("arm", "friction.coulomb")) == (2.5, 2.2)


def test_with_bristles_it_is_put_at_coulomb_and_the_source_says_so() -> None:
    for model in (
        updated_model(arm(sigma0=1e4), [found(breakaway=1.5, coulomb=2.2)]),
        updated_model(arm(), [found(breakaway=1.5, sigma0=1e4)]),
    ):
        assert model.number("arm", "friction.breakaway") == model.number("arm", "friction.coulomb")
        assert "below it" in str(model.numbers["arm", "friction.breakaway"].source)


def test_an_identified_number_carries_its_interval_as_uncertainty() -> None:
    model = updated_model(arm(), [found(viscous=1.2)])
    assert model.uncertainty("arm", "friction.viscous") == pytest.approx(0.12)
    read_again = model_from_document(yaml.safe_load(model.to_yaml()), "arm")
    assert read_again.uncertainty("arm", "friction.viscous") == model.uncertainty("arm", "friction.viscous")


def test_an_offset_is_found_beside_the_one_that_the_model_has() -> None:
    model = updated_model(arm(), [found(offset=0.005)])
    assert model.number("arm", "actuator.offset") == pytest.approx(0.015)
    assert "0.0145 to 0.0155" in str(model.numbers["arm", "actuator.offset"].source)
