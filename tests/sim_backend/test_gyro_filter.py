"""The gyro's lag, written out in closed form, is what a library's exact discretisation gives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import cont2discrete

from sim_backend.model.numbers import gyro_filter


@pytest.mark.parametrize("bandwidth_rad_s", [60.0, 400.0, 3000.0])
@pytest.mark.parametrize("damping", [0.3, 0.707, 1.0, 1.5])
def test_the_closed_form_is_the_zero_order_hold_of_the_second_order_lag(bandwidth_rad_s: float, damping: float) -> None:
    wn, step_s = bandwidth_rad_s, 1e-4
    a = np.array([[0.0, 1.0], [-wn * wn, -2.0 * damping * wn]])
    b = np.array([[0.0], [wn * wn]])
    discrete_a, discrete_b, *_ = cont2discrete((a, b, np.eye(2), np.zeros((2, 1))), step_s, "zoh")
    expected = [*discrete_a.ravel(), *discrete_b.ravel()]
    np.testing.assert_allclose(gyro_filter(wn, damping, step_s), expected, rtol=1e-10)
