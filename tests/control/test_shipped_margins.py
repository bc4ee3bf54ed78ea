"""The shipped gains leave margin: with two ticks of extra delay and a 200 Hz gyro, sliding or stuck, at any
elevation.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from gimbal_hil.settings import shipped_settings
from tests.control.loop_margins import Axis, gain_margin_db, gyro, phase_margin_deg, pi, torque_to_rate

FREQUENCIES = np.geomspace(0.05, 3000.0, 40000)
#: appendix A of the thesis and its friction: level and upright antenna, linearised while sliding and while stuck
PLANTS = [
    ("outer", Axis(0.5028, 0.0609)),
    ("outer", Axis(0.4691, 0.0609)),
    ("outer", Axis(0.5028, 16.02 + 0.0609, 238.88)),
    ("inner", Axis(0.0696, 0.0336)),
    ("inner", Axis(0.0696, 6.97 + 0.0336, 271.68)),
]


@pytest.mark.parametrize(("name", "plant"), PLANTS)
@pytest.mark.parametrize("extra_ticks", [0, 2])
def test_rate_and_position_loops_keep_45_degrees_and_6_db(name: str, plant: Axis, extra_ticks: int) -> None:
    settings = shipped_settings()
    axis, step_s, w = settings.axes[name], settings.step_s, FREQUENCIES
    forward = pi(w, axis.rate_loop.kp_s_per_rad, axis.rate_loop.ki_per_rad, step_s) * axis.rate_loop.torque_per_unit_nm
    to_rate = forward * torque_to_rate(w, plant, step_s, extra_ticks)
    rate_loop = to_rate * gyro(w, 200.0)
    margin, _ = phase_margin_deg(w, rate_loop)
    assert margin >= 45.0
    assert gain_margin_db(w, rate_loop) >= 6.0
    closed = to_rate / (1.0 + rate_loop)
    position_loop = pi(w, axis.position_loop.kp_per_s, axis.position_loop.ki_per_s2, step_s) * closed / (1j * w)
    margin, _ = phase_margin_deg(w, position_loop)
    assert margin >= 45.0
    assert gain_margin_db(w, position_loop) >= 6.0


@pytest.mark.parametrize(("name", "plant"), PLANTS)
def test_every_corner_of_what_may_be_adjusted_while_it_runs_keeps_45_degrees_and_10_db(name: str, plant: Axis) -> None:
    settings = shipped_settings()
    step_s, w = settings.step_s, FREQUENCIES[::5]
    bounds = {key.value: values for key, values in settings.axes[name].adjustable.items()}
    gains = ("rate_loop.kp_s_per_rad", "rate_loop.ki_per_rad", "position_loop.kp_per_s", "position_loop.ki_per_s2")
    for rate_kp, rate_ki, position_kp, position_ki in itertools.product(*(bounds[gain] for gain in gains)):
        to_rate = pi(w, rate_kp, rate_ki, step_s) * torque_to_rate(w, plant, step_s, 0)
        rate_loop = to_rate * gyro(w, 200.0)
        position_loop = pi(w, position_kp, position_ki, step_s) * to_rate / (1.0 + rate_loop) / (1j * w)
        for loop in (rate_loop, position_loop):
            assert phase_margin_deg(w, loop)[0] >= 45.0
            assert gain_margin_db(w, loop) >= 10.0
