"""Velocity maps from closed-loop motion: what is not friction is taken out."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.identification import Plateau, VelocityMap, measure_velocity_map
from gimbal_hil.knowledge.identification.axis_motion import centred_torque
from gimbal_hil.knowledge.identification.position_curve import fit_position_curve
from tests.identification.one_axis_rig import (
    ENCODER_STEP,
    OUTER,
    Recorded,
    Rig,
    follow_rate,
    plateau_rows,
    there_and_back,
)

SPEEDS = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1)


def _measure(recorded: Recorded, inertia: float = 0.5) -> VelocityMap:
    torque = centred_torque(recorded.torque)
    plateaus = [
        Plateau(f"rows {rows.start}", recorded.time_s[rows], recorded.position[rows], torque[rows], inertia)
        for rows in plateau_rows(recorded.rate_ref)
    ]
    return measure_velocity_map(plateaus, position_step=ENCODER_STEP, bristle_length=1.1e-3)


def _errors(found: VelocityMap) -> np.ndarray:
    true = np.array([np.sign(p.rate) * OUTER.static.torque(np.array([abs(p.rate)]))[0] for p in found.points])
    return np.array([p.torque for p in found.points]) - true


def test_a_clean_axis_gives_its_own_curve_within_the_errors_stated() -> None:
    found = _measure(follow_rate(Rig(), there_and_back(SPEEDS), 1))
    assert len(found.points) == 12
    scores = _errors(found) / np.array([p.standard_error for p in found.points])
    assert np.max(np.abs(scores)) < 3.5
    assert np.max(np.abs(_errors(found))) < 1e-3


def test_gravity_and_ripple_that_no_model_knows_cancel_between_the_directions() -> None:
    found = _measure(follow_rate(Rig(gravity=0.05, ripple=0.02), there_and_back(SPEEDS, least_rad=0.35), 2))
    odd = [0.5 * (a.torque - b.torque) for a, b in zip(found.points[6:], reversed(found.points[:6]), strict=True)]
    true = OUTER.static.torque(np.array(SPEEDS))
    assert odd == pytest.approx(true, abs=1.5e-3)
    assert found.curve_positive is not None
    assert found.curve_positive is found.curve_negative
    assert np.ptp(found.curve_positive.values) == pytest.approx(0.04, rel=0.3)


def test_friction_belongs_to_the_joint_rate_when_the_base_turns() -> None:
    reference = there_and_back(SPEEDS)
    base = np.full(len(reference), 0.03)
    found = _measure(follow_rate(Rig(), reference, 3, base))
    assert [abs(p.rate) for p in found.points[6:]] == pytest.approx(SPEEDS, rel=0.02)
    assert np.max(np.abs(_errors(found))) < 1.5e-3


def test_plateaus_of_a_few_encoder_steps_are_refused_with_a_reason() -> None:
    coarse = Rig(encoder_step=1e-3)
    recorded = follow_rate(coarse, there_and_back((0.01,)), 4)
    torque = centred_torque(recorded.torque)
    rows = plateau_rows(recorded.rate_ref)[0]
    found = measure_velocity_map(
        [Plateau("slow", recorded.time_s[rows], recorded.position[rows], torque[rows], 0.5)], position_step=1e-3
    )
    assert not found.points
    assert found.rejected[0].label == "slow"


def test_a_gentle_acceleration_inside_the_tolerance_is_paid_for_by_the_momentum_balance() -> None:
    time = np.arange(5000) * 1e-3
    rate = 0.1 + 4e-5 * time
    position = 0.1 * time + 2e-5 * time**2
    friction = np.full(5000, 0.25) + 50.0 * 4e-5
    found = measure_velocity_map([Plateau("accelerating", time, position, friction, 50.0)])
    assert found.points[0].torque == pytest.approx(0.25, abs=2e-4)
    assert found.points[0].rate == pytest.approx(float(np.mean(rate)), rel=1e-3)


@pytest.mark.parametrize("order", [5.0, 17.0, 40.0])
def test_a_ripple_is_taken_off_pieces_that_end_in_the_middle_of_it(order: float) -> None:
    draw, pieces, levels = np.random.default_rng(4), [], []
    for number in range(24):
        low = draw.uniform(0.0, 1.1)
        q = np.linspace(low, draw.uniform(low + 0.15, 1.3), 4000)[:: (-1) ** number]
        levels.append(0.1 + 0.01 * number)
        pieces.append((q, levels[-1] + 0.01 * np.sin(order * q + 0.4) + 1e-6 * draw.normal(size=4000)))
    curve = fit_position_curve(pieces)
    assert curve is not None
    means = [np.mean(torque - curve.torque(q)) for q, torque in pieces]
    off = np.array(means) - np.array(levels)
    # what is the same in all of them cannot be told from friction
    assert np.std(off) < 1e-3 * 0.01


def test_no_curve_is_bent_through_noise_or_a_stretch_that_nothing_passes() -> None:
    draw = np.random.default_rng(5)
    q = np.linspace(0.0, 0.3, 4000)
    assert fit_position_curve([(q, draw.normal(size=4000)), (q, draw.normal(size=4000))]) is None
    apart = [(q, np.sin(20.0 * q)), (q + 0.7, np.sin(20.0 * (q + 0.7))), (q[:2000], np.sin(20.0 * q[:2000]))]
    curve = fit_position_curve(apart)
    assert curve is not None and np.max(np.abs(curve.torque(np.linspace(0.0, 1.0, 500)))) < 4.0


def test_torque_and_rate_of_a_point_are_those_of_the_same_rows() -> None:
    time = np.arange(6000) * 1e-3
    # a loop that comes to its speed slowly, within what counts as steady; viscosity of a cold axis
    rate = 0.1 * (1.0 + 0.004 * np.exp(-time / 0.6))
    position = 0.1 * time - 0.00024 * np.exp(-time / 0.6)
    friction = 0.2 + 1.5 * rate + 2e-6 * np.random.default_rng(3).normal(size=len(time))
    (point,) = measure_velocity_map([Plateau("cold", time, position, friction, 0.0)]).points
    assert point.torque == pytest.approx(0.2 + 1.5 * point.rate, abs=3e-7)


def test_passes_of_one_speed_become_one_point() -> None:
    reference = there_and_back((0.02, 0.02, 0.02, 0.05))
    found = _measure(follow_rate(Rig(), reference, 5))
    assert [p.passes for p in found.points] == [1, 3, 3, 1]


def test_a_rate_that_follows_the_noise_of_a_gyro_bends_the_bristles_less_and_the_curve_knows() -> None:
    speed, jitter = np.array([0.001, 0.003, 0.01]), np.array([1e-4, 1e-4, 1e-4])
    static = OUTER.static
    normal = np.random.default_rng(1).normal(size=100_000)
    # both signs of each, so that the mean is that of the speed
    fast = speed[:, None] + jitter[:, None] * np.concatenate([normal, -normal])
    bent = np.abs(fast) / (static.torque(np.abs(fast)) - static.viscous * np.abs(fast))
    expected = speed / np.mean(bent, axis=1) + static.viscous * speed
    assert static.torque_with_jitter(speed, jitter) == pytest.approx(expected, rel=2e-5)
    assert np.all(static.torque_with_jitter(speed, jitter) < static.torque(speed))
    assert static.torque_with_jitter(speed, 0.0 * jitter) == pytest.approx(static.torque(speed), rel=1e-12)


def test_the_fluctuation_of_the_rate_is_read_from_the_torque() -> None:
    inertia, step_s, sigma = 0.5, 0.01, 6e-5
    rate = 0.002 + sigma * np.random.default_rng(2).normal(size=20_001)
    position = np.concatenate([[0.0], np.cumsum(rate[:-1]) * step_s])
    torque = 0.25 + inertia * np.diff(rate) / step_s
    plateau = Plateau("noisy", np.arange(20_000) * step_s, position[:-1], torque, inertia)
    (point,) = measure_velocity_map([plateau]).points
    assert point.jitter == pytest.approx(sigma, rel=0.05)


def test_settling_of_the_bristles_is_left_out_although_no_test_sees_it_in_the_noise() -> None:
    time = np.arange(40_000) * 1e-3
    position = 0.001 * time
    length = 1.0e-3
    friction = 0.25 - 0.5 * np.exp(-position / length) + np.random.default_rng(3).normal(0.0, 0.02, len(time))
    (told,) = measure_velocity_map([Plateau("slow", time, position, friction, 0.5)], bristle_length=length).points
    assert abs(told.torque - 0.25) < 3.0 * told.standard_error
    assert told.effective_samples < 30_000


def test_what_a_loop_does_while_it_settles_is_no_torque_of_that_position() -> None:
    plateaus = []
    for number, (sign, speed) in enumerate((s, v) for v in (0.02, 0.04, 0.08) for s in (1.0, -1.0)):
        time = np.arange(int(0.8 / speed / 1e-3)) * 1e-3
        position = 0.4 - sign * 0.4 + sign * speed * time
        noise = np.random.default_rng(number).normal(0.0, 1e-3, len(time))
        friction = sign * (0.25 + 0.3 * np.exp(-time / 0.03)) + noise
        plateaus.append(Plateau(f"{speed} {sign}", time, position, friction, 0.5, settling_s=0.5))
    found = measure_velocity_map(plateaus, bristle_length=5e-4)
    assert found.curve_positive is None
    assert all(abs(abs(point.torque) - 0.25) < 4.0 * point.standard_error for point in found.points)
