"""The mean torque of a plateau: over the stretch that was asked for, at the samples, with how the speed fluctuates."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.experiments.plateau import DirectionPair, pair_of, plateau_mean
from gimbal_hil.knowledge.identification import rate_jitter

PERIOD_S = 1e-3
ENCODER_STEP = 1.5e-6


def _pass(speed: float, sign: int, friction: float, slope: float) -> dict[str, np.ndarray]:
    """One way over 0..0.5 rad against friction and a spring, the torque held from each sample to the next."""
    start = 0.0 if sign > 0 else 0.5
    time_s = np.arange(int(0.5 / speed / PERIOD_S)) * PERIOD_S
    position = start + sign * speed * time_s
    held = sign * friction + slope * (position + 0.5 * sign * speed * PERIOD_S)
    noise = np.random.default_rng(3).normal(0.0, 1e-6, len(time_s))
    # what a loop gives it takes back in the next row
    torque = held + np.diff(noise, prepend=0.0)
    return {
        "time_s": time_s,
        "outer.position": np.round(position / ENCODER_STEP) * ENCODER_STEP,
        "outer.torque": torque,
    }


def _pair(speed: float, slope: float) -> DirectionPair:
    ways = []
    for sign in (1, -1):
        mean = plateau_mean(_pass(speed, sign, 0.02, slope), "outer", 0.1231, 0.3777)
        assert mean is not None
        ways.append([mean.as_row()])
    pair = pair_of(*ways)
    assert pair is not None
    return pair


@pytest.mark.parametrize("speed", [0.01, 0.1, 0.5])
def test_a_torque_that_depends_on_position_alone_leaves_friction_untouched_at_any_speed(speed: float) -> None:
    pair = _pair(speed, slope=0.2)
    assert pair.friction_nm == pytest.approx(0.02, abs=2e-7)
    assert pair.positional_nm == pytest.approx(0.2 * 0.5 * (0.1231 + 0.3777), abs=2e-6)


@pytest.mark.parametrize("speed", [0.001, 0.0035, 0.05])
def test_how_the_speed_fluctuates_is_seen_through_the_encoder_step(speed: float) -> None:
    rng = np.random.default_rng(5)
    rate = speed + 5e-5 * np.repeat(rng.standard_normal(1000), 10)
    time_s = np.arange(len(rate)) * PERIOD_S
    position = np.round(np.cumsum(rate) * PERIOD_S / ENCODER_STEP) * ENCODER_STEP
    assert rate_jitter(time_s, position) == pytest.approx(5e-5, rel=0.15)


def test_a_joint_that_hardly_moves_has_no_fluctuation() -> None:
    time_s = np.arange(2000) * PERIOD_S
    assert rate_jitter(time_s, np.zeros(2000)) == 0.0
