"""Means of correlated samples: the error counts the correlation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from gimbal_hil.knowledge.identification.averaging import autocorrelation_time, mean_with_error, weighted_mean


def _autoregressive(rng: np.random.Generator, n: int, memory: float) -> np.ndarray:
    return np.asarray(lfilter([1.0], [1.0, -memory], rng.standard_normal(n + 500))[500:])


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_autocorrelation_time_of_a_known_process_is_found(memory: float) -> None:
    found = autocorrelation_time(_autoregressive(np.random.default_rng(1), 40_000, memory))
    assert found == pytest.approx((1.0 + memory) / (1.0 - memory), rel=0.15)


def test_standard_error_of_correlated_samples_covers_the_mean_as_often_as_it_says() -> None:
    rng = np.random.default_rng(2)
    inside = 0
    for _ in range(300):
        estimate = mean_with_error(_autoregressive(rng, 3000, 0.9))
        inside += abs(estimate.mean) < 1.96 * estimate.standard_error
    assert 0.90 <= inside / 300 <= 0.98


def test_a_constant_series_has_no_error_and_no_memory() -> None:
    estimate = mean_with_error(np.full(100, 3.0))
    assert estimate.mean == 3.0
    assert estimate.standard_error == 0.0


def test_passes_that_disagree_widen_the_error_of_their_mean() -> None:
    agreeing = weighted_mean(np.array([1.0, 1.01, 0.99]), np.full(3, 0.02))
    disagreeing = weighted_mean(np.array([1.0, 1.3, 0.7]), np.full(3, 0.02))
    assert agreeing.standard_error == pytest.approx(0.02 / np.sqrt(3.0))
    assert disagreeing.standard_error > 0.1
