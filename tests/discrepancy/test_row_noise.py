"""Rows in creep are worth less than rows in motion, by what the encoder's own error makes of them."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.noise.row_noise import (
    creeps,
    encoder_noise,
    other_readings,
    row_scales,
    seen_step,
    unsaid_squares,
)
from gimbal_hil.knowledge.discrepancy.twin.record import record_of
from gimbal_hil.knowledge.discrepancy.twin.twin import Twin
from sim_backend.model import shipped_model

STEP = 2.0 * np.pi / 2**19
T = np.arange(12000) * 1e-3


def test_the_step_of_the_encoder_is_read_from_the_data() -> None:
    slow = np.round(1e-3 * np.sin(0.5 * T) / STEP) * STEP
    assert seen_step(slow) == pytest.approx(STEP, rel=1e-6)
    assert seen_step(1e-3 * np.sin(0.5 * T)) == 0.0
    assert seen_step(np.zeros(100)) == 0.0


def test_rows_in_creep_are_noisier_than_rows_in_motion() -> None:
    model = shipped_model()
    moving = np.where(T < 6.0, 0.3 * np.sin(2.0 * T), 0.3 * np.sin(12.0) + 2e-4 * np.sin(T - 6.0))
    columns = {f"{axis}.torque": np.sin(T) for axis in model.axes}
    columns |= {f"{axis}.position": np.round(moving / STEP) * STEP for axis in model.axes}
    table = SignalsTable.of(model.axes, T, columns)
    twin = Twin(model, (record_of(table, model, 25.0, "log"),))
    scale = row_scales(twin, (table,), np.array([5e-4, 2e-4]))[0]
    time = twin.records[0].time_s[twin.records[0].keep]
    assert np.all(scale >= 1.0)
    assert np.median(scale[time > 7.0, 0]) > 1.5 * np.median(scale[(time > 1.0) & (time < 5.0), 0])


def test_an_encoder_turned_evenly_by_nearly_whole_steps_a_sample_is_noisier_in_rate_and_torque() -> None:
    model = shipped_model()
    # the rounding error of 64 and a hundredth of a step a sample is a sawtooth of 10 Hz
    even = 64.01 * STEP * np.arange(len(T))
    moving = np.where(T < 6.0, even, even[6000] + 0.3 * np.sin(2.1 * (T - 6.0)) + 0.05 * np.sin(17.0 * (T - 6.0)))
    columns = {f"{axis}.torque": np.sin(T) for axis in model.axes}
    columns |= {f"{axis}.position": np.round(moving / STEP) * STEP for axis in model.axes}
    columns |= {f"{axis}.rate": np.gradient(moving, T) for axis in model.axes}
    table = SignalsTable.of(model.axes, T, columns)
    twin = Twin(model, (record_of(table, model, 25.0, "log"),))
    squares = encoder_noise(twin, (table,))[0]
    time = twin.records[0].time_s[twin.records[0].keep]
    for column in (0, 2):
        assert np.median(squares[(time > 2.0) & (time < 5.0), column]) > 2.0 * np.median(squares[time > 7.0, column])


def test_friction_at_a_reversal_is_uncertain_where_the_model_states_no_bristle() -> None:
    model = shipped_model()
    columns = {f"{axis}.torque": np.sin(T) for axis in model.axes}
    columns |= {f"{axis}.position": 0.3 * np.sin(2.0 * T) for axis in model.axes}
    table = SignalsTable.of(model.axes, T, columns)
    stiff = model.with_number("outer", "friction.sigma0", 0.0)
    with_it, without = (Twin(m, (record_of(table, m, 25.0, "log"),)) for m in (model, stiff))
    assert not np.any(unsaid_squares(with_it, 0))
    uncertain = np.sqrt(unsaid_squares(without, 0)[:, 0])
    time = without.records[0].time_s[without.records[0].keep]
    reversals = np.pi / 4.0 + np.pi / 2.0 * np.arange(8)
    away = np.min(np.abs(time[:, None] - reversals), axis=1)
    level = model.number("outer", "friction.coulomb")
    # the turn takes 20 ms, what the band makes of it five times that
    assert np.all(uncertain[away > 0.15] < 0.02 * level)
    assert np.all(uncertain[away < 0.01] > 0.5 * level)


def test_friction_of_a_joint_that_creeps_is_uncertain_where_the_model_states_no_bristle() -> None:
    model = shipped_model().with_number("outer", "friction.sigma0", 0.0)
    columns = {f"{axis}.torque": np.sin(T) for axis in model.axes}
    columns |= {f"{axis}.position": np.where(T < 6.0, 0.003 * T, 0.018 + 0.03 * (T - 6.0)) for axis in model.axes}
    table = SignalsTable.of(model.axes, T, columns)
    twin = Twin(model, (record_of(table, model, 25.0, "log"),))
    squares = unsaid_squares(twin, 0)
    time = twin.records[0].time_s[twin.records[0].keep]
    # a joint gives 20 mrad at most before it slides: 18 mrad at 3 mrad/s may be that, 30 mrad/s may not
    outer, inner = (squares[:, twin.channels.index(c)] for c in twin.channels if c.signal == "torque")
    held = model.number("outer", "friction.breakaway") ** 2
    assert outer[(time > 1.0) & (time < 5.0)] == pytest.approx(held)
    assert np.all(outer[(time > 7.0) & (time < 11.0)] < 1e-6 * held)
    assert not np.any(inner)


@pytest.mark.parametrize(
    ("position", "share"),
    [
        # slow over a long way: it slides
        (0.003 * T, 0.0),
        # a rest between two moves
        (np.where(T < 3.0, 0.2 * T, np.where(T < 6.0, 0.6 + 0.001 * (T - 3.0), 0.603 + 0.2 * (T - 6.0))), 0.245),
        # it never slides, and nothing else is seen
        (0.0005 * np.sin(T), 0.0),
    ],
)
@pytest.mark.parametrize("is_linear", [False, True])
def test_a_joint_creeps_where_it_is_slow_over_a_short_way_only(
    position: np.ndarray, share: float, is_linear: bool
) -> None:
    # 50 mm of a slide count as much as one radian
    size = 0.05 if is_linear else 1.0
    found = creeps(size * np.round(position / STEP) * STEP, 1e-3, is_linear)
    assert np.mean(found) == pytest.approx(share, abs=0.01)


def test_other_readings_of_a_log_differ_by_its_rounding_alone() -> None:
    model = shipped_model()
    columns = {f"{axis}.{signal}": np.sin(2.0 * T) for axis in model.axes for signal in ("torque", "position")}
    columns |= {f"{axis}.position": np.round(0.3 * np.sin(2.0 * T) / STEP) * STEP for axis in model.axes}
    table = SignalsTable.of(model.axes, T, columns)
    twin = Twin(model, (record_of(table, model, 25.0, "log"),))
    readings = other_readings(twin, (table,))
    assert len(readings) > 1
    for reading in readings:
        assert np.array_equal(reading.records[0].keep, twin.records[0].keep)
        moved = np.abs(reading.records[0].motion[:, 0] - twin.records[0].motion[:, 0])
        assert 0.0 < moved.max() < 2.0 * STEP
