"""The catalogue holds what the contract names, and each entry says what a user needs."""

from __future__ import annotations

import math

import pytest

from firmware_protocol.errors import BadInputError
from sim_backend.effects import CATALOGUE, Effect, effect_named
from sim_backend.layout import PARAMETERS_PER_INSTANCE
from sim_backend.model.numbers import NUMBER_AT

CONTRACT = {
    "viscous": ["viscous"],
    "coulomb": ["coulomb", "breakaway"],
    "stribeck": ["breakaway", "stribeck_velocity", "shape"],
    "presliding": ["sigma0", "sigma1"],
    "coulomb_asymmetry": ["asymmetry"],
    "viscous_asymmetry": ["asymmetry"],
    "load_dependent_friction": ["coefficient"],
    "position_dependent_friction": ["relative_amplitude", "order", "phase"],
    "quadratic_drag": ["coefficient"],
    "temperature_viscosity": ["temperature_coefficient"],
    "static_unbalance": ["cog_x", "cog_y", "cog_z"],
    "dynamic_unbalance": ["ixy", "ixz", "iyz"],
    "inertia": ["inertia"],
    "cogging": ["amplitude", "order", "phase"],
    "cable_spring": ["stiffness", "rest_position"],
    "structural_resonance": ["antiresonance_frequency", "damping_ratio", "inertia_share"],
    "backlash": ["gap", "rotor_inertia"],
    "torque_gain": ["gain_error"],
    "torque_offset": ["offset"],
    "actuator_lag": ["time_constant"],
    "transport_delay": ["delay"],
    "saturation": ["limit"],
    "back_emf": ["coefficient"],
    "gyro_bias": ["bias"],
    "gyro_scale": ["scale_error"],
    "gyro_misalignment": ["leak_x", "leak_y", "leak_z"],
    "encoder_eccentricity": ["amplitude", "phase"],
}
every_effect = pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda effect: effect.name)


def test_the_catalogue_holds_every_effect_of_the_contract_with_its_parameter_names() -> None:
    for name, parameters in CONTRACT.items():
        assert [p.name for p in CATALOGUE[name].parameters][: len(parameters)] == parameters


@every_effect
def test_an_effect_says_what_it_is_where_it_comes_from_and_what_excites_it(effect: Effect) -> None:
    assert effect.text and effect.equation and effect.source and effect.excited_by
    assert 1 <= len(effect.parameters) <= PARAMETERS_PER_INSTANCE


@every_effect
def test_every_parameter_has_a_unit_finite_bounds_and_a_usable_neutral_value(effect: Effect) -> None:
    for parameter in effect.parameters:
        assert parameter.unit and parameter.text
        assert math.isfinite(parameter.low) and math.isfinite(parameter.high) and parameter.low < parameter.high
        assert parameter.check(parameter.neutral)
        assert not parameter.check(math.nan) and not parameter.check(2.0 * parameter.high + 1.0)


@every_effect
def test_a_number_effect_names_numbers_of_the_model_in_their_own_units(effect: Effect) -> None:
    for parameter in effect.parameters:
        if not effect.is_number:
            assert parameter.path is None
        elif parameter.path == "body.own_inertia":
            assert (parameter.unit, parameter.linear_unit) == ("kg m2", "kg")
        else:
            assert parameter.path is not None
            number = NUMBER_AT[parameter.path]
            assert parameter.unit == number.unit
            assert (
                (parameter.linear_unit or parameter.unit) == number.linear_unit
                or effect.rotary_only
                or effect.two_axis_only
            )
            assert number.low <= parameter.low and parameter.high <= number.high


def test_an_unknown_effect_is_refused_with_the_names_that_exist() -> None:
    with pytest.raises(BadInputError, match=r"no effect 'coging'.*cogging"):
        effect_named("coging")
