"""The log of a run: what was appended is what is read, whatever happens to the files."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import textwrap
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.documents import yaml_mapping, yaml_text
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import (
    FRAME_ROW,
    TICK_ROW,
    EventKind,
    FrameDirection,
    RunWriter,
    blocks_of_frames,
    damage_of,
    open_run,
    tick_rows,
)
from gimbal_hil.data.runs.arrow_messages import batch_bytes, header_bytes
from gimbal_hil.data.runs.arrow_stream import END_OF_STREAM
from tests.runs.synthetic import HEADER, Sender, device_block, host_block, record_run, row_of

TICKS = 500


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("log") / "run"
    record_run(folder, TICKS, flush_every=100)
    return folder


def copy_of(recorded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(recorded, tmp_path / "copy", dirs_exist_ok=True))


def same_rows(found: np.ndarray, expected: np.ndarray) -> bool:
    return found.tobytes() == expected.tobytes()


def test_every_block_row_and_event_comes_back_as_it_was_given(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", HEADER)
    device, host = Sender(), Sender()
    received, sent = device_block(device, 3, 2), host_block(host, 3)
    writer.append_exchange(3, received, sent)
    writer.append_ticks(row_of(3))
    writer.event(3, 3_000_000, EventKind.FAULT, "überspeed", {"axis": "outer", "rate_rad_s": 0.1 + 0.2})
    writer.close()
    run = open_run(tmp_path / "run")
    by_direction = {d: run.frames[run.frames["direction"] == d] for d in FrameDirection}
    assert blocks_of_frames(by_direction[FrameDirection.DEVICE_TO_HOST]) == received
    assert blocks_of_frames(by_direction[FrameDirection.HOST_TO_DEVICE]) == sent
    expected = row_of(3)
    expected["check"] = run.ticks["check"]
    assert same_rows(run.ticks, expected)
    assert run.events[0].data == {"axis": "outer", "rate_rad_s": 0.1 + 0.2}
    assert run.events[0].text == "überspeed"
    assert run.notes == ()


def test_any_arrow_reader_opens_the_streams_of_a_finished_run(recorded: Path) -> None:
    ticks = pa.ipc.open_stream((recorded / "ticks.arrow").read_bytes()).read_all()
    frames = pa.ipc.open_stream((recorded / "frames.arrow").read_bytes()).read_all()
    assert ticks.column("tick").to_pylist() == list(range(TICKS))
    assert frames.column("payload")[0].as_py() == open_run(recorded).frames[0]["payload"].tobytes()


def test_the_header_comes_back_with_every_number_exact(recorded: Path) -> None:
    record = open_run(recorded).record
    assert record.header.configuration == HEADER.configuration
    assert (record.header.seed, record.header.period_ns, record.header.lockstep) == (7, 1_000_000, True)
    assert record.end is not None and record.end.exit_code == 0
    assert record.end.counts["ticks"] == TICKS


@pytest.mark.parametrize("rows", [0, 1, 5, 70_001])
@pytest.mark.parametrize("row_type", [TICK_ROW, FRAME_ROW], ids=["ticks", "frames"])
def test_a_batch_has_the_bytes_that_arrow_itself_writes(row_type: np.dtype, rows: int) -> None:
    axes = ("azimuth", "elevation")
    given_rows = np.frombuffer(np.random.default_rng(rows).bytes(rows * row_type.itemsize), row_type)
    header, batch = header_bytes(row_type, axes), batch_bytes(given_rows)
    (found,) = pa.ipc.open_stream(header + batch + END_OF_STREAM)
    found.validate(full=True)
    assert bytes(found.schema.serialize()) == header and bytes(found.serialize()) == batch
    assert found.column(0).to_pylist() == given_rows[row_type.names[0]].tolist()


@settings(max_examples=40, deadline=None)
@given(data=st.data(), name=st.sampled_from(["ticks.arrow", "frames.arrow", "events.jsonl"]))
def test_a_log_cut_at_any_byte_keeps_every_whole_batch_before_the_cut(
    recorded: Path, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject, name: str
) -> None:
    folder = copy_of(recorded, tmp_path_factory.mktemp("cut"))
    whole = open_run(recorded)
    size = (folder / name).stat().st_size
    cut = data.draw(st.integers(0, size))
    os.truncate(folder / name, cut)
    run = open_run(folder)
    assert same_rows(run.ticks, whole.ticks[: len(run.ticks)])
    assert same_rows(run.frames, whole.frames[: len(run.frames)])
    assert run.events == whole.events[: len(run.events)]
    assert run.replayable_ticks <= len(run.ticks)
    if run.replayable_ticks:
        needed = whole.frames["tick"] <= run.ticks["tick"][run.replayable_ticks - 1]
        assert len(run.frames) >= np.count_nonzero(needed)
    if name == "ticks.arrow":
        batch = size / (TICKS / 100)
        assert len(run.ticks) >= 100 * ((cut // batch) - 1)
    if cut < size - 8:
        assert run.notes


@settings(max_examples=40, deadline=None)
@given(data=st.data(), name=st.sampled_from(["ticks.arrow", "frames.arrow"]))
def test_bytes_overwritten_anywhere_lose_the_batches_they_hit_or_fail_the_row_check(
    recorded: Path, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject, name: str
) -> None:
    folder = copy_of(recorded, tmp_path_factory.mktemp("hit"))
    content = bytearray((folder / name).read_bytes())
    at = data.draw(st.integers(0, len(content) - 1))
    noise = data.draw(st.binary(min_size=1, max_size=40))
    content[at : at + len(noise)] = noise
    (folder / name).write_bytes(content)
    try:
        run = open_run(folder)
    except BadInputError as error:
        assert name in error.where
        return
    whole = open_run(recorded)
    for found, kept, broken in (
        (run.ticks, whole.ticks, run.broken_ticks),
        (run.frames, whole.frames, run.broken_frames),
    ):
        sound = np.delete(found, broken)
        assert set(map(bytes, sound)) <= set(map(bytes, kept))
    assert len(run.ticks) >= TICKS - 200


@pytest.mark.parametrize("content", [b"", b"\0" * 4096, b"PK\x03\x04 not ours", b"time_s,outer.torque\n0,1\n"])
@pytest.mark.parametrize("name", ["ticks.arrow", "frames.arrow"])
def test_a_foreign_file_in_the_place_of_a_stream_is_refused_by_name(
    recorded: Path, tmp_path: Path, name: str, content: bytes
) -> None:
    folder = copy_of(recorded, tmp_path)
    (folder / name).write_bytes(content)
    if not content:
        assert len(open_run(folder).ticks if name == "ticks.arrow" else open_run(folder).frames) == 0
        return
    with pytest.raises(BadInputError, match=name):
        open_run(folder)


def test_the_stream_of_the_other_kind_is_refused(recorded: Path, tmp_path: Path) -> None:
    folder = copy_of(recorded, tmp_path)
    shutil.copy(folder / "frames.arrow", folder / "ticks.arrow")
    with pytest.raises(BadInputError, match=r"ticks\.arrow"):
        open_run(folder)


@pytest.mark.parametrize(
    ("key", "line"),
    [
        ("seed", "seed: many"),
        ("schema", "schema: 9"),
        ("period_ns", "period_ns: 0"),
        ("configuration", "configuration: 3"),
    ],
)
def test_a_wrong_value_in_run_yaml_is_refused_by_key(recorded: Path, tmp_path: Path, key: str, line: str) -> None:
    folder = copy_of(recorded, tmp_path)
    document = yaml_mapping((folder / "run.yaml").read_text(), "run.yaml", "a header")
    (folder / "run.yaml").write_text(
        yaml_text({name: value for name, value in document.items() if name != key}) + line + "\n"
    )
    with pytest.raises(BadInputError, match=rf"run\.yaml: {key}"):
        open_run(folder)


def test_a_folder_without_a_run_and_a_missing_one_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="is not a run folder"):
        open_run(tmp_path)
    with pytest.raises(BadInputError, match="does not exist"):
        open_run(tmp_path / "nowhere")


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_a_damaged_byte_in_the_events_costs_one_event_at_most(
    recorded: Path, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    folder = copy_of(recorded, tmp_path_factory.mktemp("event"))
    whole = open_run(recorded)
    content = bytearray((folder / "events.jsonl").read_bytes())
    at = data.draw(st.integers(0, len(content) - 1))
    content[at] ^= data.draw(st.integers(1, 255))
    (folder / "events.jsonl").write_bytes(content)
    run = open_run(folder)
    assert sum(event in run.events for event in whole.events) >= len(whole.events) - 1
    assert list(damage_of(run))


def test_nothing_is_overwritten_without_force(recorded: Path, tmp_path: Path) -> None:
    folder = copy_of(recorded, tmp_path)
    before = (folder / "ticks.arrow").read_bytes()
    with pytest.raises(BadInputError, match="--force"):
        RunWriter(folder, HEADER)
    assert (folder / "ticks.arrow").read_bytes() == before
    RunWriter(folder, HEADER, force=True).close()
    assert len(open_run(folder).ticks) == 0


def test_a_run_is_readable_while_it_goes_on(tmp_path: Path) -> None:
    writer = record_run(tmp_path / "run", 250, close=False, flush_every=100)
    run = open_run(tmp_path / "run")
    assert len(run.ticks) == 200
    assert run.record.end is None
    writer.close(130, "interrupted")
    run = open_run(tmp_path / "run")
    assert len(run.ticks) == 250
    assert run.record.end is not None and (run.record.end.exit_code, run.record.end.reason) == (130, "interrupted")


def test_the_writer_flushes_by_the_clock_and_by_the_number_of_ticks(tmp_path: Path) -> None:
    now = [0]
    writer = RunWriter(tmp_path / "run", HEADER, clock_ns=lambda: now[0])
    writer.append_ticks(tick_rows(10))
    assert len(open_run(tmp_path / "run").ticks) == 0
    now[0] = 250_000_000
    writer.append_ticks(tick_rows(1))
    assert len(open_run(tmp_path / "run").ticks) == 11
    writer.append_ticks(tick_rows(20_000))
    assert len(open_run(tmp_path / "run").ticks) == 20_011
    writer.close()


def test_the_content_hash_leaves_out_the_wall_clock_and_nothing_else(tmp_path: Path) -> None:
    def hashes(name: str, change: str = "", frame: int = 0) -> dict[str, str]:
        writer = RunWriter(tmp_path / name, HEADER)
        rows, frames = row_of(0), np.zeros(1, FRAME_ROW)
        if change:
            rows[change] += 1
        frames["payload"] = frame
        writer.append_frames(frames)
        writer.append_ticks(rows)
        writer.close()
        run = open_run(tmp_path / name)
        assert (
            run.record.end is not None
            and {part: run.record.end.hashes[part] for part in ("ticks", "frames")} == run.content_hashes()
        )
        return run.content_hashes()

    plain = hashes("plain")
    for column in ("wake_latency_ns", "computing_ns", "miss_cause"):
        assert hashes(column, column) == plain
    for column in ("time_ns", "torque_inner", "segment", "host_state", "rejected_frames"):
        assert hashes(column, column)["ticks"] != plain["ticks"]
    assert hashes("frame", frame=1)["frames"] != plain["frames"]


def test_the_hash_does_not_depend_on_where_batches_are_cut(recorded: Path, tmp_path: Path) -> None:
    record_run(tmp_path / "run", TICKS)
    other, run = open_run(tmp_path / "run"), open_run(recorded)
    assert other.content_hashes() == run.content_hashes()
    assert other.record.end is not None and run.record.end is not None
    assert other.record.end.hashes == run.record.end.hashes


def test_a_disk_that_fills_up_ends_the_recording_with_a_reason_and_a_readable_run(tmp_path: Path) -> None:
    script = f"""
        import resource, signal, sys
        sys.path.insert(0, {str(Path(__file__).parents[2])!r})
        from pathlib import Path
        from tests.runs.synthetic import Sender, device_block, host_block, row_of, HEADER
        from gimbal_hil.data.runs import RunWriter
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        writer = RunWriter(Path(sys.argv[1]), HEADER, clock_ns=lambda: 0)
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
        host, device = Sender(), Sender()
        for tick in range(2000):
            writer.append_exchange(tick, device_block(device, tick, tick - 1), host_block(host, tick))
            writer.append_ticks(row_of(tick))
            if tick % 100 == 99:
                writer.flush()
        print(writer.failure)
        writer.close(3, "safety stop")
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script), str(tmp_path / "run")], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "frames.arrow: File too large" in done.stdout
    run = open_run(tmp_path / "run")
    assert 0 < len(run.ticks) < 2000 and len(run.ticks) % 100 == 0
    assert run.replayable_ticks == len(run.ticks)
    assert any(event.kind is EventKind.RECORDING for event in run.events)
    assert not list(damage_of(run))
    assert run.record.end is not None and "recording ended early" in run.record.end.reason


def test_kill_9_loses_only_what_was_not_yet_flushed(tmp_path: Path) -> None:
    script = f"""
        import sys
        sys.path.insert(0, {str(Path(__file__).parents[2])!r})
        from pathlib import Path
        from tests.runs.synthetic import record_run
        writer = record_run(Path(sys.argv[1]), 450, close=False, flush_every=100)
        print("written", flush=True)
        sys.stdin.read()
    """
    process = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script), str(tmp_path / "run")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None and process.stdout.readline() == "written\n"
    process.send_signal(signal.SIGKILL)
    process.communicate()
    run = open_run(tmp_path / "run")
    assert len(run.ticks) == 400 == run.replayable_ticks
    assert any("no exit status" in note for note in run.notes)


def test_a_refused_folder_leaves_an_error_and_no_run(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(BadInputError, match="file"):
        RunWriter(tmp_path / "file" / "run", HEADER)


def test_an_exception_inside_the_run_is_its_exit_status(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), RunWriter(tmp_path / "run", HEADER):
        raise RuntimeError("the axis came loose")
    end = open_run(tmp_path / "run").record.end
    assert end is not None and (end.exit_code, end.reason) == (1, "the axis came loose")
    assert json.dumps(open_run(tmp_path / "run").record.hashes)


def test_writing_rows_imports_nothing_that_is_slow_to_import(tmp_path: Path) -> None:
    """The recorder writes its first rows while the antenna runs: a second of imports then is a second of silence."""
    script = (
        "import sys, numpy as np\n"
        "from gimbal_hil.data.runs import FRAME_ROW, TICK_ROW\n"
        "from gimbal_hil.data.runs.arrow_messages import batch_bytes\n"
        "for kind in (TICK_ROW, FRAME_ROW): assert batch_bytes(np.zeros(3, kind))\n"
        "print(sorted({'pandas', 'pyarrow', 'numba', 'scipy', 'plotly'} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_path_that_is_no_utf_8_is_recorded_so_that_every_reader_takes_it(tmp_path: Path) -> None:
    stray = os.fsdecode(b"caf\xe9.yaml")
    header = replace(HEADER, configuration={"model": stray}, command_line=("gimbal-hil", stray), title=stray)
    folder = tmp_path / os.fsdecode(b"\xff run")
    with RunWriter(folder, header) as writer:
        writer.event(0, 0, EventKind.NOTE, f"follows {stray}", {"file": stray})
    log = open_run(folder)
    assert log.record.header.title == log.record.header.configuration["model"] == "caf\\xe9.yaml"
    assert log.events[0].data == {"file": "caf\\xe9.yaml"} and not list(damage_of(log))
