"""Replay: a run is what its log says, and one wrong bit is found and named by tick and signal."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from firmware_protocol.documents import yaml_mapping, yaml_text
from firmware_protocol.errors import BadInputError
from firmware_protocol.schema import BY_NAME
from gimbal_hil.data.runs import AXES, FRAME_ROW, TICK_ROW, open_run
from gimbal_hil.data.runs.arrow_messages import batch_bytes, header_bytes
from gimbal_hil.data.runs.arrow_stream import END_OF_STREAM
from gimbal_hil.data.runs.chain import plain_hash
from gimbal_hil.data.runs.integrity import seal
from gimbal_hil.data.runs.replaying import ReplayResult, replay
from gimbal_hil.realtime.lockstep import give_again, host_of
from gimbal_hil.surface.cli import app
from tests.runs.lockstep import WireFaults, record_lockstep

TICKS = 2600


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("replay") / "run"
    record_lockstep(folder, TICKS)
    return folder


@pytest.fixture
def copy(recorded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(recorded, tmp_path / "copy"))


def replay_of(folder: Path) -> ReplayResult:
    run = open_run(folder)
    host = host_of(run)
    return replay(run, host, lambda event: give_again(host, run, event))


def rewrite(path: Path, rows: NDArray[np.void]) -> None:
    path.write_bytes(header_bytes(rows.dtype, AXES) + batch_bytes(rows) + END_OF_STREAM)


def flip(rows: NDArray[np.void], row: int, column: str, bit: int) -> None:
    """Change one bit of one cell in place."""
    at = rows.dtype.fields[column][1]  # type: ignore[index]
    rows.view(np.uint8).reshape(len(rows), -1)[row, at + bit // 8] ^= 1 << (bit % 8)


def row_of_frame(rows: NDArray[np.void], name: str, tick: int) -> int:
    return int(np.flatnonzero((rows["identifier"] == BY_NAME[name].can_id) & (rows["tick"] == tick))[0])


def test_a_lockstep_run_is_replayed_bit_for_bit(recorded: Path) -> None:
    result = replay_of(recorded)
    assert result.identical and result.ticks == TICKS
    assert result.frames == len(open_run(recorded).frames)


def test_two_runs_of_equal_seed_have_equal_content(recorded: Path, tmp_path: Path) -> None:
    record_lockstep(tmp_path / "run", TICKS)
    assert open_run(tmp_path / "run").content_hashes() == open_run(recorded).content_hashes()


@pytest.mark.parametrize("seed", range(3))
def test_a_run_with_stalls_cuts_and_damaged_frames_is_replayed_bit_for_bit(tmp_path: Path, seed: int) -> None:
    faults = WireFaults(seed, 0.05, cuts=((1000, 1080), (2000, 2008)))
    record_lockstep(tmp_path / "run", 5000, faults=faults, stalls={800: 3, 1500: 200, 2500: 1})
    run = open_run(tmp_path / "run")
    assert run.ticks["skipped_ticks"].sum() == 204 and run.ticks["rejected_frames"].sum() > 20
    assert len(set(run.ticks["host_state"].tolist())) >= 5
    assert replay_of(tmp_path / "run").identical


@settings(max_examples=60)
@given(column=st.sampled_from([name for name in TICK_ROW.names or () if name != "check"]), data=st.data())
def test_one_flipped_bit_in_a_tick_row_is_named_by_tick_and_column(
    recorded: Path, tmp_path_factory: pytest.TempPathFactory, column: str, data: st.DataObject
) -> None:
    folder = Path(shutil.copytree(recorded, tmp_path_factory.mktemp("bit") / "copy"))
    rows = open_run(folder).ticks.copy()
    row, bit = data.draw(st.integers(0, TICKS - 1)), data.draw(st.integers(0, 8 * TICK_ROW[column].itemsize - 1))
    before = rows[row][column]
    flip(rows, row, column, bit)
    rewrite(folder / "ticks.arrow", rows)
    found = replay_of(folder).difference
    assert found is not None and (found.tick, found.signal) == (row, column)
    assert (found.expected, found.recorded) == (str(before.item()), str(rows[row][column].item()))


@settings(max_examples=60)
@given(data=st.data(), column=st.sampled_from(["payload", "payload", "payload", "identifier", "direction", "tick"]))
def test_one_flipped_bit_in_a_frame_is_named_by_tick_and_signal(
    recorded: Path, tmp_path_factory: pytest.TempPathFactory, column: str, data: st.DataObject
) -> None:
    folder = Path(shutil.copytree(recorded, tmp_path_factory.mktemp("bit") / "copy"))
    rows = open_run(folder).frames.copy()
    row, bit = data.draw(st.integers(0, len(rows) - 1)), data.draw(st.integers(0, 8 * FRAME_ROW[column].itemsize - 1))
    tick = int(rows["tick"][row])
    flip(rows, row, column, bit)
    rewrite(folder / "frames.arrow", rows)
    found = replay_of(folder).difference
    assert found is not None and found.tick == tick and "one bit is wrong" in found.reason
    if column == "payload":
        message = next(message for message in BY_NAME.values() if message.can_id == rows["identifier"][row])
        fields = [
            field.name
            for field in message.fields
            if message.start(field.name) <= bit < message.start(field.name) + field.bits
        ]
        part = fields[0] if fields else "counter" if 48 <= bit < 52 else "crc" if bit >= 52 else ""
        assert found.signal == f"{message.name}.{part}" if part else found.signal.startswith(message.name)
    else:
        assert found.signal.endswith(f".{column}")


@settings(max_examples=60)
@given(name=st.sampled_from(["ticks.arrow", "frames.arrow", "events.jsonl", "run.yaml"]), data=st.data())
def test_a_bit_flipped_anywhere_in_a_file_is_found_unless_the_run_reads_the_same(
    recorded: Path, tmp_path_factory: pytest.TempPathFactory, name: str, data: st.DataObject
) -> None:
    folder = Path(shutil.copytree(recorded, tmp_path_factory.mktemp("bit") / "copy"))
    content = bytearray((folder / name).read_bytes())
    at = data.draw(st.integers(0, len(content) - 1))
    content[at] ^= 1 << data.draw(st.integers(0, 7))
    (folder / name).write_bytes(content)
    try:
        result = replay_of(folder)
    except BadInputError:
        return
    if result.identical:
        run, whole = open_run(folder), open_run(recorded)
        assert run.ticks.tobytes() == whole.ticks.tobytes() and run.frames.tobytes() == whole.frames.tobytes()
        assert run.events == whole.events
        assert (run.record.header.configuration, run.record.header.model) == (
            whole.record.header.configuration,
            whole.record.header.model,
        )


def test_a_changed_frame_with_a_fresh_check_is_found_by_running_it(copy: Path) -> None:
    rows = open_run(copy).frames.copy()
    flip(rows, row_of_frame(rows, "feedback_outer", 900), "payload", 3)
    seal(rows)
    rewrite(copy / "frames.arrow", rows)
    found = replay_of(copy).difference
    assert found is not None and found.tick == 900
    assert "feedback_outer in the log fails its CRC" in found.reason


def test_a_changed_set_point_with_a_fresh_check_is_named_with_both_values(copy: Path) -> None:
    rows = open_run(copy).frames.copy()
    row = row_of_frame(rows, "set_point", 500)
    before = int(rows["payload"][row])
    flip(rows, row, "payload", 2)
    seal(rows)
    rewrite(copy / "frames.arrow", rows)
    found = replay_of(copy).difference
    assert found is not None and (found.tick, found.signal) == (500, "set_point.torque_outer")
    raw = (before & 0x3FFFF) - ((before & 0x20000) << 1)
    assert found.expected == f"{raw * 0.125e-3:.9g} N m" and found.recorded == f"{(raw ^ 4) * 0.125e-3:.9g} N m"


def test_a_changed_reference_with_a_fresh_check_is_named(copy: Path) -> None:
    rows = open_run(copy).ticks.copy()
    rows["torque_inner"][1000] = np.nextafter(rows["torque_inner"][1000], 9.0)
    seal(rows)
    rewrite(copy / "ticks.arrow", rows)
    found = replay_of(copy).difference
    assert found is not None and (found.tick, found.signal) == (1000, "torque_inner")


def test_a_frame_left_out_added_or_exchanged_is_found_at_its_tick(copy: Path) -> None:
    whole = open_run(copy).frames.copy()
    row = row_of_frame(whole, "set_point", 700)
    for rows in (np.delete(whole, row), np.insert(whole, row, whole[row])):
        rewrite(copy / "frames.arrow", rows)
        found = replay_of(copy).difference
        assert found is not None and (found.tick, found.signal) == (700, "frames sent")


def test_rows_cut_out_of_the_middle_are_found_at_the_first_missing_tick(copy: Path) -> None:
    rewrite(copy / "ticks.arrow", np.delete(open_run(copy).ticks, range(1200, 1230)))
    found = replay_of(copy).difference
    assert found is not None and (found.tick, found.signal) == (1200, "tick")


def test_a_changed_command_or_configuration_is_found(copy: Path) -> None:
    events = (copy / "events.jsonl").read_text()
    (copy / "events.jsonl").write_text(events.replace("0.30000000000000004", "0.3"))
    found = replay_of(copy).difference
    assert found is not None and found.tick > 1900
    (copy / "events.jsonl").write_text(events.replace("segment 1 started", "segment 9 started"))
    found = replay_of(copy).difference
    assert found is not None and (found.tick, found.signal) == (-1, "events")
    (copy / "events.jsonl").write_text(events)
    document = (copy / "run.yaml").read_text()
    (copy / "run.yaml").write_text(document.replace("kp_s_per_rad: 60.0", "kp_s_per_rad: 60.5"))
    assert not replay_of(copy).identical


@settings(max_examples=15)
@given(data=st.data(), name=st.sampled_from(["ticks.arrow", "frames.arrow"]))
def test_what_is_left_of_a_cut_log_is_still_identical(
    tmp_path_factory: pytest.TempPathFactory, recorded: Path, data: st.DataObject, name: str
) -> None:
    folder = Path(shutil.copytree(recorded, tmp_path_factory.mktemp("cut") / "copy"))
    whole = open_run(recorded)
    content = {"ticks.arrow": whole.ticks, "frames.arrow": whole.frames}[name]
    for file, rows in (("ticks.arrow", whole.ticks), ("frames.arrow", whole.frames)):
        batches = [batch_bytes(rows[rows["tick"] // 100 == part]) for part in range(TICKS // 100)]
        (folder / file).write_bytes(header_bytes(rows.dtype, AXES) + b"".join(batches) + END_OF_STREAM)
    finished = data.draw(st.booleans())
    if not finished:
        document = yaml_mapping((folder / "run.yaml").read_text(), "run.yaml", "a header")
        document |= {"exit_status": None, "log": None, "seal": None}
        document["when"]["ended_utc"] = None
        document["hashes"] |= {part: plain_hash(document[part]) for part in ("exit_status", "log", "when")}
        (folder / "run.yaml").write_text(yaml_text(document))
    size = (folder / name).stat().st_size
    first = len(header_bytes(content.dtype, AXES)) + len(batch_bytes(content[content["tick"] // 100 == 0]))
    cut = data.draw(st.integers(first, size))
    os.truncate(folder / name, cut)
    result = replay_of(folder)
    lost = len(open_run(folder).ticks) < len(whole.ticks) or len(open_run(folder).frames) < len(whole.frames)
    if finished and lost:
        assert result.difference is not None and "that were recorded are missing" in result.difference.reason
        return
    assert result.identical
    assert result.ticks >= TICKS * cut / size - 300


def test_a_run_without_a_single_whole_batch_cannot_be_replayed(copy: Path) -> None:
    os.truncate(copy / "frames.arrow", 900)
    with pytest.raises(BadInputError, match="holds no whole batch"):
        replay_of(copy)


def test_a_run_that_kept_no_frames_cannot_be_replayed(tmp_path: Path, copy: Path) -> None:
    text = (copy / "run.yaml").read_text()
    (copy / "run.yaml").write_text(text.replace("frames: true", "frames: false"))
    with pytest.raises(BadInputError, match="does not keep every frame"):
        replay_of(copy)


def test_the_command_answers_0_1_and_2(
    recorded: Path, copy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert app.run("replay", [str(recorded)]) == 0
    assert capsys.readouterr().out.startswith(f"identical: {TICKS} ticks")
    rows = open_run(copy).frames.copy()
    flip(rows, row_of_frame(rows, "feedback_inner", 777), "payload", 1)
    rewrite(copy / "frames.arrow", rows)
    assert app.run("replay", [str(copy), "--json", "--out", str(tmp_path / "answer")]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert (answer["difference"]["tick"], answer["difference"]["signal"]) == (777, "feedback_inner.position")
    assert json.loads((tmp_path / "answer" / "replay.json").read_text()) == answer
    for arguments in ([str(tmp_path / "nothing")], [str(recorded), "--out", str(tmp_path / "answer")]):
        with pytest.raises(SystemExit) as ended:
            app.run("replay", arguments)
        assert ended.value.code == 2
        assert capsys.readouterr().err.count("\n") == 1
