"""Effects combine: two of the same kind add up, all at once run, and an absent effect costs no state."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from sim_backend.effects import CATALOGUE
from sim_backend.layout import EFFECT_STATES, MAX_INSTANCES
from sim_backend.model import plant_arrays
from tests.effects.rigs import antenna, rotary, run, with_effect

TORQUE = np.repeat(np.random.default_rng(11).uniform(-1.0, 1.0, 50), 10)


@pytest.mark.parametrize(
    ("name", "half", "whole"),
    [
        ("cogging", {"amplitude": 0.05, "order": 7.0, "phase": 0.4}, {"amplitude": 0.1, "order": 7.0, "phase": 0.4}),
        ("cable_spring", {"stiffness": 0.3, "rest_position": 0.1}, {"stiffness": 0.6, "rest_position": 0.1}),
        ("quadratic_drag", {"coefficient": 0.1}, {"coefficient": 0.2}),
        ("back_emf", {"coefficient": 0.1}, {"coefficient": 0.2}),
        ("transport_delay", {"delay": 0.0015}, {"delay": 0.003}),
        ("encoder_eccentricity", {"amplitude": 1e-3}, {"amplitude": 2e-3}),
    ],
)
def test_two_halves_of_an_effect_make_the_whole(name: str, half: dict[str, float], whole: dict[str, float]) -> None:
    twice = run(rotary().with_effect(name, "axis", half).with_effect(name, "axis", half), TORQUE)
    once = run(rotary().with_effect(name, "axis", whole), TORQUE)
    np.testing.assert_allclose(twice.rate, once.rate, atol=1e-12)
    np.testing.assert_allclose(twice.encoder, once.encoder, atol=1e-12)


def test_every_hook_effect_at_once_runs_and_stays_finite() -> None:
    model = antenna()
    chosen = {
        "gyro_misalignment": {"leak_x": 0.02},
        "cable_spring": {"stiffness": 0.2, "hysteresis": 0.05},
        "transport_delay": {"delay": 0.0013},
        "structural_resonance": {"antiresonance_frequency": 25.0, "inertia_share": 0.2},
        "backlash": {"gap": 1e-3, "rotor_inertia": 0.02},
        "cogging": {"amplitude": 0.05, "order": 12.0},
        "position_dependent_friction": {"relative_amplitude": 0.2, "order": 3.0},
        "encoder_eccentricity": {"amplitude": 1e-3},
    }
    for name, effect in CATALOGUE.items():
        if not effect.is_number:
            model = model.with_effect(name, "inner", chosen.get(name, {effect.parameters[0].name: 0.02}))
    motion = run(model, np.column_stack([np.zeros(3000), 1.0 + np.sin(np.arange(3000) * 0.02)]))
    assert np.isfinite(motion.gyro).all() and np.ptp(motion.rate[:, 1]) > 0.1


def test_an_absent_effect_takes_no_state() -> None:
    assert len(plant_arrays(rotary()).X) == EFFECT_STATES


def test_more_effects_than_the_plant_holds_are_refused_with_the_most() -> None:
    model = rotary()
    for i in range(MAX_INSTANCES + 1):
        model = with_effect(model, "cogging", amplitude=0.01, order=float(i + 1))
    with pytest.raises(BadInputError, match=f"at most {MAX_INSTANCES}"):
        plant_arrays(model)
