"""Structure effects: what a spring, a hung mass, a gap and a cable keep, and how fast they swing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim_backend.layout import EFFECT_STATES, RATE
from sim_backend.plant import Plant
from tests.effects.rigs import RATE_HZ, rotary, run, times, with_effect

J = 0.5


def test_cable_spring_swings_about_its_rest_position() -> None:
    motion = run(
        with_effect(rotary(J, start_position=0.3), "cable_spring", stiffness=2.0, rest_position=0.1), 0.0, 6000
    )
    np.testing.assert_allclose(motion.position[:, 0], 0.1 + 0.2 * np.cos(math.sqrt(2.0 / J) * times(motion)), atol=1e-6)


def test_cable_hysteresis_builds_up_exponentially_and_reverses() -> None:
    width, angle = 0.3, 0.05
    heavy = rotary(1e8, start_rate=0.2)
    motion = run(with_effect(heavy, "cable_spring", hysteresis=width, hysteresis_angle=angle), 0.0, 500)
    felt = -np.diff(motion.rate[:, 0]) * 1e8 * RATE_HZ
    turned = motion.position[:-1, 0] + 0.5 * np.diff(motion.position[:, 0])
    np.testing.assert_allclose(felt, width * (1.0 - np.exp(-turned / angle)), atol=width * 1e-3)


def test_cable_hysteresis_takes_energy_out_of_a_swing() -> None:
    free = run(with_effect(rotary(J, start_position=0.4), "cable_spring", stiffness=5.0), 0.0, 8000).position[:, 0]
    rubbed = run(
        with_effect(rotary(J, start_position=0.4), "cable_spring", stiffness=5.0, hysteresis=0.1), 0.0, 8000
    ).position[:, 0]
    assert np.abs(free[-2500:]).max() == pytest.approx(0.4, rel=1e-3)
    assert np.abs(rubbed[-2500:]).max() < 0.2


def test_a_hung_inertia_swings_against_the_driven_side_at_the_resonance() -> None:
    frequency, share = 20.0, 0.4
    motion = run(
        with_effect(
            rotary(J), "structural_resonance", antiresonance_frequency=frequency, damping_ratio=0.0, inertia_share=share
        ),
        _kick(),
    )
    rate = motion.rate[10:, 0]
    resonance = frequency / math.sqrt(1.0 - share)
    t = times(motion)[10:]
    # after the kick: mean rate of the whole inertia, and a swing of constant size at the resonance
    mean = 0.01 / J
    basis = np.column_stack([np.ones_like(t), np.cos(2 * np.pi * resonance * t), np.sin(2 * np.pi * resonance * t)])
    found, *_ = np.linalg.lstsq(basis, rate, rcond=None)
    assert found[0] == pytest.approx(mean, rel=1e-3)
    assert np.hypot(found[1], found[2]) == pytest.approx(mean * share / (1.0 - share), rel=0.02)
    assert np.abs(rate - basis @ found).max() < 2e-3 * mean


def _kick() -> np.ndarray:
    """An impulse of 0.01 N m s in one tick, then nothing."""
    torque = np.zeros(3000)
    torque[0] = 10.0
    return torque


def test_a_hung_inertia_keeps_the_momentum_of_the_whole() -> None:
    model = with_effect(
        rotary(J), "structural_resonance", antiresonance_frequency=15.0, damping_ratio=0.03, inertia_share=0.3
    )
    plant = Plant(model, RATE_HZ)
    torque = np.random.default_rng(4).uniform(-1.0, 1.0, (400, 1))
    plant.run(torque)
    twist_rate = plant.X[EFFECT_STATES + 1]
    assert J * plant.X[RATE] + 0.3 * J * twist_rate == pytest.approx(torque.sum() / RATE_HZ, rel=1e-9)


def test_a_hung_inertia_leaves_slow_motion_alone() -> None:
    slow = 0.05 * np.sin(2 * np.pi * 0.5 * np.arange(4000) / RATE_HZ)
    hung = run(
        with_effect(
            rotary(J), "structural_resonance", antiresonance_frequency=60.0, damping_ratio=0.05, inertia_share=0.5
        ),
        slow,
    )
    np.testing.assert_allclose(hung.rate, run(rotary(J), slow).rate, atol=5e-4 * 0.1)


def test_the_driven_side_stands_still_at_the_antiresonance() -> None:
    drive = np.sin(2 * np.pi * 10.0 * np.arange(20000) / RATE_HZ)
    model = with_effect(
        rotary(J), "structural_resonance", antiresonance_frequency=10.0, damping_ratio=0.02, inertia_share=0.4
    )
    stiff = np.ptp(run(rotary(J), drive).rate[-1000:, 0])
    assert np.ptp(run(model, drive).rate[-1000:, 0]) < 0.1 * stiff


def test_inside_the_gap_the_joint_feels_nothing_until_the_rotor_is_across() -> None:
    gap, rotor, torque = 0.01, 0.02, 0.2
    motion = run(with_effect(rotary(J), "backlash", gap=gap, rotor_inertia=rotor), torque, 400)
    across = math.sqrt(gap * rotor / torque)
    t = times(motion)
    assert np.all(motion.rate[t < across, 0] == 0.0)
    assert motion.rate[np.searchsorted(t, across + 3e-3), 0] > 0.0


@pytest.mark.parametrize("gap", [0.0, 0.002, 0.01])
def test_joint_and_rotor_together_keep_the_momentum_that_the_motor_gives(gap: float) -> None:
    rotor = 0.05
    plant = Plant(with_effect(rotary(J), "backlash", gap=gap, rotor_inertia=rotor), RATE_HZ)
    torque = np.repeat(np.random.default_rng(6).uniform(-1.0, 1.0, 30), 20)[:, None]
    plant.run(torque)
    lead_rate = plant.X[EFFECT_STATES + 1]
    assert (J + rotor) * plant.X[RATE] + rotor * lead_rate == pytest.approx(torque.sum() / RATE_HZ, rel=1e-9)


def test_contacts_never_make_energy() -> None:
    rotor = 0.05
    plant = Plant(with_effect(rotary(J, start_rate=1.0), "backlash", gap=0.01, rotor_inertia=rotor), RATE_HZ)
    # the rotor stands still while the joint turns
    plant.X[EFFECT_STATES + 1] = -1.0
    energy = []
    for _ in range(600):
        plant.run(np.zeros((1, 1)))
        rate, lead, lead_rate = plant.X[RATE], plant.X[EFFECT_STATES], plant.X[EFFECT_STATES + 1]
        pressed = max(0.0, abs(lead) - 0.005)
        stiffness = rotor * J / (rotor + J) * (2 * math.pi * 90.0) ** 2
        energy.append(0.5 * J * rate**2 + 0.5 * rotor * (rate + lead_rate) ** 2 + 0.5 * stiffness * pressed**2)
    assert np.diff(energy).max() < 1e-3 * energy[0]
    # in the end both turn together
    assert plant.X[RATE] == pytest.approx(J / (J + rotor), rel=0.02)


def test_a_rotor_that_the_model_counts_already_leaves_the_inertia_of_the_whole() -> None:
    model = with_effect(rotary(J), "backlash", gap=1e-6, rotor_inertia=0.2, counted_share=1.0)
    assert run(model, 0.3, 2000).rate[-1, 0] == pytest.approx(run(rotary(J), 0.3, 2000).rate[-1, 0], rel=1e-2)


def test_a_gap_without_rotor_inertia_passes_every_torque() -> None:
    torque = np.random.default_rng(8).uniform(-1.0, 1.0, 300)
    assert (
        run(with_effect(rotary(J), "backlash", gap=0.05), torque).rate.tobytes()
        == run(rotary(J), torque).rate.tobytes()
    )


def test_a_rotor_without_gap_adds_its_inertia() -> None:
    rotor = 0.25
    motion = run(with_effect(rotary(J), "backlash", rotor_inertia=rotor), 0.3, 1000)
    assert motion.rate[-1, 0] == pytest.approx(0.3 / (J + rotor), rel=1e-2)
