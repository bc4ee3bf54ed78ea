"""Drive and timing effects against closed forms on one frictionless axis of 0.5 kg m2."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.effects.rigs import STEP_S, rotary, run, times, with_effect

J = 0.5


def test_torque_gain_scales_the_acceleration() -> None:
    motion = run(with_effect(rotary(J), "torque_gain", gain_error=0.1), 0.2)
    np.testing.assert_allclose(motion.rate[:, 0], 1.1 * 0.2 / J * times(motion), atol=1e-12)


def test_torque_offset_accelerates_at_zero_command() -> None:
    motion = run(with_effect(rotary(J), "torque_offset", offset=-0.3), 0.0)
    np.testing.assert_allclose(motion.rate[:, 0], -0.3 / J * times(motion), atol=1e-12)


def test_saturation_holds_the_torque_at_the_limit_in_both_directions() -> None:
    model = with_effect(rotary(J), "saturation", limit=1.0)
    for command in (5.0, -5.0):
        motion = run(model, command)
        np.testing.assert_allclose(motion.applied[1:, 0], math.copysign(1.0, command))
        np.testing.assert_allclose(motion.rate[:, 0], math.copysign(1.0, command) / J * times(motion), atol=1e-12)


def test_actuator_lag_is_first_order() -> None:
    tau = 0.02
    motion = run(with_effect(rotary(J), "actuator_lag", time_constant=tau), 0.4, 200)
    t = times(motion)
    np.testing.assert_allclose(motion.rate[:, 0], 0.4 / J * (t - tau * (1.0 - np.exp(-t / tau))), atol=1e-12)


@pytest.mark.parametrize("delay", [0.001, 0.0025, 0.01234, 0.00005, 0.05])
def test_transport_delay_shifts_the_motion_by_any_fraction_of_a_step(delay: float) -> None:
    motion = run(with_effect(rotary(J), "transport_delay", delay=delay), 0.4, 200)
    t = times(motion)
    # exact at ticks that the step boundary has passed; inside the step that holds the edge only its mean is
    clear = np.abs(t - delay) > STEP_S
    expected = 0.4 / J * np.maximum(0.0, t - delay)
    np.testing.assert_allclose(motion.rate[clear, 0], expected[clear], atol=1e-12)


def test_transport_delay_passes_the_same_impulse_later() -> None:
    pulse = np.zeros(300)
    pulse[10:13] = 1.0
    motion = run(with_effect(rotary(J), "transport_delay", delay=0.02037), pulse)
    assert np.all(motion.rate[:30, 0] == 0.0)
    assert motion.rate[-1, 0] == pytest.approx(3e-3 / J, rel=1e-12)


def test_back_emf_alone_cannot_be_told_from_viscous_friction() -> None:
    fading = run(with_effect(rotary(J, start_rate=2.0), "back_emf", coefficient=0.7), 0.3)
    rubbing = run(with_effect(rotary(J, start_rate=2.0), "viscous", viscous=0.7), 0.3)
    expected = 0.3 / 0.7 + (2.0 - 0.3 / 0.7) * np.exp(-0.7 / J * times(fading))
    np.testing.assert_allclose(fading.rate[:, 0], expected, rtol=2e-7)
    np.testing.assert_allclose(fading.rate, rubbing.rate, rtol=1e-12)
    # a measured torque tells them apart
    assert np.ptp(rubbing.applied[1:, 0]) == 0.0 and np.ptp(fading.applied[1:, 0]) > 0.5


def test_cogging_keeps_the_energy_of_motion_and_ripple() -> None:
    amplitude, order, phase = 0.2, 6.0, 0.5
    motion = run(
        with_effect(rotary(J, start_rate=1.5), "cogging", amplitude=amplitude, order=order, phase=phase), 0.0, 5000
    )
    q, v = motion.position[:, 0], motion.rate[:, 0]
    energy = 0.5 * J * v**2 + amplitude / order * np.cos(order * q + phase)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)
    assert np.ptp(v) > 0.05
