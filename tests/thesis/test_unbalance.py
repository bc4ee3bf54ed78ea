"""Chapter 3: which of its claims hold, and which are artefacts of a slip."""

from __future__ import annotations

import pytest

from gimbal_hil.proof.thesis.unbalance import Unbalance, UnbalanceRun, claims, run_all_cases, run_unbalance
from sim_backend.thesis_slips import Slip


@pytest.fixture(scope="module")
def runs() -> dict[tuple[Unbalance, str, float, int], UnbalanceRun]:
    return {(r.unbalance, r.axis, r.reference_rad_s, r.case): r for r in run_all_cases()}


Runs = dict[tuple[Unbalance, str, float, int], UnbalanceRun]


def test_every_case_of_both_tables_is_run_on_both_axes_at_both_references(runs: Runs) -> None:
    assert len(runs) == 2 * 2 * (5 + 5 + 4)


@pytest.mark.parametrize("axis", ["outer", "inner"])
@pytest.mark.parametrize("reference", [0.1, 0.5])
def test_dynamic_cases_3_to_5_oscillate_and_case_1_does_not(axis: str, reference: float, runs: Runs) -> None:
    still = runs[Unbalance.DYNAMIC, axis, reference, 1].ripple_percent
    for case in (3, 4, 5):
        moving = runs[Unbalance.DYNAMIC, axis, reference, case]
        assert moving.ripple_percent > 100.0 * still
        # bounded and forced: not unstable
        assert 0.5 < moving.growth < 2.0


@pytest.mark.parametrize("axis", ["outer", "inner"])
@pytest.mark.parametrize("case", [3, 4, 5])
def test_the_relative_swing_is_smaller_at_the_higher_reference(axis: str, case: int, runs: Runs) -> None:
    assert (
        runs[Unbalance.DYNAMIC, axis, 0.5, case].ripple_percent
        < runs[Unbalance.DYNAMIC, axis, 0.1, case].ripple_percent
    )


def peak(runs: Runs, unbalance: Unbalance, axis: str) -> float:
    return max(run.torque_peak_nm for run in runs.values() if run.unbalance is unbalance and run.axis == axis)


def test_static_outweighs_dynamic_unbalance_on_both_axes(runs: Runs) -> None:
    # the thesis has it the other way round on the inner gimbal
    assert peak(runs, Unbalance.STATIC, "outer") == pytest.approx(10.3, abs=0.2)
    assert peak(runs, Unbalance.DYNAMIC, "outer") == pytest.approx(0.21, abs=0.02)
    assert peak(runs, Unbalance.STATIC, "inner") == pytest.approx(1.11, abs=0.01)
    assert peak(runs, Unbalance.DYNAMIC, "inner") == pytest.approx(0.046, abs=0.005)


def test_a_balanced_gimbal_swings_on_a_moving_base_too(runs: Runs) -> None:
    # (I_xx - I_zz) w_x w_z is no unbalance: switching the products of inertia off must keep it
    for case in (3, 4, 5):
        balanced = runs[Unbalance.NONE, "inner", 0.1, case].ripple_percent
        assert balanced == pytest.approx(runs[Unbalance.DYNAMIC, "inner", 0.1, case].ripple_percent, rel=0.05)


def test_a_level_outer_gimbal_has_no_gravity_torque_unless_eq_3_10_is_taken_as_printed(runs: Runs) -> None:
    printed = run_unbalance(Unbalance.STATIC, "outer", 0.1, 1, Slip.GRAVITY_ROW)
    assert runs[Unbalance.STATIC, "outer", 0.1, 1].torque_peak_nm < 1e-3
    assert printed.torque_peak_nm == pytest.approx((14.63 + 5.08) * 9.81 * 0.06356, rel=1e-3)


def test_the_claims_are_judged_as_errata_judges_them(runs: Runs) -> None:
    printed = run_unbalance(Unbalance.STATIC, "outer", 0.1, 1, Slip.GRAVITY_ROW)
    judged = [claim.holds for claim in claims(tuple(runs.values()), printed)]
    assert judged == [True, True, False, True, False, False, False]
