"""Mass effects: a pendulum, the gyroscopic torque of products of inertia, and the moment itself."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.effects.rigs import antenna, horizontal, rotary, run, times, with_effect


def test_inertia_divides_the_torque() -> None:
    motion = run(with_effect(rotary(0.5), "inertia", inertia=0.8), 0.4)
    np.testing.assert_allclose(motion.rate[:, 0], 0.5 * times(motion), atol=1e-12)


def test_static_unbalance_makes_a_pendulum_of_the_right_period() -> None:
    inertia, mass, arm = 0.4, 2.0, 0.1
    model = horizontal(inertia, mass, 0.0, 1e-3).with_number("axis", "body.cog.y", 0.0)
    assert np.ptp(run(model, 0.0).position) == 0.0
    motion = run(with_effect(model, "static_unbalance", cog_y=-arm), 0.0, 4000)
    w = math.sqrt(mass * 9.81 * arm / inertia)
    np.testing.assert_allclose(motion.position[:, 0], 1e-3 * np.cos(w * times(motion)), atol=2e-8)


def test_static_unbalance_of_a_tilted_antenna_is_the_weight_times_its_arm() -> None:
    model = antenna(motion="fixed", attitude_rad={"roll": 0.3})
    for axis in model.axes:
        for key in "xyz":
            model = model.with_number(axis, f"body.cog.{key}", 0.0)
    # gravity along -y of the base is g sin(roll); an arm in x turns it into a torque about z
    pulled = with_effect(model, "static_unbalance", "outer", cog_x=0.02)
    torque = -model.number("outer", "body.mass") * 9.81 * math.sin(0.3) * 0.02
    moment = 0.5028
    assert run(pulled, 0.0, 3).rate[1, 0] == pytest.approx(torque / moment * 1e-3, rel=2e-2)
    assert run(model, 0.0, 3).rate[1, 0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("product", "sign"), [("ixz", 1.0), ("iyz", -1.0)])
def test_dynamic_unbalance_turns_steady_base_rates_into_torque(product: str, sign: float) -> None:
    p, q, r = 0.6, -0.4, 0.9
    model = antenna(motion="constant_rate", rate_rad_s={"p": p, "q": q, "r": r})
    for axis in model.axes:
        for key in "xyz":
            model = model.with_number(axis, f"body.cog.{key}", 0.0)
    # z row of -w x (I w): ixz gives q r, iyz gives -p r (and its square terms with the base rates only)
    own = model.number("outer", f"body.inertia.{product[1:]}")
    changed = with_effect(model, "dynamic_unbalance", "outer", **{product: own + 0.02})
    torque = 0.02 * (q * r if product == "ixz" else -p * r)
    difference = (run(changed, 0.0, 3).rate[1, 0] - run(model, 0.0, 3).rate[1, 0]) / 1e-3
    # friction still sticks in the first millisecond: a spring of 239 N m/rad and 16 N m s/rad takes its share
    assert math.copysign(1.0, difference) == math.copysign(1.0, torque)
    assert difference * 0.5028 == pytest.approx(torque, rel=0.03)


def test_products_of_inertia_of_a_resting_antenna_are_not_felt() -> None:
    model = antenna()
    own = model.number("outer", "body.inertia.xz")
    changed = with_effect(model, "dynamic_unbalance", "outer", ixz=own + 0.02)
    np.testing.assert_allclose(run(changed, 0.0, 500).position[:, 0], run(model, 0.0, 500).position[:, 0], atol=1e-9)
