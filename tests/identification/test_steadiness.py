"""Where a plateau is steady: transients, drifts and stick-slip are told from noise."""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.identification.steadiness import (
    cusum_score,
    find_steady_window,
    reverse_arrangement_score,
    settled_start,
)

TIME = np.arange(4000) * 1e-3


def _position(rate: np.ndarray, noise: float, seed: int = 0) -> np.ndarray:
    return np.asarray(np.cumsum(rate) * 1e-3 + noise * np.random.default_rng(seed).standard_normal(len(rate)))


def test_a_constant_speed_is_steady_from_end_to_end() -> None:
    window = find_steady_window(TIME, _position(np.full(4000, 0.05), 1e-6))
    assert window is not None
    assert window.start < 200 and window.stop > 3900
    assert abs(window.rate - 0.05) < 1e-5


def test_a_starting_transient_is_cut_off() -> None:
    window = find_steady_window(TIME, _position(0.05 * (1.0 - np.exp(-TIME / 0.15)), 1e-6))
    assert window is not None
    assert window.start > 300
    assert abs(window.rate / 0.05 - 1.0) < 0.01


def test_a_stop_at_the_end_is_cut_off() -> None:
    rate = np.where(TIME < 2.5, 0.05, 0.0)
    window = find_steady_window(TIME, _position(rate, 1e-6))
    assert window is not None
    assert window.stop <= 2510


def test_a_steady_acceleration_has_no_window() -> None:
    assert find_steady_window(TIME, _position(0.05 + 0.02 * TIME, 1e-6)) is None


def test_stick_slip_has_no_window() -> None:
    rate = 0.05 * (1.0 + np.sign(np.sin(2.0 * np.pi * 0.9 * TIME)))
    assert find_steady_window(TIME, _position(rate, 1e-6)) is None


def test_both_tests_reject_pure_noise_about_as_rarely_as_they_claim() -> None:
    rng = np.random.default_rng(3)
    rejected = 0
    for _ in range(500):
        values = rng.standard_normal(30)
        rejected += abs(reverse_arrangement_score(values)) > 2.576 or cusum_score(values) > 1.628
    assert rejected < 20


def test_friction_that_settles_slowly_is_used_only_after_it_has_settled() -> None:
    noise = 0.01 * np.random.default_rng(4).standard_normal(4000)
    first, drift = settled_start(0.25 * (1.0 - np.exp(-TIME / 0.4)) + noise)
    assert 1000 < first < 2800
    assert drift == 0.0


def test_a_drift_that_never_ends_is_reported() -> None:
    _, drift = settled_start(0.1 * TIME)
    assert drift > 0.05
