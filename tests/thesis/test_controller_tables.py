"""The controller tables of chapter 5, run again: one configuration carries every table that can be carried."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from gimbal_hil.loop.control import Mode
from gimbal_hil.proof.thesis.closed_loop import AxisLoop, Gains, run_closed_loop
from gimbal_hil.proof.thesis.controller_tables import REGRESSION_BOUND, Agreement, TableResult, run_table, step_figures
from gimbal_hil.proof.thesis.inferred import LEVEL, STEP_TIME_S, TILTED, Configuration
from gimbal_hil.proof.thesis.printed import GAIN_TABLES, PREFILTER_TABLES, Loop, StepTable
from sim_backend.model import AntennaModel

TABLES = {table.number: table for table in GAIN_TABLES + PREFILTER_TABLES}


@pytest.fixture(scope="module")
def results() -> dict[str, TableResult]:
    return {number: run_table(table, TILTED) for number, table in TABLES.items()}


@pytest.mark.parametrize("number", REGRESSION_BOUND)
def test_a_table_is_met_row_by_row_within_its_rms(number: str, results: dict[str, TableResult]) -> None:
    accepted = REGRESSION_BOUND[number]
    assert results[number].overshoot_rms <= accepted.overshoot_points
    if accepted.settling_s is not None:
        assert results[number].settling_rms_s <= accepted.settling_s


def test_ki_raises_the_overshoot_where_table_5_1_says_it_lowers_it(results: dict[str, TableResult]) -> None:
    for number in ("5.3", "5.5", "5.7", "5.9"):
        assert np.all(np.diff([row.overshoot_percent for row in results[number].rows]) > 0.0)
        assert np.all(np.diff([row.printed.overshoot_percent for row in results[number].rows]) > 0.0)


def test_overshoot_times_kp_is_nearly_constant_as_a_saturated_integrator_makes_it(
    results: dict[str, TableResult],
) -> None:
    products = [row.printed.swept * row.overshoot_percent for row in results["5.2"].rows]
    printed = [row.printed.swept * row.printed.overshoot_percent for row in results["5.2"].rows]
    assert np.ptp(products[1:]) < 0.15 * np.mean(products) and np.ptp(printed[1:]) < 0.15 * np.mean(printed)


def test_the_two_odd_rows_of_table_5_6_need_the_tilted_base(results: dict[str, TableResult]) -> None:
    odd = results["5.6"].rows[-2:]
    level = run_table(TABLES["5.6"], LEVEL).rows[-2:]
    for tilted, flat in zip(odd, level, strict=True):
        assert abs(tilted.overshoot_percent - tilted.printed.overshoot_percent) < 0.6
        assert abs(flat.overshoot_percent - flat.printed.overshoot_percent) > 1.0


def test_the_settling_of_table_5_6_at_kp_5_hangs_on_the_band(results: dict[str, TableResult]) -> None:
    row, response = results["5.6"].rows[0], results["5.6"].responses[0]
    late = response.position_rad[response.time_s > row.settling_s, 0]
    assert 0.98 < late.min() < 0.984
    assert row.printed.settling_s - row.settling_s > 0.5


@pytest.mark.parametrize("number", ["5.13", "5.14", "5.15"])
def test_tables_that_cannot_be_reproduced_say_so_with_a_reason(number: str, results: dict[str, TableResult]) -> None:
    assert results[number].agreement is Agreement.NOT_REPRODUCIBLE
    assert results[number].reason


def test_a_faster_settling_than_printed_keeps_table_5_12_to_its_overshoots(results: dict[str, TableResult]) -> None:
    assert results["5.12"].agreement is Agreement.OVERSHOOT_ONLY
    assert all(row.settling_s < row.printed.settling_s - 0.3 for row in results["5.12"].rows)


def test_anti_windup_removes_the_published_overshoot() -> None:
    table = StepTable("5.2", TABLES["5.2"].loop, "outer", "Kp", None, 300.0, TABLES["5.2"].rows[:1])
    published = run_table(table, LEVEL).rows[0].overshoot_percent
    reference = np.zeros((20000, 2))
    reference[2000:, 0] = 1.0
    outer = AxisLoop(Mode.RATE, Gains(20.0, 300.0), torque_per_unit_nm=2.5, torque_limit_nm=15.5, anti_windup=True)
    inner = AxisLoop(Mode.RATE, Gains(35.0, 250.0), torque_per_unit_nm=2.1, torque_limit_nm=6.6)
    response = run_closed_loop(LEVEL.antenna(), outer, inner, reference)
    overshoot, _ = step_figures(response.time_s, response.rate_rad_s[:, 0], 1.0)
    assert published > 19.0 and overshoot < 3.0


def test_the_loop_is_very_sensitive_to_gyro_lag() -> None:
    model = LEVEL.antenna()
    reference = np.zeros((20000, 2))
    reference[2000:, 0] = 1.0
    outer = AxisLoop(Mode.RATE, Gains(140.0, 300.0), torque_per_unit_nm=2.5, torque_limit_nm=15.5)
    inner = AxisLoop(Mode.RATE, Gains(35.0, 250.0), torque_per_unit_nm=2.1, torque_limit_nm=6.6)
    overshoot = []
    for bandwidth in (0.0, 600.0):
        response = run_closed_loop(model.with_number("outer", "gyro.bandwidth", bandwidth), outer, inner, reference)
        overshoot.append(step_figures(response.time_s, response.rate_rad_s[:, 0], 1.0)[0])
    assert overshoot[0] == pytest.approx(3.57, abs=0.05)
    assert overshoot[1] > 8.0


def test_step_figures_measure_overshoot_and_the_two_percent_band_from_the_first_sample() -> None:
    time = np.arange(0.0, 5.0, 1e-3)
    signal = 2.0 * (1.0 - np.exp(-time) * np.cos(4.0 * time))
    overshoot, settling = step_figures(time, signal, 2.0)
    assert overshoot == pytest.approx(100.0 * np.max(signal / 2.0 - 1.0))
    assert np.all(np.abs(signal[time >= settling] - 2.0) <= 0.04)
    assert abs(signal[np.searchsorted(time, settling) - 1] - 2.0) > 0.04
    assert step_figures(time, np.zeros_like(time), 1.0) == (0.0, math.inf)


@dataclass(frozen=True)
class SlowGyro(Configuration):
    """The tilted configuration with lag in the inner gyro."""

    def antenna(self) -> AntennaModel:
        return super().antenna().with_number("inner", "gyro.bandwidth", 178.0)


def test_a_slow_gyro_explains_table_5_13_and_ruins_the_rate_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    slow = SlowGyro("slow gyro", TILTED.outer, TILTED.inner, TILTED.roll_rad, TILTED.pitch_rad)
    assert run_table(TABLES["5.4"], slow).overshoot_rms > 30.0
    assert run_table(TABLES["5.5"], slow).overshoot_rms > 30.0
    monkeypatch.setitem(STEP_TIME_S, (Loop.POSITION, "inner"), 0.06)
    hunting = run_table(TABLES["5.13"], slow)
    assert hunting.overshoot_rms < 0.15 and hunting.settling_rms_s < 0.06
