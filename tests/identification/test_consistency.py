"""Contradictions and physical bounds are named."""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.identification import LugreFriction, PreslidingRun, StaticFriction, VelocityPoint, fit_static
from gimbal_hil.knowledge.identification.consistency import (
    BreakAway,
    break_away,
    break_away_findings,
    physical_findings,
    points_at_rest,
    repeatability_findings,
)
from tests.identification.one_axis_rig import ENCODER_STEP, OUTER, Rig, apply_torque, slow_ramp


def _ramp(peak: float, sign: float = 1.0) -> PreslidingRun:
    torque = sign * slow_ramp(peak, 20.0, (0.0, 1.0))
    recorded = apply_torque(Rig(), torque)
    return PreslidingRun("ramp", recorded.time_s, recorded.position, recorded.torque)


def _points(static: StaticFriction, noise: float = 2e-4) -> list[VelocityPoint]:
    rng = np.random.default_rng(1)
    speeds = np.concatenate([-np.geomspace(0.1, 0.001, 25), np.geomspace(0.001, 0.1, 25)])
    torque = np.sign(speeds) * static.torque(np.abs(speeds)) + rng.normal(0.0, noise, 50)
    return [
        VelocityPoint(float(v), float(t), noise, 0.0, 1, (f"{v:.4f}",), 100.0)
        for v, t in zip(speeds, torque, strict=True)
    ]


def test_break_away_of_a_ramp_lies_between_coulomb_and_break_away_torque() -> None:
    found = break_away(_ramp(1.3 * OUTER.static.breakaway), OUTER.sigma0, ENCODER_STEP)
    assert found is not None
    assert 0.9 * OUTER.static.coulomb < found.torque < 1.02 * OUTER.static.breakaway


def test_break_away_of_two_ramps_and_more_is_a_point_at_rest_of_its_direction() -> None:
    points = _points(OUTER.static)
    found = [BreakAway("a", 0.25), BreakAway("b", 0.27), BreakAway("c", -0.26)]
    (at_rest,) = points_at_rest(found, points)
    assert at_rest.torque == 0.26 and at_rest.rate == 1e-4 and at_rest.labels == ("a", "b")
    assert at_rest.standard_error == np.std([0.25, 0.27], ddof=1) / np.sqrt(2.0)


def test_a_ramp_that_stays_below_break_away_has_none() -> None:
    assert break_away(_ramp(0.6 * OUTER.static.breakaway), OUTER.sigma0, ENCODER_STEP) is None


def test_break_away_below_coulomb_is_a_contradiction_and_agreement_is_none() -> None:
    found = break_away(_ramp(1.3 * OUTER.static.breakaway), OUTER.sigma0, ENCODER_STEP)
    assert found is not None
    agreeing, higher = (
        fit_static(_points(OUTER.static)),
        fit_static(_points(StaticFriction(0.35, 0.34, 0.0054, 0.06, 1.0))),
    )
    assert agreeing is not None and higher is not None
    assert break_away_findings([found], agreeing) == ()
    contradiction = break_away_findings([found], higher)
    assert [finding.rule for finding in contradiction] == ["break_away_below_coulomb"]
    assert "not" not in contradiction[0].rule and "contradict" in contradiction[0].text


def test_runs_that_do_not_repeat_are_named() -> None:
    points = _points(OUTER.static)
    points[30] = VelocityPoint(points[30].rate, 1.3 * points[30].torque, 2e-4, 0.0, 1, ("odd",), 100.0)
    rules = {finding.rule for finding in repeatability_findings(points)}
    assert rules == {"not_repeatable"}
    assert repeatability_findings(_points(OUTER.static)) == ()


def test_the_thesis_numbers_are_not_passive_and_a_smaller_damping_is() -> None:
    assert [f.rule for f in physical_findings(OUTER)] == ["not_passive"]
    calm = LugreFriction(OUTER.static, OUTER.sigma0, 0.9 * OUTER.static.largest_sigma1())
    assert physical_findings(calm) == ()


def test_break_away_below_coulomb_in_the_fitted_curve_is_named() -> None:
    upside_down = LugreFriction(StaticFriction(0.2, 0.24, 0.005, 0.06, 1.0), 200.0, 1.0)
    assert [f.rule for f in physical_findings(upside_down)] == ["breakaway_below_coulomb_in_fit"]
