"""Logs in which a bus or a logger wrote what it had: reads that came again, rows that came twice, rows at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable, read_signals
from gimbal_hil.data.tables.labels import arranged
from tests.cases.asking import asked
from tests.cases.joint import BENCH, MODEL, Floats, table_text

LOG = BENCH.log(seed=4)
ROWS = len(LOG.time)
AXES = ("joint",)
RANDOM = np.random.default_rng(8)


def read(folder: Path, text: str, **repair: object) -> SignalsTable:
    (folder / "log.csv").write_text(text)
    return read_signals(folder / "log.csv", AXES, **repair)  # type: ignore[arg-type]


def again(values: Floats, rows: np.ndarray) -> Floats:
    held = values.copy()
    for row in np.flatnonzero(rows):
        held[row] = held[row - 1]
    return held


def fast(rows: np.ndarray) -> np.ndarray:
    """Those in which the joint goes on by ten steps of the encoder or more, and around which it does."""
    return rows & (np.abs(np.convolve(LOG.rate, np.ones(9) / 9.0, "same")) > 10.0 * BENCH.step * BENCH.rate_hz)


@pytest.mark.parametrize("share", [0.01, 0.1, 0.3])
@pytest.mark.parametrize("frames", [False, True], ids=["position", "whole frames"])
def test_reads_that_came_again_are_made_up_and_told(tmp_path: Path, share: float, frames: bool) -> None:
    lost = fast(RANDOM.random(ROWS) < share)
    log = LOG.but(position=again(LOG.position, lost))
    log = log.but(torque=again(LOG.torque, lost)) if frames else log
    table = read(tmp_path, log.text())
    before, after = (
        np.sqrt(np.mean((one - LOG.position)[lost] ** 2)) for one in (log.position, table.position("joint"))
    )
    assert after < 0.1 * before
    note = " ".join(table.notes)
    assert "hold the read of the row before though the joint went on" in note and "line" in note
    assert ("and joint.torque in" in note) is frames


def test_an_encoder_that_reads_the_same_where_the_joint_turns_or_is_slow_is_left_alone(tmp_path: Path) -> None:
    for seed in range(6):
        log = BENCH.log("a" if seed % 2 else "b", seed=seed)
        for step in (BENCH.step, 16.0 * BENCH.step):
            position = np.round(log.position / step) * step
            table = read(tmp_path, log.but(position=position).text())
            assert not table.notes and table.position("joint") == pytest.approx(position, abs=1e-8)


def test_rows_that_came_twice_while_the_clock_went_on_go_where_that_is_allowed(tmp_path: Path) -> None:
    rows = np.sort(np.r_[np.arange(ROWS), RANDOM.choice(np.flatnonzero(fast(np.ones(ROWS, bool))), 30, replace=False)])
    twice = LOG.but(time=np.arange(len(rows)) / BENCH.rate_hz, torque=LOG.torque[rows], position=LOG.position[rows])
    with pytest.raises(BadInputError, match=r"line \d+, .* came twice, as \d+ of \d+ rows did, .*--drop-invalid"):
        read(tmp_path, twice.text())
    table = read(tmp_path, twice.text(), drop_invalid=True)
    assert abs(len(table) - ROWS) <= 2 and any("rows came twice" in note for note in table.notes)
    assert table.position("joint")[:4000] == pytest.approx(LOG.position[:4000], abs=5e-3)


@pytest.mark.parametrize("rows_each", [1.04, 1.1, 1.2, 1.37])
@pytest.mark.parametrize("repaired", [False, True])
def test_a_drive_that_is_slower_than_its_log_keeps_every_row(tmp_path: Path, rows_each: float, repaired: bool) -> None:
    at = np.floor(np.floor(np.arange(ROWS) / rows_each + 1e-9) * rows_each).astype(int)
    slower = LOG.but(position=LOG.position[at], torque=LOG.torque[at])
    table = read(tmp_path, slower.text(), drop_invalid=repaired)
    assert len(table) == ROWS and table.time_s[-1] == pytest.approx(LOG.time[-1])


def test_an_encoder_that_is_read_at_uneven_rows_is_refused_with_how_often(tmp_path: Path) -> None:
    at = np.floor(np.floor(LOG.time * 97.0) / 97.0 * BENCH.rate_hz + 1e-9).astype(int)
    with pytest.raises(BadInputError, match=r"joint\.position: is read about \d+ times a second, at uneven rows"):
        read(tmp_path, LOG.but(position=LOG.position[at]).text())


def test_stamps_of_rows_that_arrived_at_once_are_refused_until_their_rate_is_stated(tmp_path: Path) -> None:
    stamps = (np.arange(ROWS) // 8 + 1) * 8 / BENCH.rate_hz + np.arange(ROWS) % 8 * 2e-5
    text = LOG.but(time=stamps).text(forms={"time_s": ".6f"})
    for options in ({}, {"resample": True}, {"rate_hz": 300.0}):
        with pytest.raises(BadInputError, match=r"line 3, .*about 8 at once.*--rate HZ .*\(about 500\)"):
            read(tmp_path, text, **options)
    table = read(tmp_path, text, rate_hz=500.0)
    assert len(table) == ROWS and table.position("joint") == pytest.approx(LOG.position, abs=1e-8)
    assert any("arrived about 8 at once" in note for note in table.notes)


def test_a_torque_of_nothing_in_many_single_rows_is_refused_whatever_is_repaired(tmp_path: Path) -> None:
    (tmp_path / "model.yaml").write_text(MODEL)
    text = LOG.but(torque=np.where(RANDOM.random(ROWS) < 0.05, 0.0, LOG.torque)).text()
    with pytest.raises(
        BadInputError, match=r"line \d+: joint\.torque, row .* reads 0, which did nothing .* \(\d{3} rows"
    ):
        asked(tmp_path, text)


def test_torques_of_the_other_sign_in_single_rows_are_all_made_up_small_ones_and_those_of_turns_too(
    tmp_path: Path,
) -> None:
    (tmp_path / "model.yaml").write_text(MODEL)
    flipped = np.random.default_rng(21).random(ROWS) < 0.008
    table = asked(tmp_path, LOG.but(torque=np.where(flipped, -LOG.torque, LOG.torque)).text(), repair=True)
    off = np.abs(table.torque("joint") - LOG.torque)[flipped]
    large = np.abs(LOG.torque[flipped]) > 0.1
    assert np.count_nonzero(large) > 30 and np.count_nonzero(off[large] > 0.05) <= 2


def test_pulses_that_did_nothing_are_refused_in_however_many_rows(tmp_path: Path) -> None:
    (tmp_path / "model.yaml").write_text(MODEL)
    pulses = 0.4 * (np.random.default_rng(22).random(ROWS) < 0.04)
    for repair in (False, True):
        with pytest.raises(BadInputError, match=r"joint\.torque, .* did nothing to the motion \(\d{3} rows in all\)"):
            asked(tmp_path, LOG.but(torque=LOG.torque + pulses).text(), repair=repair)


def test_a_torque_that_is_not_counted_from_zero_is_refused_with_how_much_it_is_off(tmp_path: Path) -> None:
    (tmp_path / "model.yaml").write_text(MODEL)
    with pytest.raises(BadInputError, match=r"line 2: joint\.torque, .* not counted from zero .* about 4\.\d+ less"):
        asked(tmp_path, LOG.but(torque=LOG.torque + 4.1).text(), repair=True)


def test_no_wrap_is_proposed_for_jumps_of_many_sizes_and_a_turn_for_an_angle_that_was_filtered_over_it(
    tmp_path: Path,
) -> None:
    (tmp_path / "model.yaml").write_text(MODEL)
    jumps = np.zeros(ROWS)
    jumps[600:7000:600] = 0.1 * RANDOM.uniform(0.7, 1.6, 11) * np.array([1.0, -1.0] * 5 + [1.0])
    with pytest.raises(BadInputError, match="jumps by") as refused:
        asked(tmp_path, LOG.but(position=LOG.position + np.cumsum(jumps)).text())
    assert "carries it on" not in str(refused.value)
    degrees = (np.degrees(LOG.position) + 5.0) % 360.0
    text = LOG.but(position=np.interp(LOG.time + 8e-4, LOG.time, degrees)).text()
    with pytest.raises(BadInputError, match=r"--column joint\.position=joint\.position%360:deg carries it on"):
        asked(tmp_path, text, ("time_s=time_s", "joint.torque=joint.torque", "joint.position=joint.position:deg"))


@pytest.mark.parametrize("steps", [np.tile([0.0002, 0.0048], 500), np.r_[np.full(1000, 0.001), np.full(1000, 0.05)]])
def test_two_frames_of_a_cycle_and_a_slower_second_half_are_no_bursts(tmp_path: Path, steps: Floats) -> None:
    time = np.concatenate([[0.0], np.cumsum(steps)])
    lines = [f"{t:.6f},{0.1 * t:.6f},0.1" for t in time]
    with pytest.raises(BadInputError) as refused:
        read(tmp_path, "\n".join(["time_s,joint.position,joint.torque", *lines]))
    assert "as they arrived" not in str(refused.value)


def test_one_cut_line_among_lines_with_named_cells_is_refused_by_its_line(tmp_path: Path) -> None:
    lines = [f"t:{k * 0.005:.3f} pos:{k * 0.1:.2f} tau:0.1" for k in range(400)]
    layout = arranged([*lines[:100], "t:0.5 pos:1", *lines[101:]])[1]
    assert layout is not None and layout.labelled and layout.names == ("t", "pos", "tau")


def test_joints_whose_torque_was_not_logged_are_read_as_they_stand(tmp_path: Path) -> None:
    """As those of an arm beside the one that is asked about."""
    log = BENCH.log(seconds=4.0)
    columns = {
        "time_s": log.time,
        "joint.torque": log.torque,
        "joint.position": log.position,
        "base.position": log.rate,
    }
    (tmp_path / "log.csv").write_text(table_text(columns))
    table = read_signals(tmp_path / "log.csv", ("joint", "base"), passive=("base",))
    assert len(table) == len(log.time) and "base.torque" not in table.columns
