"""Exports open in other people's tools and hold the run's numbers."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import can
import cantools
import numpy as np
import pytest

from firmware_protocol.schema import BY_CAN_ID, BY_NAME
from gimbal_hil.cli import app
from gimbal_hil.runs import open_run
from gimbal_hil.runs.frame_columns import columns_of
from gimbal_hil.signals import read_signals, signals_of_run
from tests.runs.lockstep import WireFaults, record_lockstep

DBC = Path(sys.modules["firmware_protocol"].__file__ or "").parent / "gimbal.dbc"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("export") / "run"
    record_lockstep(folder, 1200)
    return folder


def export(run: Path, kind: str, out: Path, *more: str) -> int:
    return app.run("export", [str(run), "--format", kind, "--out", str(out), *more])


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_a_table_export_is_a_signals_table_with_the_run_s_numbers(recorded: Path, tmp_path: Path, kind: str) -> None:
    assert export(recorded, kind, tmp_path / f"log.{kind}") == 0
    table, expected = read_signals(tmp_path / f"log.{kind}", ("outer", "inner")), signals_of_run(open_run(recorded))
    assert list(table.columns) == list(expected.columns) and table.notes == ()
    assert all(np.array_equal(table.columns[name], expected.columns[name]) for name in table.columns)


def test_a_blf_export_is_read_by_python_can_and_decoded_by_cantools_to_the_same_numbers(
    recorded: Path, tmp_path: Path
) -> None:
    assert export(recorded, "blf", tmp_path / "log.blf") == 0
    frames = open_run(recorded).frames
    with can.LogReader(tmp_path / "log.blf") as reader:
        messages = [message for message in reader if isinstance(message, can.Message)]
    assert [message.arbitration_id for message in messages] == frames["identifier"].tolist()
    assert b"".join(bytes(message.data) for message in messages) == np.ascontiguousarray(frames["payload"]).tobytes()
    assert [message.is_rx for message in messages] == (frames["direction"] == 1).tolist()
    times = np.array([message.timestamp for message in messages])
    assert np.abs(times - times[0] - (frames["tick"] - frames["tick"][0]) * 1e-3).max() < 2e-6
    if not DBC.exists():
        pytest.skip("gimbal.dbc is not there yet")
    database = cantools.database.load_file(DBC)
    name = "feedback_outer"
    wanted = columns_of(frames, name).physical("position")
    kind = next(message for message in database.messages if message.frame_id == BY_NAME[name].can_id)
    signal = next(signal.name for signal in kind.signals if "position" in signal.name.lower())
    found = [kind.decode(message.data)[signal] for message in messages if message.arbitration_id == kind.frame_id]
    assert found == pytest.approx(wanted, rel=1e-12)


def test_an_mcap_export_holds_every_good_frame_decoded_and_every_tick(recorded: Path, tmp_path: Path) -> None:
    reading = pytest.importorskip("mcap.reader", reason="the extra mcap is not installed")
    assert export(recorded, "mcap", tmp_path / "log.mcap") == 0
    run = open_run(recorded)
    with (tmp_path / "log.mcap").open("rb") as file:
        records = [
            (channel.topic, message.log_time, json.loads(message.data))
            for _, channel, message in reading.make_reader(file).iter_messages()
        ]
    torque = [content["torque_outer_nm"] for topic, _, content in records if topic == "/set_point"]
    assert torque == columns_of(run.frames, "set_point").physical("torque_outer").tolist()
    ticks = [content for topic, _, content in records if topic == "/tick"]
    assert [content["tick"] for content in ticks] == run.ticks["tick"].tolist()
    assert (
        ticks[0]["position_ref_outer"] is None
        and ticks[1000]["position_ref_outer"] == run.ticks["position_ref_outer"][1000]
    )
    assert len(records) == len(run.frames) + len(run.ticks)
    times = [time_ns for topic, time_ns, _ in records if topic == "/drive_status"]
    assert set(np.diff(times)) == {1_000_000}


def test_an_mf4_export_is_opened_by_asammdf_with_physical_values(recorded: Path, tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf", reason="the extra mf4 is not installed")
    assert export(recorded, "mf4", tmp_path / "log.mf4") == 0
    run = open_run(recorded)
    with asammdf.MDF(tmp_path / "log.mf4") as file:
        rate = file.get("feedback_inner.rate")
        torque = file.get("host.torque_outer")
    assert (
        np.array_equal(rate.samples, columns_of(run.frames, "feedback_inner").physical("rate")) and rate.unit == "rad/s"
    )
    assert np.array_equal(torque.samples, run.ticks["torque_outer"])
    assert torque.timestamps == pytest.approx(run.ticks["tick"] * 1e-3)


def test_damaged_frames_are_in_the_blf_and_not_among_decoded_values(tmp_path: Path) -> None:
    record_lockstep(tmp_path / "run", 1500, faults=WireFaults(2, 0.2))
    frames = open_run(tmp_path / "run").frames
    known = np.isin(frames["identifier"], list(BY_CAN_ID)) & (frames["identifier"] < 0x800)
    decoded = sum(len(columns_of(frames, name).place) for name in BY_NAME)
    assert decoded < np.count_nonzero(known)
    assert export(tmp_path / "run", "blf", tmp_path / "log.blf") == 0
    with can.LogReader(tmp_path / "log.blf") as reader:
        assert sum(1 for _ in reader) == np.count_nonzero(frames["identifier"] < 0x800)


def test_missing_rows_are_refused_or_repaired_as_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record_lockstep(tmp_path / "run", 600, faults=WireFaults(1, 0.1))
    with pytest.raises(SystemExit) as ended:
        export(tmp_path / "run", "csv", tmp_path / "log.csv")
    assert ended.value.code == 2 and not (tmp_path / "log.csv").exists()
    assert "--resample" in capsys.readouterr().err
    assert export(tmp_path / "run", "csv", tmp_path / "log.csv", "--resample", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["rows"] > 500 and answer["notes"]
    assert len(read_signals(tmp_path / "log.csv", ("outer", "inner"))) == answer["rows"]


@pytest.mark.parametrize("kind", ["csv", "blf", "mf4"])
def test_an_export_replaces_nothing_without_force_and_leaves_nothing_else(
    recorded: Path, tmp_path: Path, kind: str
) -> None:
    if kind == "mf4":
        pytest.importorskip("asammdf", reason="the extra mf4 is not installed")
    out = tmp_path / "log.bin"
    out.write_text("mine")
    with pytest.raises(SystemExit) as ended:
        export(recorded, kind, out)
    assert ended.value.code == 2 and out.read_text() == "mine"
    assert export(recorded, kind, out, "--force") == 0
    assert out.stat().st_size > 1000 and [path.name for path in tmp_path.iterdir()] == ["log.bin"]


@pytest.mark.parametrize(("kind", "package", "extra"), [("mcap", "mcap.writer", "mcap"), ("mf4", "asammdf", "mf4")])
def test_an_absent_extra_is_named(
    recorded: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    kind: str,
    package: str,
    extra: str,
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(SystemExit) as ended:
        export(recorded, kind, tmp_path / "log")
    assert ended.value.code == 2
    assert f"pip install 'gimbal-hil[{extra}]'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
