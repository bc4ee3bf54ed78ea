"""Regressions of logs whose columns leave open how they came about, or hold more than inertia and friction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, lfilter, medfilt

from gimbal_hil.knowledge.identification import RigidAxisFit, RigidAxisRule, fit_rigid_axis
from gimbal_hil.knowledge.identification.estimate import Determination
from tests.cases.joint import BENCH, TRUE, Floats
from tests.parts import heavy_but

LOGS = [BENCH.log(which, 16.0, seed=seed) for which, seed in (("a", 1), ("b", 2))]
NUMBERS = ("inertia", "viscous", "coulomb")


def fitted(log_number: int, torque: Floats, position: Floats | None = None) -> RigidAxisFit:
    log = LOGS[log_number]
    return fit_rigid_axis(log.time, log.position if position is None else position, torque, RigidAxisRule(20.0))


def holds_the_truth(fit: RigidAxisFit, *names: str) -> None:
    for one in fit.estimates:
        if one.name in names:
            assert one.interval.covers(TRUE[one.name]), one


def said(fit: RigidAxisFit) -> list[str]:
    return [one.rule for one in fit.warnings]


@pytest.mark.parametrize("k", heavy_but((0,), (0, 1)))
@pytest.mark.parametrize("rows", [5, 10, 6.85], ids=["5", "10", "not whole"])
def test_a_torque_that_was_read_every_few_rows_leaves_intervals_that_hold_the_truth(k: int, rows: float) -> None:
    torque, places = LOGS[k].torque, np.arange(len(LOGS[k].torque))
    sampled = np.append(torque[:1], 0.5 * (torque[1:] + torque[:-1]))
    at = np.ceil(np.floor(places / rows + 1e-9) * rows - 1e-9).astype(int)
    holds_the_truth(fitted(k, sampled[at]), *NUMBERS)


def test_a_torque_that_is_held_for_the_rows_that_it_is_the_mean_of_leaves_intervals_that_hold_the_truth() -> None:
    torque = BENCH.log("a", 16.0, cogging=0.05).torque
    holds_the_truth(fitted(0, torque.reshape(-1, 5).mean(axis=1).repeat(5)), *NUMBERS)


def test_a_torque_that_is_late_and_behind_a_low_pass_leaves_intervals_that_hold_the_truth() -> None:
    torque = lfilter(*butter(1, 40.0 / 250.0), BENCH.log("a", 16.0, cogging=0.05).torque)
    holds_the_truth(fitted(0, np.concatenate((torque[:1], torque[:1], torque[:-2]))), *NUMBERS)


@pytest.mark.parametrize("k", heavy_but((0,), (0, 1)))
@pytest.mark.parametrize("hertz", [15.0, 30.0, 60.0])
def test_a_position_behind_a_low_pass_leaves_intervals_that_hold_the_truth(k: int, hertz: float) -> None:
    position = lfilter(*butter(1, hertz / 250.0), LOGS[k].position)
    fit = fitted(k, LOGS[k].torque, position)
    assert fit.timing.late.high < 0.0
    holds_the_truth(fit, *NUMBERS)


SHORT = replace(BENCH, rate_hz=200.0)


def of_short(torque: Floats, which: str = "a") -> RigidAxisFit:
    log = SHORT.log(which, 10.0)
    return fit_rigid_axis(log.time, log.position, torque, RigidAxisRule(10.0))


@pytest.mark.parametrize("which", heavy_but(("a",), ("a", "b")))
def test_a_torque_that_was_cut_off_to_whole_steps_is_told_and_half_a_step_added(which: str) -> None:
    torque = SHORT.log(which, 10.0).torque
    step = float(np.max(np.abs(torque))) / 20.0
    fit = of_short(np.trunc(torque / step) * step, which)
    assert said(fit) == ["torque_cut_off"]
    assert fit.value("inertia") == pytest.approx(TRUE["inertia"], rel=0.005)
    rounded = of_short(np.round(torque / step) * step, which)
    assert not said(rounded) and rounded.value("inertia") == pytest.approx(TRUE["inertia"], rel=0.005)


@pytest.mark.parametrize("lost", heavy_but((0.0,), (0.0, 1.0)), ids=["not written", "taken off the others too"])
def test_a_band_without_torque_is_told_and_its_zeros_say_no_more_than_that_they_are_within(lost: float) -> None:
    torque, band = SHORT.log("a", 10.0).torque, 1.3 * BENCH.coulomb
    left = np.sign(torque) * np.maximum(np.abs(torque) - lost * band, 0.0)
    fit = of_short(np.where(np.abs(torque) < band, 0.0, left))
    assert said(fit) == ["torque_dead_band"]
    holds_the_truth(fit, *NUMBERS)
    assert fit.value("inertia") == pytest.approx(TRUE["inertia"], rel=0.005)


def test_a_median_of_the_torque_is_told_and_nothing_narrow_is_wrong() -> None:
    torque = SHORT.log("a", 10.0).torque
    fit = of_short(medfilt(torque, 15))
    assert said(fit) == ["torque_median"] and not said(of_short(torque))
    assert all(one.verdict is Determination.NOT_IDENTIFIED for one in fit.estimates)
    holds_the_truth(of_short(medfilt(torque, 5)), *NUMBERS)


@pytest.mark.parametrize("to_step", heavy_but((np.floor,), (np.round, np.trunc, np.floor)))
def test_a_torque_of_very_few_steps_leaves_intervals_that_hold_the_truth(to_step: Callable[[Floats], Floats]) -> None:
    torque = SHORT.log("a", 10.0).torque
    step = float(np.max(np.abs(torque))) / 5.0
    fit = of_short(step * to_step(torque / step))
    holds_the_truth(fit, *NUMBERS, "offset")


def test_a_joint_that_coasts_has_no_band_without_torque() -> None:
    """Zeros that the motion agrees with are torques like others."""
    log, on = SHORT.log("a", 10.0), np.arange(2000) % 400 < 300
    torque = np.where(on, 0.4 * np.sin(9.0 * log.time) + 0.1, 0.0)
    position, rate = np.zeros(2000), 0.0
    for k in range(1999):
        for _ in range(20):
            rest = torque[k] - BENCH.viscous * rate
            pushed = (
                rest - BENCH.coulomb * np.sign(rate or rest) if abs(rate) > 1e-4 or abs(rest) > BENCH.coulomb else 0.0
            )
            after = rate + 2.5e-4 * pushed / BENCH.inertia
            rate = 0.0 if after * rate < 0.0 or pushed == 0.0 else after
            position[k + 1] += 2.5e-4 * rate
        position[k + 1] += position[k]
    fit = fit_rigid_axis(log.time, position, torque, RigidAxisRule(10.0))
    assert not said(fit) and fit.value("coulomb") == pytest.approx(TRUE["coulomb"], rel=0.005)


@pytest.mark.parametrize("share", heavy_but((0.01,), (0.002, 0.01)))
def test_two_clocks_are_told_and_nothing_narrow_is_wrong(share: float) -> None:
    log = LOGS[0]
    fit = fitted(0, np.interp(log.time * (1.0 + share), log.time, log.torque))
    assert "two_clocks" in said(fit)
    for one in fit.estimates:
        if one.name in NUMBERS and one.verdict is Determination.IDENTIFIED:
            assert one.interval.covers(TRUE[one.name]), one
    assert not said(fitted(0, log.torque))


def test_a_position_that_loses_counts_one_way_asks_for_two_inertias() -> None:
    steps = np.diff(LOGS[0].position, prepend=LOGS[0].position[:1])
    fit = fitted(0, LOGS[0].torque, np.cumsum(np.where(steps > 0.0, 0.85 * steps, steps)))
    assert fit.parts is not None and "inertia of" in fit.parts.finding("joint").text


@pytest.mark.parametrize("k", heavy_but((0,), (0, 1)))
@pytest.mark.parametrize("what", ["weight", "spring"])
def test_a_weight_or_a_spring_that_nobody_knows_of_is_told_and_is_in_no_number(k: int, what: str) -> None:
    q = LOGS[k].position
    held = np.append(q, q[-1:])
    more = 0.1 * np.sin(held + 0.3) if what == "weight" else 0.03 * held
    fit = fitted(k, LOGS[k].torque + 0.5 * (more[1:] + more[:-1]))
    holds_the_truth(fit, *NUMBERS)
    found = [one.finding("joint", False) for one in fit.ripples]
    assert [one.rule for one in found] == ["follows_position"] and "a weight or a spring" in found[0].text
    offset = next(one for one in fit.estimates if one.name == "offset")
    assert offset.verdict is Determination.NOT_IDENTIFIED and "follows position" in offset.reason
    assert all(one.verdict is Determination.IDENTIFIED for one in fit.estimates if one.name in NUMBERS)


def test_without_a_weight_or_a_spring_none_is_told() -> None:
    for k, log in enumerate(LOGS):
        assert fitted(k, log.torque).ripples == ()
