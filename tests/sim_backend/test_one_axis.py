"""A model with one axis: rotary or linear, the same friction, actuator, sensors and effects; and a published rig."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from sim_backend.layout import POSITION
from sim_backend.model import (
    AntennaModel,
    has_weight,
    mass_stands_in,
    model_from_document,
    position_has_a_zero,
    shipped_model,
    stands_upright,
    with_weight_left_open,
)
from sim_backend.plant import Plant

FRICTION = {"coulomb": 2.0, "breakaway": 2.5, "stribeck_velocity": 0.01, "viscous": 3.0, "sigma0": 1e4, "sigma1": 100.0}
DATA = (
    Path(os.environ.get("GIMBAL_HIL_DATA", Path(__file__).resolve().parents[3] / "shared" / "data"))
    / "emps"
    / "DATA_EMPS.mat"
)


def axis_of(kind: str, body: dict[str, float], **more: float) -> AntennaModel:
    axis = {"body": body, "friction": FRICTION, "actuator": {"offset": 0.1}}
    return model_from_document({"schema": 1, "name": "rig", "kind": kind, "axes": {"slide": axis}, **more}, "rig")


def test_a_linear_axis_moves_like_a_rotary_one_of_the_same_numbers() -> None:
    torque = 5.0 * np.sin(np.arange(2000) * 0.01)[:, None]
    effects = [
        ("cogging", {"amplitude": 0.3, "order": 40.0}),
        ("transport_delay", {"delay": 0.003}),
        ("back_emf", {"coefficient": 0.2}),
    ]
    linear, rotary = axis_of("linear", {"mass": 4.0}), axis_of("rotary", {"inertia": {"zz": 4.0}})  # type: ignore[dict-item]
    for name, parameters in effects:
        linear, rotary = linear.with_effect(name, "slide", parameters), rotary.with_effect(name, "slide", parameters)
    np.testing.assert_array_equal(Plant(linear).run(torque).position, Plant(rotary).run(torque).position)


def test_units_of_a_linear_axis_are_those_of_forces_and_metres() -> None:
    model = axis_of("linear", {"mass": 4.0}).with_effect("cogging", "slide", {"amplitude": 0.3, "order": 40.0})
    assert model.document["effects"][0]["amplitude"]["unit"] == "N"
    assert model.numbers["slide", "friction.sigma0"].unit in (None, "N/m")
    with pytest.raises(BadInputError, match=r"axes\.slide\.body\.mass: unit 'g'; expected kg"):
        axis_of("linear", {"mass": {"value": 4.0, "unit": "g"}})  # type: ignore[dict-item]


def test_a_slope_pulls_a_linear_axis_down() -> None:
    steep = axis_of("linear", {"mass": 4.0}, incline_sine=0.5)
    motion = Plant(steep).run(np.zeros((500, 1)))
    # 19.62 N against 2 N of friction, 0.1 N of offset and viscous drag
    speed, t = motion.rate[-1, 0], 0.499
    drive = 4.0 * 9.81 * 0.5 - 2.0 - 0.1
    assert -speed == pytest.approx(drive / 3.0 * (1.0 - np.exp(-3.0 / 4.0 * t)), rel=0.02)


def test_an_axis_of_which_nobody_says_how_it_lies_may_have_a_weight_and_moves_as_before() -> None:
    unsaid = axis_of("rotary", {"inertia": {"zz": 4.0}, "mass": 3.0})  # type: ignore[dict-item]
    open_ = with_weight_left_open(unsaid)
    torque = 5.0 * np.sin(np.arange(500) * 0.01)[:, None]
    np.testing.assert_array_equal(Plant(open_).run(torque).position, Plant(unsaid).run(torque).position)
    assert stands_upright(unsaid) and not stands_upright(open_)
    loaded = open_.with_effect("static_unbalance", "slide", {"cog_x": 0.1, "cog_y": 0.0, "cog_z": 0.0})
    assert has_weight(loaded, "slide") and not has_weight(open_, "slide")
    # a file that says it, or has a weight already, is taken at its word
    said = axis_of("rotary", {"inertia": {"zz": 4.0}, "mass": 3.0}, incline_sine=0.0)  # type: ignore[dict-item]
    off = unsaid.with_numbers("slide", {"body.cog.x": 0.1})
    assert with_weight_left_open(said) is said and with_weight_left_open(off) is off


def test_a_kilogram_stands_in_for_a_mass_that_nobody_states() -> None:
    unsaid = axis_of("rotary", {"inertia": {"zz": 4.0}})  # type: ignore[dict-item]
    open_ = with_weight_left_open(unsaid)
    torque = 5.0 * np.sin(np.arange(500) * 0.01)[:, None]
    np.testing.assert_array_equal(Plant(open_).run(torque).position, Plant(unsaid).run(torque).position)
    assert open_.number("slide", "body.mass") == 1.0 and mass_stands_in(open_, "slide")
    assert open_.uncertainty("slide", "body.mass") == 0.0
    # a mass that is stated stands, also none, and an axis that is said to be upright has no weight
    none = axis_of("rotary", {"inertia": {"zz": 4.0}, "mass": 0.0}, incline_sine=1.0)  # type: ignore[dict-item]
    upright = axis_of("rotary", {"inertia": {"zz": 4.0}}, incline_sine=0.0)  # type: ignore[dict-item]
    assert with_weight_left_open(none) is none and with_weight_left_open(upright) is upright
    beside = axis_of("rotary", {"inertia": {"zz": 4.0}, "cog": {"x": 0.1}}, incline_sine=1.0)  # type: ignore[dict-item]
    assert with_weight_left_open(beside) is beside
    assert with_weight_left_open(axis_of("linear", {"mass": 4.0})).number("slide", "body.mass") == 4.0


def test_position_has_a_zero_where_a_weight_or_an_effect_says_so() -> None:
    level = axis_of("rotary", {"inertia": {"zz": 4.0}, "mass": 3.0}, incline_sine=1.0)  # type: ignore[dict-item]
    assert not position_has_a_zero(level, "slide")
    assert position_has_a_zero(level.with_numbers("slide", {"body.cog.y": 0.1}), "slide")
    assert position_has_a_zero(level.with_effect("cable_spring", "slide", {"stiffness": 1.0}), "slide")
    # a slope pulls a carriage alike everywhere
    assert not position_has_a_zero(axis_of("linear", {"mass": 4.0}, incline_sine=0.5), "slide")


@pytest.mark.parametrize("name", ["dynamic_unbalance", "gyro_misalignment"])
def test_an_effect_of_two_axes_is_refused_on_one(name: str) -> None:
    document = axis_of("linear", {"mass": 4.0}).document | {"effects": [{"name": name, "axis": "slide"}]}
    with pytest.raises(BadInputError, match=f"{name} cannot be on a linear axis"):
        model_from_document(document, "rig")


@pytest.mark.skipif(not DATA.exists(), reason="the EMPS data are not there (set GIMBAL_HIL_DATA to their folder)")
def test_the_published_rig_in_its_own_loop_moves_as_measured() -> None:
    from scipy.io import loadmat

    data = {key: value.ravel() for key, value in loadmat(DATA).items() if not key.startswith("__")}
    measured, wanted, volts = data["qm"], data["qg"], data["vir"]
    gain, kp, kv, step = float(data["gtau"][0]), float(data["kp"][0]), float(data["kv"][0]), 1e-3
    plant = Plant(shipped_model("emps").with_number("carriage", "start.position", float(measured[0])))
    position, force = np.zeros(len(wanted)), np.zeros(len(wanted))
    last = filtered = measured[0]
    for k in range(len(wanted)):
        position[k] = round(plant.X[POSITION] / 5e-8) * 5e-8
        mean = 0.5 * (position[k] + last)
        rate, last, filtered = (mean - filtered) / step, position[k], mean
        force[k] = gain * min(max(kv * (kp * (wanted[k] - position[k]) - rate), -10.0), 10.0)
        plant.run(force[k : k + 1, None])
    # published for the same simulation: position 0.0138 %, force 5.85 %
    assert np.linalg.norm(position - measured) / np.linalg.norm(measured) < 1.4e-4
    assert np.linalg.norm(force - gain * volts) / np.linalg.norm(gain * volts) < 0.0585
