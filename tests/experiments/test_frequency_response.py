"""Frequency response from laps: a loop whose transfer function is known, with noise that would bias the ratio of output
to input.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from gimbal_hil.knowledge.experiments.frequency import Lap, frequency_response, margins_of
from tests.control.loop_margins import gain_margin_db, phase_margin_deg

STEP_S, SAMPLES = 1e-3, 20_000
GAIN, DELAY_TICKS = 100.0, 4
LOW_HZ, HIGH_HZ = 0.5, 300.0


def chirp() -> np.ndarray:
    time_s = np.arange(SAMPLES) * STEP_S
    growth = math.log(HIGH_HZ / LOW_HZ) / (SAMPLES * STEP_S)
    return np.sin(2.0 * np.pi * LOW_HZ * (np.exp(growth * time_s) - 1.0) / growth)


def lap(noise: float, seed: int) -> Lap:
    """An integrator with a delay in a loop: y[k+1] = y[k] + g h e[k - delay], e = r - y - n."""
    reference, random = chirp(), np.random.default_rng(seed)
    disturbance = noise * random.standard_normal(SAMPLES)
    measured, error, y = np.zeros(SAMPLES), np.zeros(SAMPLES), 0.0
    for k in range(SAMPLES):
        measured[k] = y + disturbance[k]
        error[k] = reference[k] - measured[k]
        if k >= DELAY_TICKS:
            y += GAIN * STEP_S * error[k - DELAY_TICKS]
    return Lap(STEP_S, reference, measured)


def loop_of(w: np.ndarray) -> np.ndarray:
    z = np.exp(1j * w * STEP_S)
    return np.asarray(GAIN * STEP_S * z**-DELAY_TICKS / (z - 1.0))


@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_margins_are_those_of_the_loop_with_and_without_noise(noise: float) -> None:
    response = frequency_response([lap(noise, seed) for seed in range(1 if noise == 0.0 else 4)], LOW_HZ, HIGH_HZ)
    margins = margins_of(response)
    w = 2.0 * np.pi * np.geomspace(LOW_HZ, HIGH_HZ, 20_000)
    phase, crossover = phase_margin_deg(w, loop_of(w))
    assert margins.crossover_hz == pytest.approx(crossover / (2.0 * math.pi), rel=0.02)
    assert margins.phase_margin_deg == pytest.approx(phase, abs=2.0)
    assert margins.gain_margin_db == pytest.approx(gain_margin_db(w, loop_of(w)), abs=0.5)


def test_the_open_loop_is_not_biased_by_noise_inside_the_loop() -> None:
    response = frequency_response([lap(0.3, seed) for seed in range(6)], LOW_HZ, HIGH_HZ)
    band = (response.frequency_hz > 3.0) & (response.frequency_hz < 40.0)
    truth = loop_of(2.0 * np.pi * response.frequency_hz[band])
    assert np.sqrt(np.mean(np.abs(response.open[band] / truth - 1.0) ** 2)) < 0.06


def test_coherence_falls_where_the_noise_covers_the_output() -> None:
    clean, noisy = (frequency_response([lap(noise, 1)], LOW_HZ, HIGH_HZ) for noise in (0.0, 1.0))
    assert np.min(clean.coherence[clean.frequency_hz < 100.0]) > 0.95
    assert np.median(noisy.coherence[noisy.frequency_hz > 150.0]) < 0.6


def test_a_loop_that_never_crosses_has_no_margins() -> None:
    reference = chirp()
    response = frequency_response([Lap(STEP_S, reference, 0.1 * reference)], LOW_HZ, HIGH_HZ)
    margins = margins_of(response)
    assert margins.crossover_hz is None and margins.phase_margin_deg is None and margins.gain_margin_db is None
