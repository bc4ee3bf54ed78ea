"""Columns that were smoothed to both sides before they were saved: told, and their numbers hold the truth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from gimbal_hil.knowledge.identification import Determination, RigidAxisFit, fit_rigid_axis
from gimbal_hil.knowledge.identification.axis_motion import regression_rule
from gimbal_hil.knowledge.identification.smoothed_log import SmoothedColumn
from tests.cases.joint import BENCH, TRUE, JointLog, swinging
from tests.identification.one_axis_rig import Rig, apply_torque, reversing_multisine
from tests.parts import heavy_but

LOG = swinging()


def both_ways(values: np.ndarray, hertz: float, order: int = 2) -> np.ndarray:
    return np.asarray(filtfilt(*butter(order, hertz / (0.5 * BENCH.rate_hz)), values))


def mean_of(values: np.ndarray, rows: int) -> np.ndarray:
    beside = rows // 2
    return np.convolve(np.pad(values, beside, mode="edge"), np.full(rows, 1.0 / rows), "valid")


def fitted(log: JointLog) -> RigidAxisFit:
    return fit_rigid_axis(log.time, log.position, log.torque, regression_rule(1.0 / BENCH.rate_hz))


def hold_the_truth(fit: RigidAxisFit) -> None:
    for one in fit.estimates:
        room = 1e-3 * max(TRUE[one.name], TRUE["coulomb"])
        assert one.interval.low - room <= TRUE[one.name] <= one.interval.high + room, (one.name, one.interval)


#: what was done before the log was saved, and to what
SMOOTHED: dict[str, tuple[SmoothedColumn, Callable[[], JointLog]]] = {
    "torque, second order": (SmoothedColumn.TORQUE, lambda: LOG.but(torque=both_ways(LOG.torque, 5.0))),
    "torque, first order": (SmoothedColumn.TORQUE, lambda: LOG.but(torque=both_ways(LOG.torque, 5.0, 1))),
    "torque, mean of 51 rows": (SmoothedColumn.TORQUE, lambda: LOG.but(torque=mean_of(LOG.torque, 51))),
    "both": (
        SmoothedColumn.BOTH,
        lambda: LOG.but(torque=both_ways(LOG.torque, 5.0), position=both_ways(LOG.position, 5.0)),
    ),
}


def test_a_joint_that_goes_one_way_only_is_not_taken_for_smoothed_where_only_its_encoder_is_coarse() -> None:
    """Slow sines about a steady speed say nothing above them but the rounding of the position, which a filter takes."""
    time, fine = np.arange(8000) / 500.0, (np.arange(80_000) + 0.5) / 5000.0

    def rate(t: np.ndarray, by: int = 0) -> np.ndarray:
        w = 2.0 * np.pi * np.array([[0.9], [1.7], [2.2]])
        turned = w * t + np.array([[0.3], [1.9], [4.0]])
        part = (-np.cos(turned) / w, np.sin(turned), w * np.cos(turned))[by + 1]
        return np.asarray((2.0 * t if by < 0 else 2.0 * (by == 0)) + 2.0 * (np.array([0.2, 0.3, 0.25]) @ part))

    asked = BENCH.inertia * rate(fine, 1) + BENCH.coulomb + BENCH.viscous * rate(fine)
    position = np.round(rate(time, -1) / BENCH.step) * BENCH.step
    log = JointLog(time, asked.reshape(-1, 10).mean(axis=1), position, rate(time))
    fit = fitted(log)
    assert not fit.smoothed
    inertia = next(one for one in fit.estimates if one.name == "inertia")
    assert inertia.verdict is Determination.IDENTIFIED and inertia.interval.covers(BENCH.inertia)


@pytest.mark.parametrize("case", heavy_but(("torque, second order",), SMOOTHED))
def test_a_smoothed_column_is_told_and_its_numbers_hold_the_truth(case: str) -> None:
    which, log = SMOOTHED[case]
    fit = fitted(log())
    assert fit.smoothed[0].which is which
    assert "smoothed" in fit.smoothed[0].finding("joint").text
    hold_the_truth(fit)


def test_beside_cogging_it_is_told_too() -> None:
    log = swinging(cogging=0.02)
    fit = fitted(log.but(torque=both_ways(log.torque, 5.0)))
    assert fit.smoothed[0].which is SmoothedColumn.TORQUE and len(fit.ripples) == 1
    hold_the_truth(fit)


#: what is no smoothing
SOUND: dict[str, Callable[[], JointLog]] = {
    "as logged": lambda: LOG,
    "late": lambda: LOG.but(torque=np.roll(LOG.torque, 5)),
    "noisy": lambda: LOG.but(torque=LOG.torque + np.random.default_rng(5).normal(0.0, 0.05, len(LOG.torque))),
    "a spring": lambda: LOG.but(torque=LOG.torque + 0.1 * LOG.position),
    "asymmetric friction": lambda: LOG.but(torque=LOG.torque + 0.02 * (LOG.rate > 0.0)),
    "drag": lambda: LOG.but(torque=LOG.torque + 0.004 * LOG.rate * np.abs(LOG.rate)),
}


@pytest.mark.parametrize("case", SOUND)
def test_a_log_that_was_not_smoothed_is_not_said_to_be(case: str) -> None:
    assert fitted(SOUND[case]()).smoothed == ()


def test_bristles_round_no_reversal_so_that_it_looks_smoothed() -> None:
    found = apply_torque(Rig(), reversing_multisine(1.0, 20.0, 1))
    assert fit_rigid_axis(found.time_s, found.position, found.torque, regression_rule(1e-3)).smoothed == ()
