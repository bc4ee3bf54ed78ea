"""Torques by the model are those of the plant: applied to it, they bring the acceleration that was asked for."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.loop.control import layout, modelled_friction, rigid_torques
from gimbal_hil.loop.host import layout as host
from gimbal_hil.loop.settings import host_configuration
from gimbal_hil.pointing.arena import controller_settings
from sim_backend.model import plant_arrays, shipped_model
from sim_backend.plant import joint_accelerations


@pytest.mark.parametrize("seed", range(5))
def test_the_rigid_torques_bring_the_acceleration_on_a_base_that_turns_and_shifts(seed: int) -> None:
    draw = np.random.default_rng(seed)
    C, arrays = host_configuration(controller_settings("all")), plant_arrays(shipped_model())
    q, v, a = draw.uniform(-1.5, 1.5, 2), draw.uniform(-2.0, 2.0, 2), draw.uniform(-8.0, 8.0, 2)
    felt = np.array([0.0, 0.0, -9.81]) + draw.uniform(-5.0, 5.0, 3)
    rate, turning = draw.uniform(-1.0, 1.0, 3), draw.uniform(-3.0, 3.0, 3)
    base = (tuple(felt), tuple(rate), tuple(turning))
    drag, inertia = rigid_torques(
        C[host.MODEL_TENSOR :],
        C[host.MODEL_BODY :],
        tuple(q),
        tuple(v),
        tuple(a),
        base,  # type: ignore[arg-type]
    )
    torque = np.array(drag) + np.array(inertia) * a
    np.testing.assert_allclose(joint_accelerations(arrays.P, arrays.K, q, v, torque, felt, rate, turning), a, atol=1e-9)


def test_the_friction_fed_forward_is_the_sliding_curve_at_speed_and_bends_bristles_on_the_way() -> None:
    C = host_configuration(controller_settings("all"))
    model, c, H = shipped_model(), host.axis_c(0), np.zeros(layout.CONTROL_STATES)
    torques = [modelled_friction(0.05, 20.0, 1e-3, H, 0, C, c) for _ in range(2000)]
    steady = model.number("outer", "friction.coulomb") + 0.05 * model.number("outer", "friction.viscous")
    assert torques[-1] == pytest.approx(steady, rel=1e-3)
    # turned round slowly, the bristles are still bent the old way when the rate has changed its sign
    rates = 0.05 * np.cos(np.pi * np.linspace(0.0, 1.0, 4001))
    turning = np.array([modelled_friction(rate, 20.0, 1e-3, H, 0, C, c) for rate in rates])
    assert turning[np.argmax(rates < 0.0)] > 0.05
    assert turning[-1] == pytest.approx(-steady, rel=2e-3)
