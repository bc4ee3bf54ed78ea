"""The shipped gains leave margin: with two ticks of extra delay and a 200 Hz gyro, sliding or stuck, at any
elevation.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from gimbal_hil.knowledge.tuning import AxisDynamics, CascadeLaw
from gimbal_hil.loop.settings import shipped_settings
from tests.control.loop_margins import Response, gain_margin_db, phase_margin_deg

FREQUENCIES = np.geomspace(0.05, 3000.0, 40000)


def rigid(inertia: float, damping: float, stiffness: float = 0.0) -> AxisDynamics:
    return AxisDynamics(inertia, damping, stiffness, 0.0, 0.0, 0.0)


#: appendix A of the thesis and its friction: level and upright antenna, linearised while sliding and while stuck
PLANTS = [
    ("outer", rigid(0.5028, 0.0609)),
    ("outer", rigid(0.4691, 0.0609)),
    ("outer", rigid(0.5028, 16.02 + 0.0609, 238.88)),
    ("inner", rigid(0.0696, 0.0336)),
    ("inner", rigid(0.0696, 6.97 + 0.0336, 271.68)),
]


def loops(law: CascadeLaw, plant: AxisDynamics, w: np.ndarray) -> tuple[Response, Response]:
    """The rate loop by itself, and the position loop around it when it is closed."""
    rate = replace(law, position_kp=0.0, position_ki=0.0).torque(w, plant)
    return rate, (law.torque(w, plant) - rate) / (1.0 + rate)


@pytest.mark.parametrize(("name", "plant"), PLANTS)
@pytest.mark.parametrize("extra_ticks", [0, 2])
def test_rate_and_position_loops_keep_45_degrees_and_6_db(name: str, plant: AxisDynamics, extra_ticks: int) -> None:
    settings = shipped_settings()
    axis, step_s = settings.axes[name], settings.step_s
    assert axis.rate_loop.torque_per_unit_nm == 1.0
    law = CascadeLaw(
        step_s,
        axis.position_loop.kp_per_s,
        axis.position_loop.ki_per_s2,
        axis.rate_loop.kp_s_per_rad,
        axis.rate_loop.ki_per_rad,
    )
    late = plant.varied(later_s=extra_ticks * step_s).with_sensing(2.0 * np.pi * 200.0, ())
    for loop in loops(law, replace(late, gyro_damping=0.7), FREQUENCIES):
        assert phase_margin_deg(FREQUENCIES, loop)[0] >= 45.0
        assert gain_margin_db(FREQUENCIES, loop) >= 6.0


@pytest.mark.parametrize(("name", "plant"), PLANTS)
def test_every_corner_of_what_may_be_adjusted_while_it_runs_keeps_45_degrees_and_10_db(
    name: str, plant: AxisDynamics
) -> None:
    settings = shipped_settings()
    w = FREQUENCIES[::5]
    bounds = {key.value: values for key, values in settings.axes[name].adjustable.items()}
    gains = ("position_loop.kp_per_s", "position_loop.ki_per_s2", "rate_loop.kp_s_per_rad", "rate_loop.ki_per_rad")
    for corner in itertools.product(*(bounds[gain] for gain in gains)):
        for loop in loops(CascadeLaw(settings.step_s, *corner), plant, w):
            assert phase_margin_deg(w, loop)[0] >= 45.0
            assert gain_margin_db(w, loop) >= 10.0
