"""The gyro's lag in closed form is what a library's exact discretisation gives, and the plant's gyro has it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import cont2discrete, lsim

from sim_backend.model import shipped_model
from sim_backend.model.numbers import gyro_filter
from sim_backend.plant import Plant


@pytest.mark.parametrize("bandwidth_rad_s", [60.0, 400.0, 3000.0])
@pytest.mark.parametrize("damping", [0.3, 0.707, 1.0, 1.5])
def test_the_closed_form_is_the_zero_order_hold_of_the_second_order_lag(bandwidth_rad_s: float, damping: float) -> None:
    wn, step_s = bandwidth_rad_s, 1e-4
    a = np.array([[0.0, 1.0], [-wn * wn, -2.0 * damping * wn]])
    b = np.array([[0.0], [wn * wn]])
    discrete_a, discrete_b, *_ = cont2discrete((a, b, np.eye(2), np.zeros((2, 1))), step_s, "zoh")
    expected = [*discrete_a.ravel(), *discrete_b.ravel()]
    np.testing.assert_allclose(gyro_filter(wn, damping, step_s), expected, rtol=1e-10)


def test_the_plants_gyro_reads_its_joint_as_late_as_the_lag_says_and_not_half_a_step_sooner() -> None:
    wn, damping = 600.0, 0.7
    numbers = {"gyro.bandwidth": wn, "gyro.damping": damping, "gyro.noise": 0.0, "gyro.step": 0.0}
    time_s = np.arange(3000) * 1e-3
    ran = Plant(shipped_model().with_numbers("outer", numbers)).run(
        np.column_stack([4.0 * np.sin(9.0 * time_s), np.zeros(len(time_s))])
    )
    wanted = lsim(([wn * wn], [1.0, 2.0 * damping * wn, wn * wn]), ran.rate[:, 0], time_s)[1]
    bend = np.gradient(ran.rate[:, 0], time_s)
    # half a step of 0.1 ms would leave 50 microseconds of the acceleration
    sooner_s = float(bend @ (ran.gyro[:, 0] - wanted) / (bend @ bend))
    assert abs(sooner_s) < 2e-6
