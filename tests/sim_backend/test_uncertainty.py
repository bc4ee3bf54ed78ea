"""How well a model's numbers are known: stated, by source, and kept by everyone who writes a model."""

from __future__ import annotations

from typing import Any

import pytest
import yaml

from firmware_protocol.errors import BadInputError
from sim_backend.model import AntennaModel, model_from_document, shipped_model


def arm(viscous: Any = 2.0, more: dict[str, Any] | None = None, **top: Any) -> AntennaModel:
    axis = {
        "body": {"inertia": {"zz": 0.5}, "cog": {"x": 0.03, "y": 0.0, "z": 0.04}},
        "friction": {"viscous": viscous},
    } | (more or {})
    return model_from_document({"schema": 1, "name": "arm", "kind": "rotary", "axes": {"arm": axis}} | top, "arm.yaml")


@pytest.mark.parametrize(
    ("stated", "expected"),
    [
        ({"value": 2.0, "uncertainty": 0.3}, 0.3),
        ({"value": 2.0, "uncertainty": "10%"}, 0.2),
        ({"value": 2.0, "uncertainty": " 2.5e-1 % "}, 0.005),
        ({"value": 2.0, "uncertainty": 0}, 0.0),
        ({"value": 2.0, "source": "measured, June"}, 0.1),
        ({"value": 2.0, "source": "printed, table 4.1"}, 0.2),
        ({"value": 2.0, "source": "from CAD"}, 0.4),
        ({"value": 2.0, "source": "inferred from measured overshoots"}, 0.6),
        ({"value": 2.0, "source": "Assumed"}, 1.0),
        ({"value": 2.0, "source": "a cadence of words"}, 0.04),
        (2.0, 0.04),
    ],
)
def test_a_number_is_known_as_well_as_it_says_or_its_source_does(stated: Any, expected: float) -> None:
    assert arm(stated).uncertainty("arm", "friction.viscous") == pytest.approx(expected)


@pytest.mark.parametrize("wrong", [-0.1, "-3%", "ten", True, float("nan"), "0.1", [1]])
def test_an_uncertainty_that_is_none_is_refused_with_its_key(wrong: Any) -> None:
    with pytest.raises(BadInputError, match=r"axes\.arm\.friction\.viscous.*uncertainty"):
        arm({"value": 2.0, "uncertainty": wrong})


def test_one_uncertainty_may_stand_for_all_numbers_that_have_none_of_their_own() -> None:
    model = arm({"value": 2.0, "uncertainty": "10%"}, uncertainty="1%")
    assert model.uncertainty("arm", "friction.viscous") == pytest.approx(0.2)
    assert model.uncertainty("arm", "body.own_inertia") == pytest.approx(0.005)
    with pytest.raises(BadInputError, match=r"arm\.yaml: uncertainty"):
        arm(uncertainty="much")


def test_what_the_file_does_not_hold_is_not_uncertain_but_absent() -> None:
    assert arm(uncertainty="1%").uncertainty("arm", "actuator.offset") == 0.0


def test_a_centre_of_gravity_is_uncertain_as_a_whole() -> None:
    model = arm(uncertainty="10%")
    assert [model.uncertainty("arm", f"body.cog.{key}") for key in "xyz"] == pytest.approx([0.005] * 3)


def test_the_shipped_thesis_model_states_its_numbers_as_known_to_a_thousandth() -> None:
    model = shipped_model()
    assert model.uncertainty("outer", "friction.viscous") == pytest.approx(
        1e-3 * model.number("outer", "friction.viscous")
    )


def test_an_uncertainty_survives_writing_reading_and_a_changed_value() -> None:
    model = arm({"value": 2.0, "unit": "N m s/rad", "uncertainty": "10%"}).with_number("arm", "friction.viscous", 3.0)
    read = model_from_document(yaml.safe_load(model.to_yaml()), "again")
    assert read.uncertainty("arm", "friction.viscous") == pytest.approx(0.3)
    assert (
        read.with_number("arm", "friction.viscous", 3.0, "refit", 0.01).uncertainty("arm", "friction.viscous") == 0.01
    )


def test_an_effect_states_how_well_its_parameters_are_known() -> None:
    given = {"amplitude": 0.02, "order": 7.0, "phase": 0.1}
    model = arm().with_effect("cogging", "arm", given, "identified", {"amplitude": 0.001})
    read = model_from_document(yaml.safe_load(model.to_yaml()), "again")
    assert read.effects[0].uncertainty("amplitude") == 0.001
    assert read.effects[0].uncertainty("order") == pytest.approx(0.05 * 7.0)
    corrected = arm().with_effect("viscous", "arm", {"viscous": 3.0}, "identified", {"viscous": 0.02})
    assert corrected.uncertainty("arm", "friction.viscous") == 0.02


def test_a_torque_constant_makes_the_gain_as_uncertain_as_it_is() -> None:
    constant = {"value": 0.01, "unit": "N m/A", "uncertainty": "15%"}
    for more in ({"actuator": {"torque_constant": constant}}, {"torque_constant": constant}):
        model = arm(more=more)
        assert model.number("arm", "actuator.torque_constant") == 0.01
        assert model.uncertainty("arm", "actuator.gain_error") == pytest.approx(0.15)
        assert "torque_constant" in yaml.safe_load(model.to_yaml())["axes"]["arm"]["actuator"]
    with pytest.raises(BadInputError, match="torque_constant"):
        arm(more={"torque_constant": constant, "actuator": {"torque_constant": constant}})
