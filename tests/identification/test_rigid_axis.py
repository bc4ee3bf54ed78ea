"""Linear regression of a single axis."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.identification import RigidAxisRule, fit_rigid_axis

TIME = np.arange(20_000) * 1e-3
TRUE = {"inertia": 0.5, "viscous": 0.8, "coulomb": 0.3, "offset": -0.05}


def _axis(noise: float = 0.0, seed: int = 0, up: float = 1.0, down: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Position, and the held torque whose mean over each sample the motion needs."""
    fine = np.arange(20_000 * 10 + 1) * 1e-4
    position = 0.6 * np.sin(1.3 * fine) + 0.25 * np.sin(3.7 * fine)
    rate = np.gradient(position, 1e-4)
    friction = TRUE["coulomb"] * np.sign(rate) + TRUE["viscous"] * rate
    need = TRUE["inertia"] * np.gradient(rate, 1e-4) + friction * np.where(rate > 0.0, up, down) + TRUE["offset"]
    held = need[:-1].reshape(-1, 10).mean(axis=1)
    return position[:-1:10], held + noise * np.random.default_rng(seed).standard_normal(len(held))


def test_all_four_numbers_are_found_without_noise() -> None:
    position, torque = _axis()
    fit = fit_rigid_axis(TIME, position, torque, RigidAxisRule(20.0))
    for name, value in TRUE.items():
        assert fit.value(name) == pytest.approx(value, rel=0.02), name


@pytest.mark.parametrize("rows", [-3, 0, 1, 5, 20])
def test_torque_that_is_rows_late_is_told_and_changes_no_number(rows: int) -> None:
    position, torque = _axis(0.01)
    fit = fit_rigid_axis(TIME, position, np.roll(torque, rows), RigidAxisRule(20.0))
    assert fit.timing.late.low - 2e-5 <= rows * 1e-3 <= fit.timing.late.high + 2e-5
    assert fit.timing.excludes_zero is (rows != 0) and fit.timing.lag_s == 0.0
    for name, value in TRUE.items():
        assert fit.value(name) == pytest.approx(value, rel=0.02), name


def test_torque_behind_a_low_pass_gives_the_numbers_of_the_torque_before_it() -> None:
    position, torque = _axis(0.01)
    lag = 1.0 / (2.0 * np.pi * 20.0)
    decay = np.exp(-1e-3 / lag)
    fit = fit_rigid_axis(TIME, position, lfilter([1.0 - decay], [1.0, -decay], torque), RigidAxisRule(20.0))
    assert fit.timing.lag_s == pytest.approx(lag, rel=0.1)
    for name, value in TRUE.items():
        assert fit.value(name) == pytest.approx(value, rel=0.02), name


def test_without_inertia_torque_a_shift_is_not_made_up_from_one_sine() -> None:
    """One sine cannot tell a shift from viscosity: the interval must say so, unless the time is stated."""
    fine = np.arange(20_000 * 10 + 1) * 1e-4
    position = 0.6 * np.sin(1.3 * fine)
    need = 0.5 * -0.6 * 1.3**2 * np.sin(1.3 * fine) + 0.8 * 0.6 * 1.3 * np.cos(1.3 * fine)
    torque = need[:-1].reshape(-1, 10).mean(axis=1) + 0.01 * np.random.default_rng(1).standard_normal(20_000)
    for stated in (False, True):
        fit = fit_rigid_axis(TIME, position[:-1:10], torque, RigidAxisRule(20.0, time_stated=stated))
        viscous = next(e for e in fit.estimates if e.name == "viscous")
        width = viscous.interval.half_width / viscous.fitted
        assert viscous.interval.covers(0.8) and (width < 0.01) is stated, (stated, viscous)


@pytest.mark.heavy
def test_bootstrap_intervals_cover_the_truth_in_at_least_nine_of_ten_repeats() -> None:
    covered = 0
    for seed in range(40):
        position, torque = _axis(0.05, seed)
        fit = fit_rigid_axis(TIME, position, torque, RigidAxisRule(20.0), seed=seed)
        covered += sum(
            next(e for e in fit.estimates if e.name == name).interval.covers(value) for name, value in TRUE.items()
        )
    assert covered / 160 >= 0.88


def test_directions_are_told_apart() -> None:
    position, torque = _axis(up=1.2, down=0.8)
    fit = fit_rigid_axis(TIME, position, torque, RigidAxisRule(20.0, per_direction=True))
    assert fit.value("viscous_positive") == pytest.approx(1.2 * TRUE["viscous"], rel=0.05)
    assert fit.value("viscous_negative") == pytest.approx(0.8 * TRUE["viscous"], rel=0.05)
    assert fit.value("coulomb_positive") - fit.value("coulomb_negative") == pytest.approx(
        0.4 * TRUE["coulomb"] + 2 * TRUE["offset"], abs=0.02
    )


def test_an_axis_that_does_not_move_is_refused() -> None:
    with pytest.raises(BadInputError, match="moving axis"):
        fit_rigid_axis(TIME, np.zeros(len(TIME)), np.ones(len(TIME)), RigidAxisRule(20.0))


@pytest.mark.parametrize("order", [9.0, 23.4])
def test_cogging_is_counted_apart_and_widens_no_interval(order: float) -> None:
    position, torque = _axis(0.01)
    # held from row to row, as the torque is
    middle = 0.5 * (position + np.append(position[1:], position[-1]))
    cogs = torque + 0.3 * np.sin(order * middle + 0.4)
    without, fit = (fit_rigid_axis(TIME, position, one, RigidAxisRule(20.0)) for one in (torque, cogs))
    assert without.ripples == () and len(fit.ripples) == 1
    (ripple,) = fit.ripples
    assert ripple.order == pytest.approx(order, rel=0.01) and ripple.amplitude == pytest.approx(0.3, rel=0.05)
    assert f"{ripple.order:.4g} times a turn" in ripple.finding("arm", False).text
    for estimate, plain in zip(fit.estimates, without.estimates, strict=True):
        assert estimate.interval.half_width < 4.0 * plain.interval.half_width, estimate.name
        assert estimate.interval.low - 1e-3 <= TRUE[estimate.name] <= estimate.interval.high + 1e-3, estimate.name
    assert not fit.timing.excludes_zero and fit.timing.late.half_width < 2.0 * without.timing.late.half_width


def test_a_spring_is_no_ripple_and_in_no_number() -> None:
    position, torque = _axis(0.01)
    middle = 0.5 * (position + np.append(position[1:], position[-1]))
    fit = fit_rigid_axis(TIME, position, torque + 0.5 * middle, RigidAxisRule(20.0))
    assert [one.finding("arm", False).rule for one in fit.ripples] == ["follows_position"]
    for name in ("inertia", "viscous", "coulomb"):
        assert fit.value(name) == pytest.approx(TRUE[name], rel=0.02), name
