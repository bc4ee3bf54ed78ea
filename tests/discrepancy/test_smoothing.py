"""Interval means must not invent torque: what is held, sampled and smoothed alike has to cancel."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from gimbal_hil.knowledge.discrepancy.twin.smoothing import (
    Bands,
    interval_mean,
    interval_mean_of_rate,
    interval_means,
    scored,
    scored_length,
    taken_off,
)

BANDS = Bands(25.0, 1e-3)
T = np.arange(8000) * 1e-3
MIDDLE = slice(1500, 6000)


@pytest.mark.parametrize("hz", [0.7, 5.0, 20.0])
def test_a_sine_keeps_its_rate_and_acceleration_inside_the_scored_band(hz: float) -> None:
    w = 2.0 * np.pi * hz
    _, v, a = interval_means(np.sin(w * T)[:, None], BANDS)
    centre = T[:-1] + 0.5e-3
    assert np.abs(v[MIDDLE, 0] - w * np.cos(w * centre)[MIDDLE] * np.sinc(hz * 1e-3)).max() < 2e-4 * w
    # held torque bends the motion only at samples: second differences average neighbours, which is taken out again
    assert np.abs(a[MIDDLE, 0] + w * w * np.sin(w * centre)[MIDDLE]).max() < 0.003 * w * w


def test_the_acceleration_of_held_torque_is_found_without_delay() -> None:
    rng = np.random.default_rng(0)
    held = np.convolve(rng.normal(size=len(T) + 400), np.hanning(200) / 100.0, mode="same")[: len(T)]
    rate = np.concatenate([[0.0], np.cumsum(held[:-1]) * 1e-3])
    position = np.concatenate([[0.0], np.cumsum(rate[:-1] * 1e-3 + 0.5e-6 * held[:-1])])
    _, v, a = interval_means(position[:, None], BANDS)
    assert np.abs(a[MIDDLE, 0] - held[:-1][MIDDLE]).max() < 1e-3 * np.abs(held).max()
    assert np.abs(v[MIDDLE, 0] - 0.5 * (rate[1:] + rate[:-1])[MIDDLE]).max() < 1e-6
    assert np.abs(interval_mean_of_rate(rate, BANDS)[MIDDLE] - v[MIDDLE, 0]).max() < 1e-5


def test_a_constant_and_a_ramp_pass_unchanged() -> None:
    assert np.allclose(interval_mean(np.full(len(T), 3.0), BANDS), 3.0)
    q, v, a = interval_means((0.5 * T)[:, None], BANDS)
    assert np.allclose(v[MIDDLE], 0.5) and np.abs(a[MIDDLE]).max() < 1e-6
    assert np.allclose(q[MIDDLE, 0], 0.5 * (T[:-1] + 0.5e-3)[MIDDLE], atol=1e-6)


@pytest.mark.parametrize("rows", [5, 20, 150, 151])
def test_a_log_shorter_than_its_filters_gives_rows_all_the_same(rows: int) -> None:
    t = np.arange(rows) * 4e-3
    for part in interval_means(0.5 * t[:, None], Bands(1.25, 4e-3)):
        assert part.shape == (rows - 1, 1) and np.all(np.isfinite(part))


def test_scoring_keeps_the_band_drops_what_is_beyond_and_stands_at_its_rows() -> None:
    rows = np.column_stack([np.sin(2 * np.pi * 3.0 * T), np.sin(2 * np.pi * 80.0 * T)])
    thin = scored(rows, BANDS)
    assert len(thin) == scored_length(len(rows), BANDS)
    inside = slice(100, 500)
    at = BANDS.stride * np.arange(len(thin))[inside]
    assert np.abs(thin[inside, 0] - rows[at, 0]).max() < 1e-3
    assert np.abs(thin[inside, 1]).max() < 1e-3


@pytest.mark.parametrize("hz", [3.125, 12.5])
def test_a_gyro_is_not_compared_with_a_rate_that_was_quieted(hz: float) -> None:
    # reversals: power beyond the scored band comes and goes with the motion, and so does what quieting takes off
    bands, t = Bands(hz, 1e-3), np.arange(20001) * 1e-3
    slow = np.sin(2.0 * np.pi * 0.7 * t) + 0.6 * np.sin(2.0 * np.pi * 1.3 * t + 1.0)
    rate = slow + 0.02 * np.tanh(slow / 0.05)
    position = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1])) * 1e-3])
    _, v, _ = interval_means(np.round(position / 1.5e-6)[:, None] * 1.5e-6, bands)
    gyro = interval_mean_of_rate(rate, bands)[:, None]
    quieted = taken_off(np.round(position / 1.5e-6)[:, None] * 1.5e-6, v, bands)
    middle = slice(len(scored(v, bands)) // 10, -len(scored(v, bands)) // 10)
    error, as_quieted = scored(gyro - quieted - v, bands)[middle], scored(gyro - v, bands)[middle]
    assert np.std(error) < 4e-6
    if hz == 12.5:
        assert np.std(as_quieted) > 2e-5
    else:
        # beyond so narrow a band the motion never rests: that is no noise, and stays
        assert np.std(as_quieted) < 4e-6


@pytest.mark.parametrize("hz", [2.0, 3.125, 6.25])
def test_a_joint_breaks_away_as_sharply_where_less_is_scored(hz: float) -> None:
    t = np.arange(10001) * 1e-3
    since = np.maximum(t - 5.0, 0.0)
    position = 0.25 * since**2
    _, v, _ = interval_means(position[:, None], Bands(hz, 1e-3))
    # a sixtieth of a second before and after: what friction, a function of the rate's sign, sees of a reversal
    before, after = np.abs(v[4983, 0]), v[5017, 0]
    assert before < 0.02 * after


def test_the_noise_of_a_smoothed_position_is_taken_off_where_the_joint_rests() -> None:
    """A drive that smooths its encoder leaves nothing beyond the smoothing by which its noise could be known."""
    bands, t = Bands(12.5, 1e-3), np.arange(20001) * 1e-3
    moving = np.where(t < 12.0, np.sin(2.0 * np.pi * 0.25 * t), 0.0)
    noise = filtfilt(*butter(2, 50.0, fs=1000.0), 1e-5 * np.random.default_rng(3).standard_normal(len(t)))
    position = (moving + noise)[:, None]
    _, quiet, _ = interval_means(position, bands)
    rest = slice(13000, 19500)
    assert np.std(quiet[rest]) < 0.5 * np.std((quiet + taken_off(position, quiet, bands))[rest])
