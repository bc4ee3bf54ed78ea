"""Margins: the formula on loops whose margin is known, and what is said to be stable is what a simulation says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gimbal_hil.arena import controller_settings
from gimbal_hil.control import layout as control
from gimbal_hil.host import layout as host
from gimbal_hil.settings import host_configuration, observed_joint
from gimbal_hil.tuning import AxisDynamics, ObservedLaw, disk_margin, encirclements, margins
from sim_backend.model import shipped_model

W = np.geomspace(0.1, 0.98 * math.pi * 1e3, 4000)


def test_an_integrator_has_the_whole_disk_and_guarantees_any_gain_and_ninety_degrees() -> None:
    alpha = disk_margin(30.0 / (1j * W))
    assert alpha == pytest.approx(2.0)
    assert margins(2.0) == (math.inf, pytest.approx(90.0))


def test_a_delayed_integrator_is_told_from_an_unstable_one() -> None:
    for gain, stable in ((100.0, True), (200.0, False)):
        # delay of 10 ms: stable below pi / 2 / 0.01 = 157
        loop = gain / (1j * W) * np.exp(-0.01j * W)
        assert (encirclements(loop) > 0.0) is stable


def dynamics(axis: str) -> AxisDynamics:
    model = shipped_model("realistic")
    inertia, mode = {"outer": (0.5028, 55.0), "inner": (0.0696, 80.0)}[axis]
    viscous = model.number(axis, "friction.viscous")
    hung = ((2.0 * math.pi * mode, 0.02, 0.1),)
    return AxisDynamics(inertia, viscous, 0.0, 0.002, model.number(axis, "gyro.bandwidth"), 0.7, hung)


@pytest.mark.parametrize("axis", ["outer", "inner"])
def test_the_arena_s_observer_keeps_a_margin_and_survives_inertia_and_delay_that_are_off(axis: str) -> None:
    settings, place = controller_settings("all"), ("outer", "inner").index(axis)
    section = settings.axes[axis]
    assert section.observer is not None
    joint = observed_joint(shipped_model("realistic"), axis, settings.step_s, section.observer)
    C, case = host_configuration(settings), dynamics(axis)
    gains = C[host.axis_c(place) + control.OBSERVER_GAIN :][:12].reshape(6, 2)
    inertia = {"outer": 0.5028, "inner": 0.0696}[axis]
    law = ObservedLaw(joint, gains, 20.0, section.rate_loop.kp_s_per_rad, inertia, 2)
    alpha = disk_margin(law.torque(W, case))
    assert alpha > 0.4
    assert margins(alpha)[0] > 1.5 and margins(alpha)[1] > 22.0
    for wrong in (case.varied(0.7), case.varied(1.3), case.varied(1.0, 0.001)):
        assert encirclements(law.torque(W, wrong)) > 0.0


def test_the_response_of_the_law_is_that_of_its_code() -> None:
    from gimbal_hil.control import Mode, observe, observed_torque, remember_torque, start_observing

    settings = controller_settings("all")
    section = settings.axes["outer"]
    assert section.observer is not None
    joint = observed_joint(shipped_model("realistic"), "outer", 1e-3, section.observer)
    C = host_configuration(settings)[host.axis_c(0) :]
    law = ObservedLaw(joint, joint.gains(), 20.0, 60.0, 0.5, 2)
    w, ticks = 2.0 * math.pi * 5.0, 8000
    H = np.zeros(control.CONTROL_STATES)
    H[control.MOVED_INERTIA] = 0.5
    start_observing(0.0, 0.0, 0.0, H, 0)
    answered = []
    for k in range(ticks):
        observe(1e-6 * math.sin(w * k * 1e-3), 0.0, 0.0, 1e-3, H, 0, C, 0)
        answered.append(observed_torque(int(Mode.POSITION), 0.0, 0.0, (-9.0, 9.0), 1e-3, H, 0, C, 0))
        remember_torque(H, 0)
    t = 1e-3 * np.arange(ticks)[-4000:]
    wave = np.exp(-1j * w * t)
    measured = 2.0 * np.mean(np.array(answered)[-4000:] * wave) / 1e-6 * 1j
    expected = -0.5 * law.accelerations(np.array([w]))[0][0]
    assert measured == pytest.approx(expected, rel=2e-3)
