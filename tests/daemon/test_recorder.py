from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from gimbal_hil.data.runs import TICK_ROW, RunHeader, RunWriter, open_run
from gimbal_hil.loop.host.program import AxisCommand, Segment, program_of
from gimbal_hil.loop.timing.mailbox import RingReader, RingWriter, create_ring
from gimbal_hil.loop.timing.miss_causes import MISS_CODE, MissCause
from gimbal_hil.realtime.service.recorder import Recorder
from gimbal_hil.realtime.telemetry.records import (
    MISS_RECORD,
    ROW_BYTES,
    WALL_CLOCK_AT,
    CommandKind,
    Commands,
    Exchange,
    Telemetry,
    TelemetryKind,
    exchange_from,
    pack_program,
    take_commands,
    unpack_program,
)

PERIOD_NS = 1_000_000


def row(tick: int, skipped: int = 0) -> bytes:
    rows = np.zeros(1, TICK_ROW)
    rows["tick"], rows["time_ns"], rows["skipped_ticks"], rows["rejected_frames"] = tick, tick * PERIOD_NS, skipped, 2
    return rows.tobytes()


def tick_of(row_bytes: bytes) -> Exchange:
    return Exchange(row_bytes, b"", b"")


def header() -> RunHeader:
    return RunHeader({}, {}, 0, PERIOD_NS, False)


def test_the_row_is_taken_apart_where_the_log_says() -> None:
    assert TICK_ROW.itemsize == ROW_BYTES and TICK_ROW.fields is not None
    assert TICK_ROW.fields["wake_latency_ns"][1] == WALL_CLOCK_AT
    assert TICK_ROW.fields["computing_ns"][1] == WALL_CLOCK_AT + 4


def test_a_tick_passes_the_ring_with_its_frames_and_readings() -> None:
    descriptor = create_ring(1 << 16)
    telemetry, reader = Telemetry(RingWriter(descriptor), lockstep=False), RingReader(descriptor)
    telemetry.tick(row(5), 70_000, 3 * 10**9, b"r" * 20, b"s" * 10)
    (record,) = reader.take()
    assert record.kind == TelemetryKind.TICK
    exchange = exchange_from(record.payload)
    assert (exchange.tick, exchange.received, exchange.sent) == (5, b"r" * 20, b"s" * 10)
    found = np.frombuffer(exchange.row, TICK_ROW)[0]
    assert found["wake_latency_ns"] == 70_000 and found["computing_ns"] == 2**31 - 1
    assert found["rejected_frames"] == 2 and found["miss_cause"] == 0
    os.close(descriptor)


def test_a_program_comes_out_as_it_went_in_and_requests_are_numbered() -> None:
    descriptor = create_ring(1 << 20)
    commands, reader = Commands(RingWriter(descriptor)), RingReader(descriptor)
    program = program_of([Segment(AxisCommand(table=np.arange(7.0)), AxisCommand(), duration_ticks=9)])
    assert commands.send(CommandKind.START, pack_program(program)) == 1
    assert commands.send(CommandKind.STOP) == 2
    start, stop = take_commands(reader)
    assert (start.kind, start.number, stop.kind, stop.number) == (CommandKind.START, 1, CommandKind.STOP, 2)
    again = unpack_program(start.payload)
    assert again.length == program.length and again.values.tobytes() == program.values.tobytes()
    assert commands.send(CommandKind.START, bytes(1 << 20)) is None
    os.close(descriptor)


def test_a_cause_that_is_known_later_reaches_the_row_it_belongs_to(tmp_path: Path) -> None:
    recorder = Recorder(RunWriter(tmp_path / "run", header()), PERIOD_NS)
    for tick in range(10):
        recorder.take_exchanges([tick_of(row(tick))])
    recorder.take_exchanges([tick_of(row(15, skipped=5))])
    recorder.write()
    recorder.miss(15, MISS_CODE[MissCause.MACHINE_STALL])
    for tick in range(16, 200):
        recorder.take_exchanges([tick_of(row(tick))])
        recorder.write()
    recorder.close(0, "done")
    ticks = open_run(tmp_path / "run").ticks
    assert len(ticks) == 195
    assert ticks["miss_cause"][ticks["tick"] == 15] == MISS_CODE[MissCause.MACHINE_STALL]
    assert not ticks["miss_cause"][ticks["tick"] != 15].any()


def test_rows_without_frames_and_one_in_so_many_when_the_configuration_says_so(tmp_path: Path) -> None:
    recorder = Recorder(RunWriter(tmp_path / "run", header()), PERIOD_NS, frames=False, every_ticks=10)
    recorder.take_exchanges([tick_of(row(tick)) for tick in range(100)])
    recorder.close(0, "done")
    run = open_run(tmp_path / "run")
    assert run.ticks["tick"].tolist() == list(range(0, 100, 10)) and len(run.frames) == 0


def test_records_that_were_overwritten_are_an_event_in_the_log(tmp_path: Path) -> None:
    descriptor = create_ring(4096)
    writer, reader = RingWriter(descriptor), RingReader(descriptor)
    recorder = Recorder(RunWriter(tmp_path / "run", header()), PERIOD_NS)
    for _ in range(2000):
        writer.push(TelemetryKind.MISS, MISS_RECORD.pack(1, 1, 1))
    kept = len(reader.take())
    recorder.note_lost(reader)
    recorder.note_lost(reader)
    recorder.close(0, "done")
    events = [event for event in open_run(tmp_path / "run").events if event.kind.value == "recording"]
    assert [event.data["records"] for event in events] == [2000 - kept]
