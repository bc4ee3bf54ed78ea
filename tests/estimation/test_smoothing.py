"""Smoothing without delay: what each shape leaves, and that it is taken back as far as anything is left."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, filtfilt

from gimbal_hil.knowledge.estimation import Smoothing, SmoothingShape

STEP_S = 2e-3
TIME = np.arange(4000) * STEP_S
INSIDE = slice(500, 3500)


@pytest.mark.parametrize("shape", SmoothingShape)
def test_half_of_the_size_is_left_at_the_cut_off(shape: SmoothingShape) -> None:
    smoothed = Smoothing(shape, 4.0).of(np.sin(2.0 * np.pi * 4.0 * TIME), STEP_S)
    assert np.max(np.abs(smoothed[INSIDE])) == pytest.approx(0.5, abs=2e-3)


@pytest.mark.parametrize(
    ("shape", "order"), [(SmoothingShape.ONE_POLE, 1), (SmoothingShape.TWO_POLES, 2), (SmoothingShape.FOUR_POLES, 4)]
)
def test_a_filter_forwards_and_backwards_is_the_shape_of_its_order(shape: SmoothingShape, order: int) -> None:
    values = np.cumsum(np.random.default_rng(1).normal(size=len(TIME)))
    by_others = filtfilt(*butter(order, 5.0 * 2.0 * STEP_S), values)
    smoothed = Smoothing(shape, 5.0).of(values, STEP_S)
    assert np.max(np.abs(smoothed - by_others)[INSIDE]) < 0.02 * np.std(values)


def test_a_mean_over_rows_is_the_shape_of_a_mean() -> None:
    values = np.cumsum(np.random.default_rng(2).normal(size=len(TIME)))
    by_others = np.convolve(values, np.full(51, 1.0 / 51), "same")
    smoothed = Smoothing(SmoothingShape.MEAN, 0.6034 / (51 * STEP_S)).of(values, STEP_S)
    assert np.max(np.abs(smoothed - by_others)[INSIDE]) < 0.02 * np.std(values)


@settings(max_examples=30, deadline=None)
@given(
    shape=st.sampled_from(SmoothingShape),
    half_hz=st.floats(3.0, 40.0),
    hertz=st.floats(0.1, 2.0),
    slope=st.floats(-5.0, 5.0),
)
def test_slow_motion_comes_back_and_a_steady_one_stays(
    shape: SmoothingShape, half_hz: float, hertz: float, slope: float
) -> None:
    values = slope * TIME + np.sin(2.0 * np.pi * hertz * TIME)
    one = Smoothing(shape, half_hz)
    back = one.undone(one.of(values, STEP_S), STEP_S)
    assert np.max(np.abs(back - values)[INSIDE]) < 0.05
    assert np.allclose(one.of(slope * TIME, STEP_S), slope * TIME, atol=1e-9)


def test_of_what_is_gone_nothing_is_made_up() -> None:
    noise = np.random.default_rng(3).normal(size=len(TIME))
    assert np.std(Smoothing(SmoothingShape.TWO_POLES, 3.0).undone(noise, STEP_S)) < 5.0
