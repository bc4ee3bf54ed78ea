"""A neutral effect changes no bit of the plant, alone, twice, or among others."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel
from sim_backend.plant import Simulation
from tests.effects.rigs import antenna, columns, run

HOOKED = sorted(name for name, effect in CATALOGUE.items() if not effect.is_number)
NUMBERS = sorted(name for name, effect in CATALOGUE.items() if effect.is_number)
#: parameters that shape an effect but do not put it there: any value is neutral while the others are
SHAPES = {"order", "phase", "rest_position", "hysteresis_angle", "antiresonance_frequency", "damping_ratio"}
SHAPES |= {"gap", "counted_share", "contact_frequency", "contact_damping"}
AXES = ("outer", "inner")
BASES: tuple[dict[str, Any], ...] = (
    {},
    {"motion": "constant_rate", "rate_rad_s": {"p": 0.3, "q": -0.2, "r": 0.5}},
    {"motion": "sinusoid", "amplitude_rad": {"roll": 0.1, "pitch": 0.05}, "frequency_hz": {"roll": 0.7, "pitch": 1.3}},
)


def bits(motion: Simulation) -> bytes:
    return b"".join(column.tobytes() for column in columns(motion).values())


def started(model: AntennaModel, state: list[float]) -> AntennaModel:
    for axis, position, rate in zip(AXES, state[:2], state[2:4], strict=True):
        model = model.with_number(axis, "start.position", position).with_number(axis, "start.rate", rate)
    return model


@st.composite
def neutral_entries(draw: st.DrawFn) -> list[tuple[str, str, dict[str, float]]]:
    entries = []
    for name in draw(st.lists(st.sampled_from(HOOKED), min_size=1, max_size=6)):
        parameters = {
            p.name: draw(st.floats(p.low, p.high)) if p.name in SHAPES else p.neutral
            for p in CATALOGUE[name].parameters
        }
        entries.append((name, draw(st.sampled_from(AXES)), parameters))
    return entries


@pytest.mark.heavy
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    neutral_entries(),
    st.lists(st.floats(-2.0, 2.0), min_size=4, max_size=4),
    st.sampled_from(BASES),
    st.floats(0.0, 20.0),
    st.integers(0, 2**32 - 1),
)
def test_neutral_effects_in_any_combination_change_no_bit_from_any_state(
    entries: list[tuple[str, str, dict[str, float]]],
    state: list[float],
    base: dict[str, Any],
    torque_nm: float,
    seed: int,
) -> None:
    model = started(antenna(**base), state)
    torque = torque_nm * np.random.default_rng(seed).uniform(-1.0, 1.0, (60, 2))
    burdened = model
    for name, axis, parameters in entries:
        burdened = burdened.with_effect(name, axis, parameters)
    assert bits(run(burdened, torque)) == bits(run(model, torque))


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("axis", AXES)
def test_a_number_effect_that_repeats_the_models_number_changes_no_bit(name: str, axis: str) -> None:
    model = antenna(**BASES[1])
    own = {p.name: model.number(axis, model.number_path(axis, p.path or "")) for p in CATALOGUE[name].parameters}
    torque = np.random.default_rng(3).uniform(-5.0, 5.0, (200, 2))
    assert bits(run(model.with_effect(name, axis, own), torque)) == bits(run(model, torque))


@pytest.mark.parametrize("name", HOOKED)
def test_an_effect_that_is_there_changes_the_motion_or_its_readings(name: str) -> None:
    strong = {
        "gyro_misalignment": {"leak_x": 0.1, "leak_y": 0.1, "leak_z": 0.1},
        "cable_spring": {"stiffness": 0.5},
        "transport_delay": {"delay": 0.0025},
        "structural_resonance": {"inertia_share": 0.3},
        "backlash": {"gap": 1e-3, "rotor_inertia": 0.05},
        "cogging": {"amplitude": 0.1, "order": 6.0},
        "position_dependent_friction": {"relative_amplitude": 0.3, "order": 5.0},
        "encoder_eccentricity": {"amplitude": 1e-3, "phase": 0.3},
    }
    first = CATALOGUE[name].parameters[0]
    parameters = strong.get(name, {first.name: 0.2})
    model = antenna(**BASES[1]).with_number("outer", "thermal.ambient", 50.0)
    torque = 3.0 * np.random.default_rng(5).uniform(-1.0, 1.0, (300, 2))
    assert bits(run(model.with_effect(name, "outer", parameters), torque)) != bits(run(model, torque))
