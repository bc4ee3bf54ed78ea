"""The shaped reference: motions pass as they are, steps become motions within the limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from gimbal_hil.loop.control import layout, shape_position, start_shaping

STEP_S, CORNER, RATE, ACCELERATION = 1e-3, 5.0, 2.4, 15.0


def shaped(asked: NDArray[np.float64], slope: NDArray[np.float64]) -> NDArray[np.float64]:
    """Position, rate and acceleration (n, 3) for references and slopes, from rest at zero."""
    H, C = np.zeros(layout.CONTROL_STATES), np.zeros(layout.CONTROL_PARAMETERS)
    C[layout.PREFILTER_GAIN], C[layout.PREFILTER_CORNER] = 1.0, CORNER
    C[layout.PREFILTER_RATE], C[layout.PREFILTER_ACCELERATION] = RATE, ACCELERATION
    start_shaping(0.0, H, 0)
    rows = []
    for value, rate in zip(asked, slope, strict=True):
        shape_position(value, rate, math.nan, STEP_S, H, 0, C, 0)
        rows.append(H[layout.SHAPED_POSITION : layout.SHAPED_ACCELERATION + 1].copy())
    return np.array(rows)


def test_a_smooth_motion_passes_without_delay() -> None:
    t = STEP_S * np.arange(6000)
    w = 2.0 * np.pi * 0.5
    found = shaped(0.3 * (1.0 - np.cos(w * t)), 0.3 * w * np.sin(w * t))
    np.testing.assert_allclose(found[:, 0], 0.3 * (1.0 - np.cos(w * t)), atol=1e-9)
    np.testing.assert_allclose(found[:, 1], 0.3 * w * np.sin(w * t), atol=1e-9)
    # half a tick late, as differences are
    np.testing.assert_allclose(found[1:, 2], 0.3 * w * w * np.cos(w * (t[1:] - 0.5 * STEP_S)), atol=1e-5)


def test_straight_pieces_of_a_table_pass_as_well() -> None:
    t = STEP_S * np.arange(4001)
    table = 0.2 * np.sin(3.0 * t)
    found = shaped(table[:-1], np.diff(table) / STEP_S)
    # once the start from rest has been caught up with
    assert np.abs(found[3900:, 0] - table[3900:-1]).max() < 1e-10


@pytest.mark.parametrize("size", [0.001, 0.2, 2.5, -8.0])
def test_a_step_becomes_a_motion_within_its_limits_that_ends_there(size: float) -> None:
    found = shaped(np.full(8000, size), np.zeros(8000))
    position, rate, acceleration = found.T
    assert np.abs(rate).max() <= RATE + 1e-9
    assert np.abs(acceleration).max() <= ACCELERATION + 1e-6
    # the exponential end that the corner leaves, and no overshoot
    assert abs(position[-1] - size) < 1e-9 + 1e-6 * abs(size)
    assert (np.sign(size) * position).max() <= abs(size) * (1.0 + 1e-9)
    np.testing.assert_allclose(np.diff(position), STEP_S * rate[1:], atol=1e-12)


def test_a_ramp_that_begins_is_caught_up_with_and_then_followed_exactly() -> None:
    t = STEP_S * np.arange(5000)
    found = shaped(0.5 * t, np.full(5000, 0.5))
    assert found[0, 1] <= ACCELERATION * STEP_S + 1e-12
    assert abs(found[-1, 0] - 0.5 * t[-1]) < 1e-6
    assert found[-1, 1] == pytest.approx(0.5, abs=1e-6)
