"""A weight on an axis of which the model does not say how it lies, and on one that it has upright."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Request, diagnose, verdict_of
from sim_backend.model import model_from_document
from tests.discrepancy.test_logs_of_strangers import COULOMB, INERTIA, STEP, swing, table

#: weight times distance, N m
WEIGHT_NM = 0.3


def asked(states_mass: bool = True, **more: float) -> dict[str, Any]:
    """The verdict on two logs of a pendulum, with a model without its weight."""
    logs: list[SignalsTable] = []
    for speed in (1.0, 0.8):
        t, torque, position = swing(12.0, noise=0.003, speed=speed)
        logs.append(table({"pan.torque": torque + WEIGHT_NM * np.sin(position), "pan.position": position}, t))
    axis = {
        "body": ({"mass": 1.0} if states_mass else {}) | {"inertia": {"zz": INERTIA}},
        "friction": {"coulomb": COULOMB, "breakaway": COULOMB, "viscous": 0.001},
        "encoder": {"step": STEP},
    }
    document = {"schema": 1, "name": "arm", "kind": "rotary", "axes": {"pan": axis}} | more
    request = Request(model_from_document(document, "arm"), tuple(logs[:1]), tuple(logs[1:]))
    return verdict_of(diagnose(request)).document


def test_where_the_model_says_nothing_a_weight_is_told() -> None:
    found = asked()
    assert found["verdict"] == "named" and [e["name"] for e in found["effects"]] == ["static_unbalance"]
    assert found["effects"][0]["parameters"]["cog_y"]["value"] == pytest.approx(-WEIGHT_NM / 9.81, rel=0.02)


@pytest.mark.heavy
def test_a_weight_is_told_of_an_axis_whose_model_states_no_mass() -> None:
    found = asked(states_mass=False)
    assert found["verdict"] == "named" and [e["name"] for e in found["effects"]] == ["static_unbalance"]
    assert found["effects"][0]["parameters"]["cog_y"]["value"] == pytest.approx(-WEIGHT_NM / 9.81, rel=0.02)
    assert "states no mass of pan: 1 kg stands in for it" in found["text"]


@pytest.mark.heavy
def test_where_the_model_has_the_axis_upright_it_is_said_that_no_weight_was_tested() -> None:
    found = asked(incline_sine=0.0)
    assert "static_unbalance" not in [e["name"] for e in found["effects"]]
    assert "Static unbalance on pan was not tested: the model has the axis upright" in found["text"]
