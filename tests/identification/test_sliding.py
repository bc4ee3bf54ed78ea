"""Static friction from velocity maps with hidden truth."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.identification import Determination, MapHalf, StaticFriction, VelocityPoint, fit_static
from tests.identification.one_axis_rig import OUTER

TRUE = OUTER.static
SPEEDS = np.geomspace(0.001, 0.1, 45)
NAMES = ("breakaway", "coulomb", "stribeck_velocity", "viscous", "shape")


def _map(
    truth: StaticFriction, noise: float, seed: int, offset: float = 0.0, stated: float | None = None
) -> list[VelocityPoint]:
    rng = np.random.default_rng(seed)
    points = []
    for side in (-1.0, 1.0):
        for speed in SPEEDS:
            torque = side * float(truth.torque(np.array([speed]))[0]) + offset + rng.normal(0.0, noise)
            points.append(VelocityPoint(side * speed, torque, stated or noise, 0.0, 1, (f"{side * speed:.4f}",), 100.0))
    return points


def _truth(name: str, truth: StaticFriction = TRUE) -> float:
    return float(getattr(truth, name))


@pytest.mark.parametrize(("repeats", "least"), [(8, 0.75), pytest.param(40, 0.9, marks=pytest.mark.heavy)])
def test_intervals_cover_the_truth_as_often_as_they_say(repeats: int, least: float) -> None:
    covered = np.zeros(5)
    for seed in range(repeats):
        fit = fit_static(_map(TRUE, 5e-4, seed, offset=0.003))
        assert fit is not None
        covered += [e.interval.covers(_truth(e.name)) for e in fit.estimates]
    assert np.all(covered / repeats >= least), dict(zip(NAMES, covered / repeats, strict=True))


def test_with_half_a_millinewtonmetre_of_noise_the_errata_limits_are_met() -> None:
    fit = fit_static(_map(TRUE, 5e-4, 1))
    assert fit is not None
    found = fit.friction
    assert found.breakaway == pytest.approx(TRUE.breakaway, rel=0.01)
    assert found.coulomb == pytest.approx(TRUE.coulomb, rel=0.005)
    assert found.stribeck_velocity == pytest.approx(TRUE.stribeck_velocity, rel=0.12)
    assert found.viscous == pytest.approx(TRUE.viscous, rel=0.2)
    assert all(e.verdict is not Determination.NOT_IDENTIFIED for e in fit.estimates)


def test_a_constant_torque_of_both_directions_is_offset_and_not_friction() -> None:
    fit = fit_static(_map(TRUE, 2e-4, 3, offset=0.02))
    assert fit is not None
    assert fit.offset == pytest.approx(0.02, abs=2e-4)
    assert fit.friction.coulomb == pytest.approx(TRUE.coulomb, rel=0.005)


def test_a_direction_is_fitted_from_its_own_half_alone() -> None:
    weaker = StaticFriction(0.2, 0.19, 0.0054, 0.05, 1.0)
    points = [p for p in _map(TRUE, 2e-4, 5) if p.rate > 0.0] + [p for p in _map(weaker, 2e-4, 6) if p.rate < 0.0]
    positive, negative = fit_static(points, MapHalf.POSITIVE), fit_static(points, MapHalf.NEGATIVE)
    assert positive is not None and negative is not None
    assert positive.friction.coulomb == pytest.approx(TRUE.coulomb, rel=0.01)
    assert negative.friction.coulomb == pytest.approx(weaker.coulomb, rel=0.01)


def test_without_a_stribeck_bump_its_speed_and_shape_are_not_identified_and_keep_their_prior() -> None:
    flat = StaticFriction(0.24, 0.24, 0.0054, 0.06, 1.0)
    fit = fit_static(_map(flat, 5e-4, 7), prior=TRUE)
    assert fit is not None
    by_name = {e.name: e for e in fit.estimates}
    for name in ("stribeck_velocity", "shape"):
        assert by_name[name].verdict is Determination.NOT_IDENTIFIED
        assert by_name[name].value == _truth(name)
        assert by_name[name].experiment
    assert by_name["coulomb"].verdict is Determination.IDENTIFIED


def test_points_far_off_are_held_down_and_named() -> None:
    points = _map(TRUE, 3e-4, 8)
    bad = points[60]
    points[60] = VelocityPoint(bad.rate, bad.torque + 0.05, bad.standard_error, 0.0, 1, ("the bad one",), 100.0)
    fit = fit_static(points)
    assert fit is not None
    assert "the bad one" in fit.outliers
    assert fit.friction.coulomb == pytest.approx(TRUE.coulomb, rel=0.01)


def test_errors_that_were_stated_too_small_are_widened_by_the_scatter_that_is_seen() -> None:
    honest, boastful = fit_static(_map(TRUE, 5e-4, 9)), fit_static(_map(TRUE, 5e-4, 9, stated=5e-5))
    assert honest is not None and boastful is not None
    width = [fit.estimates[1].interval.high - fit.estimates[1].interval.low for fit in (honest, boastful)]
    assert width[1] > 0.7 * width[0]
    assert boastful.between_runs == pytest.approx(5e-4, rel=0.4)


def test_too_few_points_give_no_fit() -> None:
    assert fit_static(_map(TRUE, 5e-4, 1)[:5]) is None
