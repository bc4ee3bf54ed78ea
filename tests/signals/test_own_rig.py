"""What a rig of one's own brings: amperes, torque that is known already, logs of other rates and of uneven ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import LogReading, on_grid, read_signals, read_together
from sim_backend.model import AntennaModel, model_from_document
from tests.rigs.rig import write_log

STEP = 1e-3


def arm(**actuator: object) -> AntennaModel:
    axis = {"body": {"inertia": {"zz": 0.5}}, "actuator": actuator}
    return model_from_document({"schema": 1, "name": "arm", "kind": "rotary", "axes": {"arm": axis}}, "arm.yaml")


def times(period_s: float, seconds: float = 4.0, jitter: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(3)
    even = np.arange(0.0, seconds, period_s)
    return even + jitter * period_s * np.concatenate(([0.0], rng.uniform(-1.0, 1.0, len(even) - 1)))


def log(path: Path, at: np.ndarray, **more: np.ndarray) -> Path:
    columns = {"time_s": at, "arm.torque": np.sign(np.sin(3.0 * at)), "arm.position": np.sin(2.0 * at)}
    return write_log(path, columns | {f"arm.{name}": values for name, values in more.items()})


def test_a_current_stands_in_for_torque_where_the_model_has_a_torque_constant(tmp_path: Path) -> None:
    at = times(0.01)
    path = write_log(tmp_path / "amps.csv", {"time_s": at, "arm.current": np.cos(at), "arm.position": at})
    table = read_signals(path, arm(torque_constant={"value": 0.2, "unit": "N m/A", "uncertainty": "5%"}))
    assert np.allclose(table.torque("arm"), 0.2 * np.cos(at)) and any("ampere" in note for note in table.notes)
    with pytest.raises(BadInputError, match=r"amps\.csv: column arm\.current.*torque_constant"):
        read_signals(path, arm())


def test_a_torque_that_is_known_is_taken_off_the_command_and_stays_visible(tmp_path: Path) -> None:
    at = times(0.01)
    table = read_signals(log(tmp_path / "log.csv", at, torque_known=0.5 * at), ("arm",))
    middle = 0.5 * (at + 0.005)
    assert np.allclose((table.commanded("arm") - table.torque("arm"))[:-1], middle[:-1])
    assert np.array_equal(table.columns["arm.torque_known"], 0.5 * at)
    assert np.array_equal(table.rows(5, 50).torque("arm")[:-1], table.torque("arm")[5:49])


def test_acceleration_of_the_base_is_read_as_three_columns(tmp_path: Path) -> None:
    at = times(0.01)
    base = {f"base.a{key}": np.full(len(at), value) for key, value in zip("xyz", (1.0, 2.0, 3.0), strict=True)}
    path = write_log(tmp_path / "log.csv", {"time_s": at, "arm.torque": at, "arm.position": at} | base)
    table = read_signals(path, ("arm",))
    assert [float(table.base(name)[0]) for name in ("ax", "ay", "az")] == [1.0, 2.0, 3.0]  # type: ignore[index]


def test_logs_of_different_rates_are_refused_by_name_and_joined_on_request(tmp_path: Path) -> None:
    paths = [log(tmp_path / "fast.csv", times(0.002)), log(tmp_path / "slow.csv", times(0.005))]
    with pytest.raises(BadInputError, match=r"slow\.csv: time_s.*0\.005 s.*0\.002 s.*--rate HZ"):
        read_together(paths, arm())
    assert [table.period_s for table in read_together(paths, arm(), LogReading(resample=True))] == pytest.approx(
        [0.005, 0.005]
    )
    assert [table.period_s for table in read_together(paths, arm(), LogReading(rate_hz=125.0))] == pytest.approx(
        [0.008, 0.008]
    )
    with pytest.raises(BadInputError, match="--rate 0"):
        read_together(paths, arm(), LogReading(rate_hz=0.0))
    with pytest.raises(BadInputError, match=r"--rate 125000: is 250 times finer than .*fast\.csv.*time_s=COLUMN:ms"):
        read_together(paths, arm(), LogReading(rate_hz=125000.0))


def test_uneven_logs_of_slightly_different_periods_come_out_at_one_rate(tmp_path: Path) -> None:
    paths = [log(tmp_path / f"{k}.csv", times(0.002 * (1.0 + 0.02 * k), jitter=0.3)) for k in range(3)]
    found = read_together(paths, arm(), LogReading(resample=True))
    assert np.ptp([table.period_s for table in found]) < 1e-9
    for table in found:
        assert np.max(np.abs(table.position("arm") - np.sin(2.0 * table.time_s))) < 2e-6


@pytest.mark.parametrize("rate_hz", [130.0, 500.0, 1700.0])
def test_a_grid_keeps_the_impulse_of_a_commanded_torque(tmp_path: Path, rate_hz: float) -> None:
    path = log(tmp_path / "log.csv", times(0.002, jitter=0.3))
    uneven = np.genfromtxt(path, delimiter=",", names=True)
    table = read_signals(path, ("arm",), rate_hz=rate_hz)
    whole = np.sum(uneven["armtorque"][:-1] * np.diff(uneven["time_s"]))
    left = abs(whole - np.sum(table.torque("arm")[:-1]) * table.period_s)
    assert left <= 1.01 * (uneven["time_s"][-1] - table.time_s[-1])
    assert np.max(np.abs(table.torque("arm"))) <= 1.0 + 1e-12


def test_a_reference_on_a_grid_takes_only_levels_that_were_asked_for(tmp_path: Path) -> None:
    at = times(0.002, jitter=0.3)
    asked = np.where(at < 1.7, 0.25, -0.5)
    table = read_signals(log(tmp_path / "log.csv", at, rate_ref=asked), ("arm",), rate_hz=300.0)
    assert set(np.unique(table.columns["arm.rate_ref"])) == {0.25, -0.5}


def test_an_encoder_count_is_not_smeared_by_a_grid(tmp_path: Path) -> None:
    at = times(0.002, jitter=0.3)
    counted = STEP * np.round(0.004 * at / STEP)
    path = write_log(tmp_path / "log.csv", {"time_s": at, "arm.torque": 0.0 * at, "arm.position": counted})
    table = read_signals(path, ("arm",), rate_hz=700.0)
    found = table.position("arm") / STEP
    between = np.count_nonzero(np.abs(found - np.round(found)) > 1e-9)
    # only rows that fall between the two samples of a change stand between two counts; none overshoots
    assert between <= 2 * len(np.unique(counted)) and found.max() <= counted.max() / STEP
    smooth = read_signals(log(tmp_path / "smooth.csv", at), ("arm",), rate_hz=700.0)
    assert np.max(np.abs(smooth.position("arm") - np.sin(2.0 * smooth.time_s))) < 2e-6


def test_a_table_that_has_the_grids_rate_is_left_as_it_is(tmp_path: Path) -> None:
    table = read_signals(log(tmp_path / "log.csv", times(0.002)), ("arm",))
    assert on_grid(table, 0.002) is table
    assert len(on_grid(table, 0.004)) == len(table) // 2
