"""A bump of friction at creep: the numbers of the regression hold beside it."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.identification import Determination
from gimbal_hil.knowledge.identification.axis_motion import regression_rule
from gimbal_hil.knowledge.identification.rigid_axis import RigidAxisFit, fit_rigid_axis
from tests.cases.joint import BENCH, TRUE

#: speed at which the bump has fallen to 37 %, rad/s
FADES = 0.2


def fitted(bump: float) -> RigidAxisFit:
    """The regression on a log of the bench whose friction is higher towards standstill by a share of its level."""
    log = BENCH.log("a")
    rate = 0.5 * (log.rate + np.append(log.rate[1:], log.rate[-1]))
    more = bump * BENCH.coulomb * np.exp(-np.abs(rate) / FADES) * np.sign(rate)
    return fit_rigid_axis(log.time, log.position, log.torque + more, regression_rule(1.0 / BENCH.rate_hz))


@pytest.mark.parametrize("bump", [0.15, 0.3])
def test_the_intervals_hold_what_the_numbers_are_beside_a_bump(bump: float) -> None:
    fit = fitted(bump)
    (told,) = [one.text for one in fit.warnings if one.rule == "friction_at_creep"]
    assert "more than coulomb and viscous friction" in told
    numbers = {one.name: one for one in fit.estimates}
    for name in ("inertia", "viscous", "coulomb"):
        assert numbers[name].interval.covers(TRUE[name]), name
    assert numbers["coulomb"].verdict is Determination.IDENTIFIED


def test_without_a_bump_none_is_told() -> None:
    assert not any(one.rule == "friction_at_creep" for one in fitted(0.0).warnings)


@pytest.mark.parametrize("seed", [8, 10, 26])
@pytest.mark.parametrize("begins", [0.0, 2.0], ids=["moving", "standing"])
def test_a_joint_that_never_creeps_shows_no_friction_at_creep(seed: int, begins: float) -> None:
    rng, step = np.random.default_rng(seed), 0.005
    time = np.arange(0.0, 40.0, step)
    rate = np.where(time < begins, 0.0, 1.0 + 0.6 * np.sin(5.0 * time))
    position = np.cumsum(rate) * step + 1e-6 * rng.standard_normal(len(time))
    torque = 0.02 * np.gradient(rate, step) + 0.1 * rate + 0.5 + 0.01 * rng.standard_normal(len(time))
    fit = fit_rigid_axis(time, position, torque, regression_rule(step))
    assert not any(one.rule == "friction_at_creep" for one in fit.warnings)
