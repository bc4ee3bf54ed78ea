"""Exports open in other people's tools and hold the run's numbers."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from xml.etree import ElementTree

import can
import cantools
import numpy as np
import pyarrow.parquet
import pytest
from numpy.typing import NDArray
from scipy.io import loadmat

from firmware_protocol.schema import BY_CAN_ID, BY_NAME
from gimbal_hil.data.runs import open_run
from gimbal_hil.data.runs.frame_columns import columns_of
from gimbal_hil.data.signals import read_signals, signals_of_run
from gimbal_hil.loop.host import HostState
from gimbal_hil.surface.cli import app
from tests.runs.lockstep import WireFaults, record_lockstep
from tests.runs.synthetic import record_run, row_of

DBC = Path(sys.modules["firmware_protocol"].__file__ or "").parent / "gimbal.dbc"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("export") / "run"
    record_run(folder, 1200, row=with_states)
    return folder


def with_states(tick: int) -> NDArray[np.void]:
    """A made-up tick row; the host follows positions from tick 600 on, and has no reference before."""
    row = row_of(tick)
    row["host_state"] = HostState.ACTIVE if tick >= 600 else HostState.WAITING
    row["position_ref_outer"] = row["position_ref_inner"] = 0.1 if tick >= 600 else np.nan
    return row


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
    database = cantools.database.load_file(DBC)
    name = "feedback_outer"
    wanted = columns_of(frames, name).physical("position")
    kind = next(message for message in database.messages if message.frame_id == BY_NAME[name].can_id)
    signal = next(signal.name for signal in kind.signals if "position" in signal.name.lower())
    found = [kind.decode(message.data)[signal] for message in messages if message.arbitration_id == kind.frame_id]
    assert found == pytest.approx(wanted, rel=1e-12)


def mcap_records(path: Path) -> list[tuple[str, int, dict[str, object], dict[str, object]]]:
    """(topic, log time, content, schema) of every record, read by the mcap package."""
    reading = pytest.importorskip("mcap.reader", reason="the extra mcap is not installed")
    with path.open("rb") as file:
        return [
            (channel.topic, message.log_time, json.loads(message.data), json.loads(schema.data))
            for schema, channel, message in reading.make_reader(file).iter_messages()
        ]


def test_an_mcap_export_holds_signals_every_good_frame_and_every_tick(recorded: Path, tmp_path: Path) -> None:
    assert export(recorded, "mcap", tmp_path / "log.mcap") == 0
    run, records = open_run(recorded), mcap_records(tmp_path / "log.mcap")
    torque = [content["torque_outer"] for topic, _, content, _ in records if topic == "/set_point"]
    assert torque == columns_of(run.frames, "set_point").physical("torque_outer").tolist()
    ticks = [content for topic, _, content, _ in records if topic == "/host"]
    assert [content["tick"] for content in ticks] == run.ticks["tick"].tolist()
    reference = run.ticks["position_ref_outer"][1000]
    assert ticks[0]["position_ref_outer"] is None and ticks[1000]["position_ref_outer"] == reference
    assert (ticks[0]["host_state"], ticks[1000]["host_state"]) == ("waiting", "active")
    table = signals_of_run(run)
    outer = [content["position"] for topic, _, content, _ in records if topic == "/outer"]
    assert outer == table.position("outer").tolist()
    signals = len(table) * len({name.partition(".")[0] for name in table.columns})
    assert len(records) == signals + len(run.frames) + len(run.ticks)
    times = [time_ns for topic, time_ns, _, _ in records if topic == "/drive_status"]
    assert set(np.diff(times)) == {1_000_000}
    assert [time_ns for _, time_ns, _, _ in records] == sorted(time_ns for _, time_ns, _, _ in records)


def test_every_record_of_an_mcap_is_valid_against_the_schema_beside_it(recorded: Path, tmp_path: Path) -> None:
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed (the extra test has it)")
    assert export(recorded, "mcap", tmp_path / "log.mcap") == 0
    validators: dict[str, object] = {}
    kinds = set()
    # all of the topics that have states and open loops, and one in so many of the others
    for place, (topic, _, content, schema) in enumerate(mcap_records(tmp_path / "log.mcap")):
        if topic not in validators:
            jsonschema.Draft202012Validator.check_schema(schema)
            validators[topic] = jsonschema.Draft202012Validator(schema)
        if topic in ("/host", "/drive_status", "/drive_event") or place % 20 == 0:
            validators[topic].validate(content)  # type: ignore[attr-defined]
            kinds.add(topic)
    assert kinds == set(validators) and {"/outer", "/feedback_inner"} <= kinds
    unit = validators["/outer"].schema["properties"]["rate"]  # type: ignore[attr-defined]
    assert unit == {"type": "number", "description": "rad/s"}


def test_an_mf4_export_is_opened_by_asammdf_with_units_and_names_of_values(recorded: Path, tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf", reason="the extra mf4 is not installed")
    assert export(recorded, "mf4", tmp_path / "log.mf4") == 0
    run = open_run(recorded)
    with asammdf.MDF(tmp_path / "log.mf4") as file:
        rate, torque = file.get("feedback_inner.rate"), file.get("host.torque_outer")
        state, position = file.get("host.host_state"), file.get("outer.position")
    assert np.array_equal(rate.samples, columns_of(run.frames, "feedback_inner").physical("rate"))
    assert (rate.unit, torque.unit, position.unit) == ("rad/s", "N m", "rad")
    assert np.array_equal(torque.samples, run.ticks["torque_outer"])
    assert torque.timestamps == pytest.approx(run.ticks["tick"] * 1e-3)
    assert np.array_equal(position.samples, signals_of_run(run).position("outer"))
    assert {bytes(name).decode() for name in state.samples} == {
        HostState(value).name.lower() for value in np.unique(run.ticks["host_state"])
    }


def test_a_mat_export_is_read_by_scipy_with_structs_spelled_as_the_signals_are(recorded: Path, tmp_path: Path) -> None:
    assert export(recorded, "mat", tmp_path / "log.mat") == 0
    table, found = signals_of_run(open_run(recorded)), loadmat(tmp_path / "log.mat", simplify_cells=True)
    assert np.array_equal(found["time_s"], table.time_s)
    for column, values in table.columns.items():
        group, _, name = column.partition(".")
        assert np.array_equal(found[group][name], values)
    assert found["units"]["outer"]["rate"] == "rad/s" and found["units"]["time_s"] == "s"


def test_a_signal_has_one_name_and_one_unit_in_every_format(recorded: Path, tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf", reason="the extra mf4 is not installed")
    for kind in ("csv", "parquet", "mcap", "mf4", "mat"):
        assert export(recorded, kind, tmp_path / f"log.{kind}") == 0
    names = list(signals_of_run(open_run(recorded)).columns)
    described = json.loads((tmp_path / "log.csv-metadata.json").read_text())["tableSchema"]["columns"]
    csv = {one["name"]: one.get("schema:unitText", "") for one in described}
    parquet = {
        field.name: field.metadata[b"unit"].decode() for field in pyarrow.parquet.read_schema(tmp_path / "log.parquet")
    }
    mcap = {
        f"{topic[1:]}.{name}": content.get("description", "")
        for topic, _, _, schema in mcap_records(tmp_path / "log.mcap")
        for name, content in schema["properties"].items()  # type: ignore[attr-defined]
    }
    with asammdf.MDF(tmp_path / "log.mf4") as file:
        mf4 = {name: file.get(name).unit for name in names}
    units = loadmat(tmp_path / "log.mat", simplify_cells=True)["units"]
    mat = {f"{group}.{name}": unit for group in ("outer", "inner", "base") for name, unit in units[group].items()}
    header = (tmp_path / "log.csv").read_text().splitlines()[0].split(",")
    assert header == ["time_s", *names]
    for name in names:
        assert csv[name] == parquet[name] == mcap[name] == mf4[name] == mat[name] != "", name


def test_layouts_draw_signals_that_are_in_the_file(recorded: Path, tmp_path: Path) -> None:
    assert export(recorded, "mcap", tmp_path / "log.mcap", "--layouts") == 0
    there = {
        (topic, name)
        for topic, _, _, schema in mcap_records(tmp_path / "log.mcap")
        for name in schema["properties"]  # type: ignore[attr-defined]
    }
    foxglove = json.loads((tmp_path / "log.foxglove.json").read_text())
    drawn = [path["value"] for panel in foxglove["configById"].values() for path in panel["paths"]]
    assert len(drawn) >= 8 and all(tuple(value.split(".")) in there for value in drawn)
    placed = json.dumps(foxglove["layout"])
    assert all(f'"{name}"' in placed for name in foxglove["configById"])
    curves = [node.get("name") for node in ElementTree.parse(tmp_path / "log.plotjuggler.xml").iter("curve")]
    assert len(curves) >= 6 and all((f"/{name.split('/')[1]}", name.split("/")[2]) in there for name in curves if name)
    with pytest.raises(SystemExit):
        export(recorded, "csv", tmp_path / "log.csv", "--layouts")


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
    beside = ["log.bin-metadata.json"] if kind == "csv" else []
    assert out.stat().st_size > 1000 and sorted(path.name for path in tmp_path.iterdir()) == ["log.bin", *beside]


@pytest.mark.parametrize(
    ("kind", "package", "extra"),
    [("mcap", "mcap.writer", "mcap"), ("mf4", "asammdf", "mf4"), ("ros2", "rosbags.rosbag2", "bags")],
)
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
