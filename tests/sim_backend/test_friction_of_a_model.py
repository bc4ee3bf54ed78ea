"""Which friction a model may state: with bristles there must be something to break away from, without them the map may
dip.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from sim_backend.model import model_from_document, shipped_model
from sim_backend.plant import Plant


def arm(**friction: float) -> dict[str, Any]:
    numbers = {"coulomb": 2.0, "breakaway": 2.5, "stribeck_velocity": 0.1, "shape": 1.0, "viscous": 0.0} | friction
    return {
        "schema": 1,
        "name": "arm",
        "kind": "rotary",
        "axes": {"arm": {"body": {"inertia": {"zz": 0.5}}, "friction": numbers}},
    }


def refused(document: dict[str, Any]) -> str:
    with pytest.raises(BadInputError) as refusal:
        model_from_document(document, "arm.yaml")
    return str(refusal.value)


def test_bristles_need_a_break_away_at_or_above_coulomb() -> None:
    said = refused(arm(breakaway=1.9, sigma0=1e4))
    assert said == (
        "arm.yaml: axes.arm.friction.breakaway: 1.9 is below coulomb 2; expected break-away at or above Coulomb where "
        "sigma0 is given"
    )
    assert model_from_document(arm(breakaway=2.0, sigma0=1e4), "arm.yaml").number("arm", "friction.breakaway") == 2.0


def test_bristles_need_coulomb_friction() -> None:
    assert "axes.arm.friction.coulomb: must be positive" in refused(arm(coulomb=0.0, sigma0=1e4))


def test_bristles_cannot_be_given_to_a_map_that_dips() -> None:
    with pytest.raises(BadInputError, match="1 is below coulomb 2"):
        model_from_document(arm(breakaway=1.0), "arm.yaml").with_number("arm", "friction.sigma0", 1e4)


def test_without_bristles_friction_falls_towards_standstill_as_the_numbers_say() -> None:
    model = model_from_document(arm(breakaway=1.0), "arm.yaml").with_number("arm", "body.inertia.zz", 1e6)
    for rate in (0.01, 0.3):
        motion = Plant(model.with_number("arm", "start.rate", rate)).run(np.zeros((10, 1)))
        assert motion.friction[-1, 0] == pytest.approx(2.0 - np.exp(-rate / 0.1), rel=1e-6)


@pytest.mark.parametrize(
    ("key", "value", "said"), [("breakaway", 0.2, "0.2 is below coulomb 0.275"), ("coulomb", 0.0, "must be positive")]
)
def test_every_row_of_a_table_over_temperature_is_held_to_the_same(key: str, value: float, said: str) -> None:
    document = copy.deepcopy(shipped_model("thesis-temperature").document)
    document["axes"]["outer"]["friction"]["over_temperature"][1][key] = value
    assert f"axes.outer.friction.over_temperature.1.{key}: {said}" in refused(document)


@pytest.mark.parametrize("bristle", [{}, {"sigma0": 1e4}])
def test_a_file_without_a_break_away_means_friction_of_one_level(bristle: dict[str, float]) -> None:
    document = arm(**bristle)
    del document["axes"]["arm"]["friction"]["breakaway"]
    model = model_from_document(document, "arm.yaml")
    assert model.number("arm", "friction.breakaway") == 2.0
    assert model.with_number("arm", "friction.coulomb", 1.5).number("arm", "friction.breakaway") == 1.5


def test_without_bristles_and_break_away_slow_joints_have_the_friction_of_fast_ones() -> None:
    document = arm()
    del document["axes"]["arm"]["friction"]["breakaway"]
    model = model_from_document(document, "arm.yaml").with_number("arm", "body.inertia.zz", 1e6)
    for rate in (0.01, 0.3):
        motion = Plant(model.with_number("arm", "start.rate", rate)).run(np.zeros((10, 1)))
        assert motion.friction[-1, 0] == pytest.approx(2.0, rel=1e-6)
