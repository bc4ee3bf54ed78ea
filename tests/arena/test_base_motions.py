"""Motions of the arena's aircraft: gusts have the standard's spectrum, and what they do to the base is consistent."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.pointing.arena import Manoeuvre, Turbulence
from gimbal_hil.pointing.arena.base_motions import ROW_HZ


def test_the_gust_spectrum_has_the_stated_rms_and_half_of_it_at_the_standard_s_scale() -> None:
    turbulence = Turbulence(motion="turbulence", sigma_m_s=3.05)
    w = np.linspace(1e-4, 400.0, 4_000_001)
    assert np.trapezoid(turbulence.velocity_spectrum(w), w) == pytest.approx(3.05**2, rel=0.01)
    # far above V / L the spectrum falls as 3 / (pi L/V w^2)
    high = turbulence.velocity_spectrum(np.array([200.0, 400.0]))
    assert high[0] / high[1] == pytest.approx(4.0, rel=0.01)


def test_turbulence_of_twice_the_strength_moves_the_base_twice_as_much_and_seeds_differ() -> None:
    one, two = (Turbulence(motion="turbulence", sigma_m_s=sigma).rows(20.0, 3) for sigma in (1.5, 3.0))
    np.testing.assert_allclose(2.0 * one[0], two[0], atol=1e-12)
    np.testing.assert_allclose(2.0 * one[1], two[1], atol=1e-12)
    other = Turbulence(motion="turbulence", sigma_m_s=3.0).rows(20.0, 4)
    assert np.abs(other[0] - two[0]).max() > 1e-3


def test_moderate_turbulence_shakes_a_transport_by_a_tenth_of_g() -> None:
    pivots = [Turbulence(motion="turbulence", sigma_m_s=3.05).rows(60.0, seed)[1][:, 2] for seed in range(1, 6)]
    rms = float(np.sqrt(np.mean(np.concatenate(pivots) ** 2)))
    # a gust is worth 0.42 /s of it while the aircraft does not yet move with it
    assert 0.6 < rms < 0.42 * 3.05


def test_in_a_co_ordinated_turn_what_is_felt_points_down_through_the_floor() -> None:
    attitude, pivot = Manoeuvre(motion="manoeuvre", pull_up_m_s2=0.0).rows(18.0, 1)
    roll, pitch = attitude[:, 0], attitude[:, 1]
    g = 9.81
    felt = np.column_stack([g * np.sin(pitch), -g * np.cos(pitch) * np.sin(roll), -g * np.cos(pitch) * np.cos(roll)])
    felt -= pivot
    assert np.abs(felt[:, 1]).max() < 1e-9
    turning = round(8.0 * ROW_HZ)
    assert roll[turning] == pytest.approx(0.5236)
    assert felt[turning, 2] == pytest.approx(-g / np.cos(0.5236))
    # to the right, at g tan(bank) / V
    assert np.gradient(attitude[:, 2], 1.0 / ROW_HZ)[turning] == pytest.approx(-g * np.tan(0.5236) / 230.0, rel=1e-3)
