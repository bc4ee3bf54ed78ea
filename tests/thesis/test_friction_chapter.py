"""Chapter 4: the curves, the loop, the estimates, and the sliding experiment on the antenna."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gimbal_hil.proof.thesis.friction_curves import FrictionCurves, friction_curves
from gimbal_hil.proof.thesis.inferred import ideal_sensors
from gimbal_hil.proof.thesis.sliding import TEMPERATURES_DEGC, sliding_speeds, sliding_sweep, warm_antenna
from sim_backend.model import shipped_model

AXES = ("outer", "inner")


@pytest.fixture(scope="module")
def curves() -> dict[str, FrictionCurves]:
    return {axis: friction_curves(shipped_model(), axis) for axis in AXES}


@pytest.mark.parametrize("axis", AXES)
def test_the_corrected_curve_has_its_minimum_at_twenty_milliradians_a_second(
    axis: str, curves: dict[str, FrictionCurves]
) -> None:
    assert curves[axis].minimum_rad_s == pytest.approx(0.020, abs=0.001)


def test_the_exponent_as_printed_is_no_friction_curve(curves: dict[str, FrictionCurves]) -> None:
    assert curves["outer"].printed_at_fastest_nm > 1e5
    friction, rates = curves["inner"].friction, np.array([0.001, 0.01, 0.1])
    assert np.all(np.diff(friction.steady_as_printed(rates)) > 0.0)


@pytest.mark.parametrize("axis", AXES)
def test_faster_sines_open_a_wider_loop_around_zero_speed(axis: str, curves: dict[str, FrictionCurves]) -> None:
    widths = []
    for loop in curves[axis].loops:
        quarter = len(loop.torque_nm) // 4
        rising, falling = loop.torque_nm[:quarter], loop.torque_nm[quarter : 2 * quarter][::-1]
        widths.append(float(np.mean(np.abs(rising - falling))))
    assert widths == sorted(widths, reverse=True)
    # the slowest follows the steady curve wherever it slides
    slow = curves[axis].loops[-1]
    sliding = np.abs(slow.rate_rad_s) > 0.02
    np.testing.assert_allclose(
        slow.torque_nm[sliding], curves[axis].friction.steady(slow.rate_rad_s[sliding]), atol=2e-3
    )


def test_a_secant_near_break_away_is_far_too_soft(curves: dict[str, FrictionCurves]) -> None:
    assert {share: round(part, 2) for share, part in curves["outer"].secants} == {
        0.1: 0.95,
        0.5: 0.72,
        0.9: 0.39,
        0.98: 0.25,
    }


def test_tables_4_3_and_4_4_differ_tenfold_in_stiffness_and_in_their_own_numbers(
    curves: dict[str, FrictionCurves],
) -> None:
    for axis in AXES:
        assert curves[axis].stiffness_of_table_4_4 / curves[axis].stiffness_of_table_4_3 == pytest.approx(
            10.0, rel=0.05
        )
    # inner: 0.144 / 0.00060 is 240, the table prints 271.68
    assert curves["inner"].stiffness_of_table_4_4 == pytest.approx(240.0)
    assert curves["inner"].friction.sigma0 == 271.68


def test_sigma1_of_the_outer_axis_stands_for_a_damping_ratio_below_the_stated_range(
    curves: dict[str, FrictionCurves],
) -> None:
    assert curves["outer"].damping_ratio == pytest.approx(0.786, abs=0.001)
    friction = curves["outer"].friction
    carried = (friction.sigma1 + friction.viscous) / (2.0 * math.sqrt(friction.sigma0 * 0.5028))
    assert carried == pytest.approx(0.734, abs=0.001)


@pytest.mark.parametrize("axis", AXES)
def test_the_sliding_experiment_finds_the_steady_curve_and_gravity_apart(
    axis: str, curves: dict[str, FrictionCurves]
) -> None:
    speeds = sliding_speeds()[::6]
    sweep = sliding_sweep(ideal_sensors(shipped_model()), axis, speeds=speeds)
    np.testing.assert_allclose(sweep.friction_nm, curves[axis].friction.steady(speeds), atol=5e-4)
    weight = {"outer": 0.0, "inner": -5.08 * 9.81 * 0.02084}[axis]
    np.testing.assert_allclose(sweep.offset_nm, weight, atol=2e-3)


def test_a_sweep_in_one_direction_measures_the_unbalance_of_the_inner_gimbal() -> None:
    sweep = sliding_sweep(ideal_sensors(shipped_model()), "inner", speeds=np.array([0.01]))
    one_way = abs(sweep.friction_nm[0] + sweep.offset_nm[0])
    assert abs(sweep.offset_nm[0]) > 7.0 * 0.1451 and one_way > 6.0 * sweep.friction_nm[0]


def test_friction_falls_from_cold_to_warm_at_every_speed() -> None:
    speeds = np.array([0.001, 0.01, 0.1])
    table = np.array(
        [sliding_sweep(warm_antenna(degc), "outer", degc, speeds).friction_nm for degc in TEMPERATURES_DEGC]
    )
    assert np.all(np.diff(table, axis=0) < 0.0)
    # cold grease: the viscous rise begins below 0.1 rad/s; warm: the curve still falls there
    assert table[0, 2] > table[0, 1] and table[-1, 2] < table[-1, 1]
