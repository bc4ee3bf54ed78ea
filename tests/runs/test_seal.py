"""A finished run is sealed, a folder has one writer, and what is recorded is still there: each said where it is not
so.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firmware_protocol.documents import yaml_mapping, yaml_text
from firmware_protocol.errors import BadInputError, DamagedRunError, SafetyStopError
from gimbal_hil.data.runs import AXES, EventKind, GrowingLog, Retention, RunWriter, damage_of, open_run, replay
from gimbal_hil.data.runs.arrow_messages import batch_bytes, header_bytes
from gimbal_hil.data.runs.arrow_stream import END_OF_STREAM
from gimbal_hil.data.runs.chain import plain_hash
from gimbal_hil.data.runs.disk import MB
from gimbal_hil.data.signals import signals_of_run
from tests.runs.synthetic import HEADER, Sender, device_block, host_block, record_run, row_of

pytestmark = pytest.mark.realtime

TICKS = 500


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("seal") / "run"
    record_run(folder, TICKS, flush_every=100)
    return folder


@pytest.fixture
def copy(recorded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(recorded, tmp_path / "copy"))


def edit(folder: Path, **changes: Any) -> None:
    """Change keys of run.yaml, and their hashes too, as somebody would who has read how they are made."""
    document = yaml_mapping((folder / "run.yaml").read_text(), "run.yaml", "a header")
    document |= changes
    document["hashes"] |= {part: plain_hash(document[part]) for part in changes}
    (folder / "run.yaml").write_text(yaml_text(document))


def texts(folder: Path) -> str:
    return "\n".join(found.in_words() for found in damage_of(open_run(folder)))


def test_a_run_as_it_was_recorded_has_nothing_wrong_with_it(recorded: Path) -> None:
    run = open_run(recorded)
    assert not list(damage_of(run)) and not run.notes
    assert len(run.blocks) >= TICKS // 100 and run.blocks[-1].ticks == TICKS


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ("period_ns: 1000000", "period_ns: 2000000", "period_ns"),
        ("seed: 7", "seed: 8", "seed"),
        ("lockstep: true", "lockstep: false", "lockstep"),
        ("started_utc: '20", "started_utc: '19", "when"),
        ("ended_utc: '20", "ended_utc: '19", "when"),
        ("  python: ", "  python: 1.", "software"),
        ("  host: ", "  host: not-", "who"),
        ("title: ''", "title: mine", "title"),
        ("  code: 0", "  code: 3", "exit_status"),
        ("rate_hz: 1000", "rate_hz: 1001", "configuration"),
        ("name: made up", "name: real", "model"),
    ],
)
def test_every_number_in_run_yaml_is_held_to_its_hash(copy: Path, old: str, new: str, part: str) -> None:
    text = (copy / "run.yaml").read_text()
    assert old in text
    (copy / "run.yaml").write_text(text.replace(old, new, 1))
    assert f"the {part} of the run are not those whose hash run.yaml has" in texts(copy)


@pytest.mark.parametrize("part", ["period_ns", "seed", "software", "when", "who", "exit_status", "title"])
def test_a_part_that_was_changed_with_its_hash_breaks_the_seal(copy: Path, part: str) -> None:
    document = yaml_mapping((copy / "run.yaml").read_text(), "run.yaml", "a header")
    changed = {"period_ns": 2_000_000, "seed": 8, "title": "mine", "exit_status": {"code": 3, "reason": "x"}}
    edit(copy, **{part: changed.get(part) or {key: f"{value}1" for key, value in document[part].items()}})
    assert "sealed" in texts(copy)


def rows_left(folder: Path, name: str, keep: slice) -> None:
    """The stream with some rows only, made as the writer would make it."""
    run = open_run(folder)
    rows = (run.ticks if name == "ticks.arrow" else run.frames)[keep]
    (folder / name).write_bytes(header_bytes(rows.dtype, AXES) + batch_bytes(rows) + END_OF_STREAM)


@pytest.mark.parametrize("keep", [slice(0, 250), slice(250, None), slice(0, -1)])
def test_rows_taken_out_of_a_finished_run_are_missed_by_every_reader(copy: Path, keep: slice) -> None:
    rows_left(copy, "ticks.arrow", keep)
    assert "ticks that were recorded are missing" in texts(copy)
    with pytest.raises(DamagedRunError, match="the log is damaged"):
        signals_of_run(open_run(copy))


def test_events_taken_out_added_or_changed_are_seen(copy: Path, recorded: Path) -> None:
    lines = (recorded / "events.jsonl").read_bytes().splitlines(keepends=True)
    assert len(lines) >= 1
    (copy / "events.jsonl").write_bytes(b"".join(lines[:-1]))
    assert "1 events that were recorded are missing" in texts(copy)
    (copy / "events.jsonl").write_bytes(b"".join(lines) + lines[0])
    assert "1 events were added" in texts(copy)
    (copy / "events.jsonl").write_bytes(lines[0].replace(b'"tick": ', b'"tick": 1') + b"".join(lines[1:]))
    assert "events of the run are not those" in texts(copy)


def test_a_seal_that_was_taken_away_or_damaged_is_missed(copy: Path) -> None:
    chain = (copy / "chain.jsonl").read_bytes()
    (copy / "chain.jsonl").unlink()
    assert "the seal of the run is gone" in texts(copy)
    (copy / "chain.jsonl").write_bytes(chain[:-30] + b"\x00" + chain[-29:])
    assert "the seal of the run is damaged there" in texts(copy)
    (copy / "chain.jsonl").write_bytes(b"".join(chain.splitlines(keepends=True)[:-1]))
    assert texts(copy)


def test_a_run_from_before_there_was_a_seal_is_read_as_before(copy: Path) -> None:
    (copy / "chain.jsonl").unlink()
    document = yaml_mapping((copy / "run.yaml").read_text(), "run.yaml", "a header")
    del document["seal"]
    document["hashes"] = {
        key: document["hashes"][key] for key in ("configuration", "model", "ticks", "frames", "events")
    }
    (copy / "run.yaml").write_text(yaml_text(document))
    run = open_run(copy)
    assert not list(damage_of(run)) and not run.notes and len(run.ticks) == TICKS


def test_a_folder_that_is_recorded_into_is_locked_even_against_force(tmp_path: Path) -> None:
    writer = record_run(tmp_path / "run", 200, close=False, flush_every=100)
    before = (tmp_path / "run" / "ticks.arrow").read_bytes()
    with pytest.raises(BadInputError, match=f"recorded into by process {os.getpid()}"):
        RunWriter(tmp_path / "run", HEADER, force=True)
    assert (tmp_path / "run" / "ticks.arrow").read_bytes() == before
    writer.close()
    RunWriter(tmp_path / "run", HEADER, force=True).close()


def test_the_lock_of_a_killed_writer_is_free(tmp_path: Path) -> None:
    script = (
        "import sys, time; from pathlib import Path\n"
        "from tests.runs.synthetic import HEADER; from gimbal_hil.data.runs import RunWriter\n"
        "writer = RunWriter(Path(sys.argv[1]), HEADER); print('ready', flush=True); time.sleep(60)"
    )
    root = Path(__file__).parents[2]
    holder = subprocess.Popen([sys.executable, "-c", script, str(tmp_path / "run")], cwd=root, stdout=subprocess.PIPE)
    assert holder.stdout is not None and holder.stdout.readline() == b"ready\n"
    with pytest.raises(BadInputError, match=f"recorded into by process {holder.pid}"):
        RunWriter(tmp_path / "run", HEADER, force=True)
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    holder.stdout.close()
    RunWriter(tmp_path / "run", HEADER, force=True).close()


class Clock:
    """Nanoseconds that pass when the test says so."""

    def __init__(self) -> None:
        self.now_ns = 0

    def __call__(self) -> int:
        return self.now_ns


@pytest.mark.parametrize("what", ["removed", "replaced", "one file"])
def test_a_folder_that_is_taken_away_ends_the_recording_within_a_second(tmp_path: Path, what: str) -> None:
    clock = Clock()
    writer = RunWriter(tmp_path / "run", HEADER, clock_ns=clock)
    writer.append_ticks(row_of(0))
    writer.flush()
    if what == "one file":
        (tmp_path / "run" / "frames.arrow").unlink()
    else:
        shutil.rmtree(tmp_path / "run")
    if what == "replaced":
        record_run(tmp_path / "run", 10)
    clock.now_ns = 1_100_000_000
    writer.append_ticks(row_of(1))
    assert writer.failure is not None and str(tmp_path / "run") in writer.failure
    with pytest.raises(SafetyStopError, match="while it was recorded"):
        writer.require_room()
    writer.close()


def test_a_folder_that_is_taken_away_just_before_the_end_is_noticed_at_the_end(tmp_path: Path) -> None:
    with (
        pytest.raises(SafetyStopError, match="removed while it was recorded"),
        RunWriter(tmp_path / "run", HEADER) as writer,
    ):
        writer.append_ticks(row_of(0))
        shutil.rmtree(tmp_path / "run")


def test_a_disk_that_fills_is_said_and_then_ends_the_run_with_all_that_was_recorded(tmp_path: Path) -> None:
    clock = Clock()
    huge = 1e12
    writer = RunWriter(
        tmp_path / "run", HEADER, retention=Retention(warn_below_mb=huge, stop_below_mb=0.0), clock_ns=clock
    )
    clock.now_ns = 2_000_000_000
    writer.append_ticks(row_of(0))
    assert writer.is_low and writer.running_out is None
    writer._retention = Retention(warn_below_mb=huge, stop_below_mb=huge)
    clock.now_ns = 4_000_000_000
    writer.append_ticks(row_of(1))
    assert writer.running_out is not None and writer.failure is None
    with pytest.raises(SafetyStopError, match="stop_below_mb"):
        writer.require_room()
    writer.close(3, "the disk is nearly full")
    run = open_run(tmp_path / "run")
    assert len(run.ticks) == 2 and not list(damage_of(run))
    assert [event.kind for event in run.events] == [EventKind.RECORDING] * 2


def test_a_disk_that_is_too_full_from_the_start_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"are left on its disk; expected more than recording\.stop_below_mb"):
        RunWriter(tmp_path / "new" / "run", HEADER, retention=Retention(stop_below_mb=1e12))
    assert not (tmp_path / "new").exists()


def fill(writer: RunWriter, ticks: range) -> None:
    """Ticks with their frames, a flush every fifty."""
    host, device = Sender(), Sender()
    for tick in ticks:
        writer.append_exchange(tick, device_block(device, tick, tick - 1), host_block(host, tick))
        writer.append_ticks(row_of(tick))
        if tick % 50 == 49:
            writer.flush()


def test_a_log_in_segments_is_the_log_in_one_piece(tmp_path: Path) -> None:
    small = Retention(segment_mb=0.05)
    for name, retention in (("one", None), ("many", small)):
        writer = RunWriter(tmp_path / name, HEADER, retention=retention, clock_ns=lambda: 0)
        growing = GrowingLog(tmp_path / name)
        fill(writer, range(300))
        halfway = growing.look(0)
        fill(writer, range(300, 1000))
        assert (
            growing.look(0).ticks.tobytes() == open_run(tmp_path / name).ticks.tobytes() and len(halfway.ticks) == 300
        )
        writer.close()
    one, many = open_run(tmp_path / "one"), open_run(tmp_path / "many")
    assert (tmp_path / "many" / "ticks.0003.arrow").exists() and not (tmp_path / "one" / "ticks.0002.arrow").exists()
    assert many.ticks.tobytes() == one.ticks.tobytes() and many.frames.tobytes() == one.frames.tobytes()
    assert many.content_hashes() == one.content_hashes() and many.replayable_ticks == 1000
    assert not list(damage_of(many)) and not many.notes
    assert RunWriter(tmp_path / "many", HEADER, force=True).close() is None
    assert len(open_run(tmp_path / "many").ticks) == 0


def test_old_segments_are_given_up_and_the_rest_is_still_sealed(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", HEADER, retention=Retention(segment_mb=0.05, keep_mb=0.1), clock_ns=lambda: 0)
    fill(writer, range(2000))
    writer.close()
    size = sum(path.stat().st_size for path in (tmp_path / "run").glob("*.*"))
    assert 0.1 * MB < size < 0.25 * MB
    run = open_run(tmp_path / "run")
    assert run.ticks["tick"][-1] == 1999 and 100 < len(run.ticks) < 1500
    assert "given up" in " ".join(run.notes) and not list(damage_of(run))
    again = replay(run, None, lambda event: None)  # type: ignore[arg-type]
    assert not again.identical and again.difference is not None and "given up" in again.difference.reason
    value = np.float64(run.ticks["torque_outer"][-20]).tobytes()
    for path in (tmp_path / "run").glob("ticks.*.arrow"):
        path.write_bytes(path.read_bytes().replace(value, b"\1" * 8))
    assert list(damage_of(open_run(tmp_path / "run")))


def noisy(writer: RunWriter, ticks: range, with_rows: bool) -> None:
    """Ten events for every tick, as a bad line gives them, with or without the tick's row."""
    for tick in ticks:
        for _ in range(10):
            writer.event(tick, tick * 1_000_000, EventKind.LINK, "feedback ok to degraded", {"code": "link"})
        if with_rows:
            writer.append_ticks(row_of(tick))
        if tick % 10 == 9:
            writer.flush()


@pytest.mark.parametrize("with_rows", [True, False])
def test_events_are_given_up_with_their_segment_and_the_seal_of_the_rest_is_whole(
    tmp_path: Path, with_rows: bool
) -> None:
    folder = tmp_path / "run"
    writer = RunWriter(folder, HEADER, retention=Retention(segment_mb=0.1, keep_mb=0.2), clock_ns=lambda: 0)
    noisy(writer, range(1000), with_rows)
    writer.close()
    size = sum(path.stat().st_size for path in folder.glob("*.*"))
    assert 0.2 * MB < size < 0.45 * MB
    assert not (folder / "events.jsonl").exists() and not (folder / "chain.jsonl").exists()
    run = open_run(folder)
    ticks = [event.tick for event in run.events if event.kind is EventKind.LINK]
    assert ticks == [tick for tick in range(ticks[0], 1000) for _ in range(10)] and 100 < ticks[0] < 900
    assert not list(damage_of(run)), texts(folder)
    last_full = sorted(folder.glob("events.*.jsonl"))[-2]
    last_full.write_bytes(last_full.read_bytes().replace(b"ok to degraded", b"degraded to ok", 1))
    assert "of this block are not those that were sealed" in texts(folder)


def test_a_chain_in_segments_breaks_where_one_of_them_is_taken_out(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    writer = RunWriter(folder, HEADER, retention=Retention(segment_mb=0.05), clock_ns=lambda: 0)
    noisy(writer, range(300), with_rows=True)
    writer.close()
    assert not list(damage_of(open_run(folder))) and not open_run(folder).notes
    assert [event.tick for event in open_run(folder).events] == [tick for tick in range(300) for _ in range(10)]
    for number in ("", ".0002", ".0004"):
        part = folder / f"chain{number}.jsonl"
        content = part.read_bytes()
        part.unlink()
        assert texts(folder)
        part.write_bytes(content)
    assert not texts(folder)


def test_a_run_that_was_stopped_goes_on_in_its_segment_and_under_its_seal(tmp_path: Path) -> None:
    small = Retention(segment_mb=0.05)
    writer = RunWriter(tmp_path / "run", HEADER, retention=small, clock_ns=lambda: 0)
    fill(writer, range(400))
    mark = json.loads(json.dumps(writer.mark()))
    fill(writer, range(400, 900))
    writer._lock.release()  # as a kill would
    resumed = RunWriter.resumed(tmp_path / "run", HEADER, mark, retention=small, clock_ns=lambda: 0)
    fill(resumed, range(400, 700))
    resumed.close()
    run = open_run(tmp_path / "run")
    assert run.ticks["tick"].tolist() == list(range(700)) and not list(damage_of(run)) and not run.notes
