"""Run folders as signals tables: rows follow the device's tick and the echoed set-point, not the time of arrival."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.enumerations import DriveState
from firmware_protocol.errors import BadInputError
from firmware_protocol.schema import BY_NAME, POSITION_STEP_RAD, TORQUE_STEP_NM
from gimbal_hil.data.runs import EventKind, RunWriter, damage_of, open_run
from gimbal_hil.data.signals import SignalsTable, read_signals, signals_of_run, write_signals
from gimbal_hil.loop.host import AxisCommand, Mode, Segment, Shape, program_of
from tests.runs.synthetic import (
    HEADER,
    Sender,
    device_block,
    host_block,
    position_rad,
    record_run,
    row_of,
    torque_nm,
    yaw_rad,
)

AXES = ("outer", "inner")


def check_rows(table: SignalsTable, first: int = 0) -> None:
    ticks = first + np.round(table.time_s / 1e-3).astype(int)
    assert np.abs(table.torque("outer") - torque_nm(ticks)).max() < TORQUE_STEP_NM / 100
    assert np.abs(table.position("outer") - position_rad(ticks)).max() <= 0.51 * POSITION_STEP_RAD


def test_a_lockstep_run_gives_one_row_a_tick_with_the_torque_that_acted_from_it_on(tmp_path: Path) -> None:
    record_run(tmp_path / "run", 5000)
    table = read_signals(tmp_path / "run", AXES)
    assert len(table) == 4999 and table.period_s == pytest.approx(1e-3, rel=1e-12)
    check_rows(table)
    assert table.torque("inner") == pytest.approx(-0.25)
    yaw, temperature, reference = (
        table.base("yaw"),
        table.signal("outer", "temperature"),
        table.signal("outer", "rate_ref"),
    )
    assert yaw is not None and np.abs(yaw[:4990] - yaw_rad(np.arange(4990))).max() < 6e-5
    assert temperature is not None and np.abs(temperature[:4950] - 20 - np.arange(4950) * 1e-3).max() < 0.06
    assert reference is not None and np.all(reference == 1.5)
    assert table.signal("outer", "torque_measured") is None


def record_with_stalls(folder: Path, stalls: dict[int, int], ticks: int = 3000, queue: int = 0) -> None:
    """A device on its own clock; the host loses whole periods and then finds all the frames that came meanwhile.

    `queue` more feedback sets are under way at any time.
    """
    writer = RunWriter(folder, HEADER, clock_ns=lambda: 0)
    host, device = Sender(), Sender()
    waiting = [device_block(device, number, number - 1, 300 + number) for number in range(-queue, 0)]
    tick, acting = 0, -1
    while tick < ticks:
        skipped = stalls.get(tick, 0)
        for number in range(tick, tick + skipped + 1):
            waiting.append(device_block(device, number, acting, 300 + number))
        tick += skipped
        ready, waiting = waiting[: len(waiting) - queue], waiting[len(waiting) - queue :]
        writer.append_exchange(tick, b"".join(ready), host_block(host, tick))
        writer.append_ticks(row_of(tick, skipped))
        acting = tick
        tick += 1
    writer.close()


@pytest.mark.parametrize("queue", [0, 3])
def test_ticks_that_the_host_skipped_are_rows_with_the_torque_that_the_device_held(tmp_path: Path, queue: int) -> None:
    stalls = {500: 7, 1000: 200, 2000: 1}
    record_with_stalls(tmp_path / "run", stalls, queue=queue)
    table = read_signals(tmp_path / "run", AXES, drop_invalid=True)
    ticks = np.round(table.time_s / 1e-3).astype(int) - queue
    assert len(table) == 2999 - queue
    held = ticks.copy()
    for start, lost in stalls.items():
        held[(ticks >= start) & (ticks < start + lost)] = start - 1
    assert np.abs(table.torque("outer") - torque_nm(held)).max() < TORQUE_STEP_NM / 100
    assert np.abs(table.position("outer") - position_rad(ticks + 300)).max() <= 0.51 * POSITION_STEP_RAD


def test_lost_repeated_and_damaged_frames_are_missing_rows_and_never_wrong_ones(tmp_path: Path) -> None:
    random = np.random.default_rng(5)
    writer = RunWriter(tmp_path / "run", HEADER, clock_ns=lambda: 0)
    host, device = Sender(), Sender()
    late = b""
    for tick in range(3000):
        block = device_block(device, tick, tick - 1)
        records = [block[at : at + 10] for at in range(0, len(block), 10)]
        fault = random.integers(0, 60)
        victim = int(random.integers(0, len(records)))
        if fault == 0:
            records.pop(victim)
        elif fault == 1:
            records.insert(victim, records[victim])
        elif fault == 2:
            damaged = bytearray(records[victim])
            damaged[random.integers(2, 10)] ^= 1 << int(random.integers(0, 8))
            records[victim] = bytes(damaged)
        elif fault == 3:
            late, records[victim] = records[victim], late
        writer.append_exchange(tick, b"".join(records), host_block(host, tick))
        writer.append_ticks(row_of(tick))
    writer.close()
    with pytest.raises(BadInputError, match=r"row \d+, column (outer|inner)\.\w+: is empty"):
        read_signals(tmp_path / "run", AXES)
    stretch = read_signals(tmp_path / "run", AXES, drop_invalid=True)
    first = int(np.argmin(np.abs(np.arange(3000)[:, None] * 1e-3 - stretch.time_s[0]).ravel()))
    ticks = first + np.arange(len(stretch))
    assert np.abs(stretch.torque("outer") - torque_nm(ticks)).max() < TORQUE_STEP_NM / 100
    assert np.abs(stretch.position("outer") - position_rad(ticks)).max() <= 0.51 * POSITION_STEP_RAD
    filled = read_signals(tmp_path / "run", AXES, resample=True)
    assert len(filled) >= 2980
    ticks = np.round(filled.time_s / 1e-3)
    assert np.abs(filled.position("outer") - position_rad(ticks)).max() < 2e-5  # bridged over 1.5e-3 rad a row


def test_the_table_ends_where_the_device_restarts(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", HEADER, clock_ns=lambda: 0)
    host, device = Sender(), Sender()
    for tick in range(2000):
        if tick == 1500:
            device = Sender()
        received = (
            b"" if 1200 <= tick < 1500 else device_block(device, tick, tick - 1, tick if tick < 1200 else tick - 1500)
        )
        writer.append_exchange(tick, received, host_block(host, tick))
        writer.append_ticks(row_of(tick))
    writer.close()
    table = read_signals(tmp_path / "run", AXES)
    assert len(table) == 1199
    assert any("restarted at tick 1500" in note for note in table.notes)
    check_rows(table)


def test_torque_counts_only_while_the_drive_obeys_and_the_table_ends_when_it_brakes_by_itself(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", HEADER, clock_ns=lambda: 0)
    host, device = Sender(), Sender()
    for tick in range(600):
        state = DriveState.READY_TO_SWITCH_ON if tick <= 100 else DriveState.OPERATION_ENABLED
        state = DriveState.QUICK_STOP_ACTIVE if tick >= 500 else state
        status = {"state": state, "last_sequence": (tick - 1) % 1024, "tick": tick}
        received = device.block(feedback_outer={}, feedback_inner={}, drive_status=status)
        writer.append_exchange(tick, received, host_block(host, tick))
        writer.append_ticks(row_of(tick))
    writer.close()
    table = read_signals(tmp_path / "run", AXES)
    assert np.all(table.torque("inner")[:100] == 0) and np.all(table.torque("inner")[100:] == -0.25)
    assert len(table) == 499
    assert any("braked by itself from tick 500" in note for note in table.notes)


def test_segments_that_are_laps_number_the_rows(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", HEADER, clock_ns=lambda: 0)
    host, device = Sender(), Sender()
    for tick in range(400):
        if tick % 100 == 0 and tick < 300:
            writer.event(tick, tick * 1_000_000, EventKind.SEGMENT, "lap", {"repeat": tick // 100} if tick else {})
        writer.append_exchange(tick, device_block(device, tick, tick - 1), host_block(host, tick))
        writer.append_ticks(row_of(tick))
    writer.close()
    repeat = read_signals(tmp_path / "run", AXES).repeat
    assert repeat is not None and repeat.tolist() == [-1] * 100 + [1] * 100 + [2] * 199


def test_a_run_without_feedback_or_of_other_axes_is_refused(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", HEADER)
    writer.append_ticks(row_of(0))
    writer.close()
    with pytest.raises(BadInputError, match="keeps no frames"):
        read_signals(tmp_path / "run", AXES)
    writer = RunWriter(tmp_path / "run", HEADER, force=True)
    writer.append_exchange(0, b"", host_block(Sender(), 0))
    writer.append_ticks(row_of(0))
    writer.close()
    with pytest.raises(BadInputError, match="holds no feedback"):
        read_signals(tmp_path / "run", AXES)
    with pytest.raises(BadInputError, match="axes outer, inner"):
        read_signals(tmp_path / "run", ("cart",))


def test_the_exported_table_is_the_run_s_table(tmp_path: Path) -> None:
    record_run(tmp_path / "run", 500)
    table = signals_of_run(open_run(tmp_path / "run"))
    write_signals(table, tmp_path / "log.csv")
    again = read_signals(tmp_path / "log.csv", AXES)
    assert {name: values.tobytes() for name, values in again.columns.items()} == {
        name: values.tobytes() for name, values in table.columns.items()
    }
    assert math.isclose(again.period_s, table.period_s, rel_tol=1e-9)
    assert BY_NAME["feedback_outer"].can_id in open_run(tmp_path / "run").frames["identifier"]


def thinned(
    folder: Path,
    ticks: Iterable[int],
    skips: Mapping[int, int] | None = None,
    *,
    every: int = 100,
    segment: int = 0,
    lockstep: bool = True,
) -> list[str]:
    """What is wrong with a run of one row in `every`, of which these are there."""
    configuration = HEADER.configuration | {"recording": {"frames": False, "every_ticks": every}}
    still = AxisCommand(Mode.POSITION, Shape.HOLD)
    program = program_of([Segment(still, still, duration_ticks=10, record_every=segment)])
    with RunWriter(folder, replace(HEADER, configuration=configuration, lockstep=lockstep)) as writer:
        writer.command(0, 0, "start", {"command": "start", "program": program.as_document()})
        for tick, periods in (skips or {}).items():
            writer.event(tick, 0, EventKind.TIMING, "missed", {"periods": periods})
        for tick in ticks:
            writer.append_ticks(row_of(tick))
    return [found.in_words() for found in damage_of(open_run(folder))]


@pytest.mark.parametrize("lockstep", [True, False])
def test_a_thinned_run_of_which_rows_were_cut_out_is_damaged(tmp_path: Path, lockstep: bool) -> None:
    cut = [*range(0, 3000, 100), *range(7000, 10000, 100)]
    (said,) = thinned(tmp_path / "run", cut, lockstep=lockstep)
    assert "3000" in said and "lost rows" in said


def test_a_row_of_a_thinned_run_whose_tick_was_skipped_is_none_that_was_lost(tmp_path: Path) -> None:
    there = [tick for tick in range(0, 3000, 100) if tick not in (1000, 1100, 2000)]
    assert thinned(tmp_path / "explained", there, {1150: 180, 2003: 5}) == []
    assert len(thinned(tmp_path / "half", there, {1150: 80, 2003: 5})) == 1
    assert thinned(tmp_path / "one", [0, 100, 300], lockstep=False) == []


@pytest.mark.parametrize(("every", "step"), [(1, 5), (10, 10), (4, 20)])
def test_a_segment_of_a_thinned_run_may_ask_for_fewer_rows(tmp_path: Path, every: int, step: int) -> None:
    assert thinned(tmp_path / "whole", range(0, 1000, step), every=every, segment=5) == []
    assert len(thinned(tmp_path / "cut", [0, step, 3 * step], every=every, segment=5)) == 1
    # a daemon asks nobody what it records
    assert len(thinned(tmp_path / "daemon", range(0, 1000, 30 * every), every=every, segment=5, lockstep=False)) == 1


def test_a_thinned_run_is_sound_and_says_why_it_makes_no_table(tmp_path: Path) -> None:
    thinned = HEADER.configuration | {"recording": {"frames": False, "every_ticks": 100}}
    writer = RunWriter(tmp_path / "run", replace(HEADER, configuration=thinned))
    for tick in range(0, 1000, 100):
        writer.append_ticks(row_of(tick))
    writer.close()
    assert list(damage_of(open_run(tmp_path / "run"))) == []
    with pytest.raises(BadInputError, match=r"keeps no frames, and one tick in 100; expected .*--every 1"):
        read_signals(tmp_path / "run", AXES)
