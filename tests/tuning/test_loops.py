"""Margins: the formula on loops whose margin is known, and what is said to be stable is what a simulation says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gimbal_hil.knowledge.tuning import (
    AxisDynamics,
    CascadeLaw,
    ObservedLaw,
    disk_margin,
    encirclements,
    least_margin,
    margins,
)
from gimbal_hil.loop.control import layout as control
from gimbal_hil.loop.host import layout as host
from gimbal_hil.loop.settings import host_configuration, observed_joint, shipped_settings
from gimbal_hil.pointing.arena import controller_settings
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


#: kg m^2; what the outer axis carries depends on how the inner one stands
INERTIAS = {"outer": (0.5028, 0.4691), "inner": (0.0696,)}


def dynamics(axis: str) -> list[AxisDynamics]:
    """An axis of the realistic antenna in each of its inertias, while it slides and while its bristles hold it."""
    model = shipped_model("realistic")
    viscous, sigma0, sigma1 = (model.number(axis, f"friction.{name}") for name in ("viscous", "sigma0", "sigma1"))
    hung = ((2.0 * math.pi * {"outer": 55.0, "inner": 80.0}[axis], 0.02, 0.1),)
    gyro = model.number(axis, "gyro.bandwidth")
    return [
        AxisDynamics(inertia, damping, stiffness, 0.002, gyro, 0.7, hung)
        for inertia in INERTIAS[axis]
        for damping, stiffness in ((viscous, 0.0), (viscous + sigma1, sigma0))
    ]


def observed_law(axis: str) -> ObservedLaw:
    """The arena's `all` on an axis."""
    settings, place = controller_settings("all"), ("outer", "inner").index(axis)
    section = settings.axes[axis]
    assert section.observer is not None and section.observer.bandwidth_rad_s == 150.0
    joint = observed_joint(shipped_model("realistic"), axis, settings.step_s, section.observer)
    gains = host_configuration(settings)[host.axis_c(place) + control.OBSERVER_GAIN :][:12].reshape(6, 2)
    return ObservedLaw(joint, gains, 20.0, section.rate_loop.kp_s_per_rad, INERTIAS[axis][0], 2)


def shipped_law(axis: str) -> CascadeLaw:
    """The shipped cascade on an axis."""
    settings = shipped_settings()
    position, rate = settings.axes[axis].position_loop, settings.axes[axis].rate_loop
    return CascadeLaw(settings.step_s, position.kp_per_s, position.ki_per_s2, rate.kp_s_per_rad, rate.ki_per_rad)


@pytest.mark.parametrize(
    ("axis", "shipped", "observed"), [("outer", 0.46, 0.41), ("inner", 0.48, 0.44)], ids=["outer", "inner"]
)
def test_the_margins_on_the_page_of_control_are_those_of_the_loops(axis: str, shipped: float, observed: float) -> None:
    """Sliding and stuck; with inertia 30 % off, or a tick more of delay, the observer's loops stay stable."""
    cases = dynamics(axis)
    assert least_margin(shipped_law(axis), cases, W) == pytest.approx(shipped, abs=0.006)
    law = observed_law(axis)
    assert least_margin(law, cases, W) == pytest.approx(observed, abs=0.006)
    assert margins(observed)[0] > 1.5 and margins(observed)[1] > 23.0
    for case in cases:
        for wrong in (case.varied(0.7), case.varied(1.3), case.varied(1.0, 0.001)):
            assert encirclements(law.torque(W, wrong)) > 0.0


def test_the_response_of_the_law_is_that_of_its_code() -> None:
    from gimbal_hil.loop.control import Mode, observe, observed_torque, remember_torque, start_observing

    settings = controller_settings("all")
    section = settings.axes["outer"]
    assert section.observer is not None
    joint = observed_joint(shipped_model("realistic"), "outer", 1e-3, section.observer)
    C = host_configuration(settings)[host.axis_c(0) :]
    law = ObservedLaw(joint, joint.gains(), 20.0, 60.0, 0.5, 2)
    w, ticks = 2.0 * math.pi * 5.0, 8000
    H = np.zeros(control.CONTROL_STATES)
    H[control.MOVED_INERTIA] = 0.5
    start_observing(0.0, 0.0, 0.0, 1e-3, H, 0)
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
