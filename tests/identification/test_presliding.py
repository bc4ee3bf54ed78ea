"""Bristle stiffness from slow torque: the exact curve, loops, encoder limits."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.knowledge.identification import Determination, PreslidingRun, fit_presliding
from gimbal_hil.knowledge.identification.presliding import presliding_path
from tests.identification.one_axis_rig import ENCODER_STEP, OUTER, Rig, apply_torque, slow_ramp

TS, SIGMA0 = OUTER.static.breakaway, OUTER.sigma0


def _run(share: float = 0.8, rig: Rig | None = None, seconds: float = 30.0) -> PreslidingRun:
    recorded = apply_torque(rig or Rig(), slow_ramp(share * TS, seconds))
    return PreslidingRun("ramp", recorded.time_s, recorded.position, recorded.torque)


def test_the_curve_from_rest_is_the_logarithm_of_the_errata() -> None:
    torque = np.linspace(0.0, 0.98 * TS, 50)
    assert presliding_path(torque, SIGMA0, TS) == pytest.approx(-(TS / SIGMA0) * np.log(1.0 - torque / TS), rel=1e-9)


@pytest.mark.parametrize(("share", "ratio"), [(0.1, 0.95), (0.9, 0.39), (0.98, 0.25)])
def test_the_secant_is_wrong_by_what_the_errata_say(share: float, ratio: float) -> None:
    secant = share * TS / presliding_path(np.array([0.0, share * TS]), SIGMA0, TS)[-1]
    assert secant / SIGMA0 == pytest.approx(ratio, abs=0.006)


def test_a_closed_loop_of_torque_does_not_return_to_where_it_began() -> None:
    path = presliding_path(
        np.concatenate([np.linspace(0.0, 0.5 * TS, 100), np.linspace(0.5 * TS, 0.0, 100)]), SIGMA0, TS
    )
    assert 0.0 < path[-1] < path.max()


def test_stiffness_is_found_from_ramps_and_loops_where_the_secant_is_not() -> None:
    fit = fit_presliding([_run()], TS, ENCODER_STEP, prior_sigma0=100.0, sigma1=OUTER.sigma1, curve=OUTER.static)
    assert fit is not None
    assert fit.sigma0.verdict is Determination.IDENTIFIED
    assert fit.sigma0.fitted == pytest.approx(SIGMA0, rel=0.03)
    assert fit.sigma0.interval.covers(SIGMA0)
    assert fit.breakaway.fitted == pytest.approx(TS, rel=0.05)
    assert abs(fit.secant / SIGMA0 - 1.0) > 0.1


def test_without_its_damping_known_the_stiffness_is_still_right_for_slow_torque() -> None:
    fit = fit_presliding([_run(0.6, seconds=60.0)], TS, ENCODER_STEP)
    assert fit is not None
    assert fit.sigma0.fitted == pytest.approx(SIGMA0, rel=0.03)


def test_too_little_travel_for_the_encoder_withholds_the_stiffness_and_keeps_the_prior() -> None:
    coarse = Rig(encoder_step=1e-3)
    fit = fit_presliding([_run(0.5, coarse)], TS, coarse.encoder_step, prior_sigma0=123.0)
    assert fit is not None
    assert fit.sigma0.verdict is Determination.NOT_IDENTIFIED
    assert fit.sigma0.value == 123.0
    assert "encoder steps" in fit.sigma0.reason


def test_rows_near_and_beyond_break_away_are_not_used() -> None:
    fit = fit_presliding([_run(1.4, seconds=20.0)], TS, ENCODER_STEP, sigma1=OUTER.sigma1)
    assert fit is not None
    assert float(np.max(np.abs(fit.runs[0].friction))) <= 0.9 * TS
    assert fit.sigma0.fitted == pytest.approx(SIGMA0, rel=0.05)


def test_a_run_without_torque_gives_no_fit() -> None:
    still = PreslidingRun("still", np.arange(100) * 1e-3, np.zeros(100), np.zeros(100))
    assert fit_presliding([still], TS, ENCODER_STEP) is None


def test_an_unknown_damping_widens_the_interval_until_it_holds_the_truth() -> None:
    wrong = 0.6 * OUTER.sigma1
    sure = fit_presliding([_run(seconds=15.0)], TS, ENCODER_STEP, sigma1=wrong, curve=OUTER.static)
    unsure = fit_presliding(
        [_run(seconds=15.0)], TS, ENCODER_STEP, sigma1=wrong, sigma1_is_known=False, curve=OUTER.static
    )
    assert sure is not None and unsure is not None
    assert not sure.sigma0.interval.covers(SIGMA0)
    assert unsure.sigma0.interval.covers(SIGMA0)
