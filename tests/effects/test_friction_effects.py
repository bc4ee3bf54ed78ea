"""Friction effects against closed forms: coasting, and the friction that acts at a rate held by a huge inertia."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim_backend.model import AntennaModel
from tests.effects.rigs import rotary, run, times, with_effect

J = 0.5
HUGE = 1e8
TC, TS = 0.2, 0.25
DRY = {"coulomb": TC, "breakaway": TS, "stribeck_velocity": 0.01, "shape": 1.2, "viscous": 0.3}


def held(rate: float, **start: float) -> AntennaModel:
    """An axis too heavy to change its rate."""
    return rotary(HUGE, start_rate=rate, **start, **DRY)


def friction_at(model: AntennaModel, torque: float = 0.0) -> float:
    """Opposing torque of the first steps."""
    return float(run(model, torque, 3).friction[1, 0])


def steady(rate: float, ts: float = TS, tc: float = TC, viscous: float = DRY["viscous"]) -> float:
    bump = (ts - tc) * math.exp(-((abs(rate) / DRY["stribeck_velocity"]) ** DRY["shape"]))
    return math.copysign(tc + bump, rate) + viscous * rate


def test_viscous_friction_lets_the_rate_decay_exponentially() -> None:
    motion = run(with_effect(rotary(J, start_rate=3.0), "viscous", viscous=0.4), 0.0)
    np.testing.assert_allclose(motion.rate[:, 0], 3.0 * np.exp(-0.4 / J * times(motion)), rtol=2e-7)


def test_coulomb_friction_decelerates_evenly_and_moves_the_whole_curve() -> None:
    motion = run(with_effect(rotary(J, start_rate=2.0), "coulomb", coulomb=0.3, breakaway=0.3), 0.0)
    np.testing.assert_allclose(motion.rate[:, 0], 2.0 - 0.3 / J * times(motion), atol=1e-9)
    for rate in (0.002, 0.02, 1.0):
        moved = friction_at(with_effect(held(rate), "coulomb", coulomb=TC + 0.05, breakaway=TS + 0.05))
        assert moved - friction_at(held(rate)) == pytest.approx(0.05, abs=1e-9)


@pytest.mark.parametrize("rate", [-0.5, -0.02, -0.001, 0.001, 0.01, 0.1, 1.0])
def test_stribeck_friction_follows_its_curve(rate: float) -> None:
    changed = with_effect(held(rate), "stribeck", breakaway=0.4, stribeck_velocity=0.03, shape=2.0)
    bump = 0.2 * math.exp(-((abs(rate) / 0.03) ** 2.0))
    assert friction_at(held(rate)) == pytest.approx(steady(rate), rel=1e-9)
    assert friction_at(changed) == pytest.approx(math.copysign(TC + bump, rate) + 0.3 * rate, rel=1e-9)


def test_presliding_is_a_spring_with_the_given_stiffness_and_damping() -> None:
    sigma0, sigma1 = 300.0, 12.0
    model = with_effect(
        rotary(J, coulomb=TC, breakaway=TC, stribeck_velocity=0.01), "presliding", sigma0=sigma0, sigma1=sigma1
    )
    torque = 1e-4 * TC
    motion = run(model, torque, 3000)
    wn, zeta = math.sqrt(sigma0 / J), sigma1 / (2.0 * math.sqrt(sigma0 * J))
    t, wd = times(motion), wn * math.sqrt(1.0 - zeta**2)
    step = 1.0 - np.exp(-zeta * wn * t) * (np.cos(wd * t) + zeta * wn / wd * np.sin(wd * t))
    np.testing.assert_allclose(motion.position[:, 0], torque / sigma0 * step, atol=2e-3 * torque / sigma0)


@pytest.mark.parametrize("rate", [-0.3, 0.3])
def test_coulomb_asymmetry_scales_dry_friction_by_direction(rate: float) -> None:
    factor = 1.0 + math.copysign(0.2, rate)
    assert friction_at(with_effect(held(rate), "coulomb_asymmetry", asymmetry=0.2)) == pytest.approx(
        steady(rate, TS * factor, TC * factor), rel=1e-9
    )


@pytest.mark.parametrize("rate", [-0.3, 0.3])
def test_viscous_asymmetry_scales_viscosity_by_direction(rate: float) -> None:
    expected = steady(rate, viscous=0.3 * (1.0 + math.copysign(0.25, rate)))
    assert friction_at(with_effect(held(rate), "viscous_asymmetry", asymmetry=0.25)) == pytest.approx(
        expected, rel=1e-9
    )


@pytest.mark.parametrize("torque", [0.0, 2.0, -5.0])
def test_load_dependent_friction_grows_with_the_size_of_the_torque(torque: float) -> None:
    model = with_effect(held(0.5), "load_dependent_friction", coefficient=0.03)
    assert friction_at(model, torque) == pytest.approx(steady(0.5) + 0.03 * abs(torque), rel=1e-9)


def test_load_comes_on_top_of_what_direction_scales() -> None:
    model = with_effect(
        with_effect(held(0.5), "load_dependent_friction", coefficient=0.1), "coulomb_asymmetry", asymmetry=0.5
    )
    assert friction_at(model, 1.0) == pytest.approx(1.5 * TC + 0.1 + 0.3 * 0.5, rel=1e-9)


@pytest.mark.parametrize("position", [0.0, 0.4, 2.0])
def test_position_dependent_friction_follows_the_cosine(position: float) -> None:
    model = with_effect(
        held(0.5, start_position=position), "position_dependent_friction", relative_amplitude=0.3, order=4.0, phase=0.7
    )
    factor = 1.0 + 0.3 * math.cos(4.0 * position + 0.7)
    assert friction_at(model) == pytest.approx(TC * factor + 0.3 * 0.5, rel=2e-3)


@pytest.mark.parametrize("degc", [-40.0, 20.0, 85.0])
def test_viscosity_falls_exponentially_with_temperature(degc: float) -> None:
    model = with_effect(
        held(0.5).with_number("axis", "thermal.ambient", degc), "temperature_viscosity", temperature_coefficient=0.02
    )
    assert friction_at(model) == pytest.approx(steady(0.5, viscous=0.3 * math.exp(-0.02 * (degc - 20.0))), rel=1e-9)


def test_quadratic_drag_slows_hyperbolically() -> None:
    motion = run(with_effect(rotary(J, start_rate=4.0), "quadratic_drag", coefficient=0.2), 0.0)
    np.testing.assert_allclose(motion.rate[:, 0], 4.0 / (1.0 + 0.2 / J * 4.0 * times(motion)), rtol=2e-7)
    back = run(with_effect(rotary(J, start_rate=-4.0), "quadratic_drag", coefficient=0.2), 0.0)
    np.testing.assert_allclose(back.rate, -motion.rate, rtol=1e-12)
