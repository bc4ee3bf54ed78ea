"""Every container is recognised by its content and gives its columns, units and times; others are refused by name."""

from __future__ import annotations

import gzip
import json
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.containers import CONTAINERS, Contents, SampledGroup, contents_of, guess, survey
from gimbal_hil.data.containers.guessing import Found, guessed
from gimbal_hil.data.signals import ColumnMap, read_signals
from gimbal_hil.surface.checking import check_files
from tests.containers import written
from tests.containers.written import POSITION, ROWS, TIME, TORQUE, WRITTEN, words_of

#: the same message again, under another identifier
_DBC_OF_TWO = written.DBC + "".join(
    line.replace("272", "273").replace("Axis", "Axes") + "\n"
    for line in written.DBC.splitlines()
    if "272" in line or "SG_" in line
)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    found = {}
    for name, (write, _) in WRITTEN.items():
        folder = tmp_path_factory.mktemp(name.replace(".", "_"))
        found[name] = write(folder / name)
    return found


@pytest.mark.parametrize("name", WRITTEN)
def test_a_container_is_read_as_its_owner_wrote_it(files: dict[str, Path], name: str) -> None:
    columns = ColumnMap.of_words(words_of(WRITTEN[name][1]))
    # stamps of some are rounded, so that rows are put on a grid
    table = read_signals(files[name], ("joint",), columns=columns, resample=True)
    assert abs(len(table) - ROWS) <= 1 and abs(table.period_s - written.PERIOD_S) < 1e-5
    at = table.time_s - table.time_s[0]
    assert np.abs(table.position("joint") - np.interp(at, TIME, POSITION)).max() < 2e-3
    inside = np.abs(np.cos(2.0 * at)) > 0.05
    assert np.abs(table.torque("joint") - np.interp(at, TIME, TORQUE))[inside].max() < 6e-3


@pytest.mark.parametrize("name", WRITTEN)
def test_check_guesses_the_columns_that_would_read_a_container(files: dict[str, Path], name: str) -> None:
    (seen,) = check_files([files[name]], ("joint",))
    assert not seen.faults and f"{ROWS} rows over 1.996 s" in seen.text and "--column" in seen.text
    table = read_signals(files[name], ("joint",), columns=ColumnMap.of_words(seen.reads_as), resample=True)
    # of several joints the first is taken where no name says which
    if "joint_states" not in seen.text and "observation" not in seen.text and name not in ("flight.ulg",):
        assert np.ptp(table.position("joint")) == pytest.approx(np.ptp(POSITION), rel=1e-3)
        assert np.ptp(table.torque("joint")) == pytest.approx(np.ptp(TORQUE), rel=0.05)


def test_joints_are_found_by_their_names(files: dict[str, Path]) -> None:
    contents = contents_of(files["bag"])
    assert contents is not None
    assert guess(contents, ("elbow",)) == (
        "elbow.position=/joint_states.position[elbow]",
        "elbow.torque=/joint_states.effort[elbow]",
    )


def test_stamps_of_the_header_count_and_not_when_the_recorder_wrote(files: dict[str, Path]) -> None:
    contents = contents_of(files["bag"])
    assert contents is not None
    (joints,) = (group for group in contents.groups if group.name == "/joint_states")
    assert joints.time_s is not None and np.abs(np.diff(joints.time_s) - written.PERIOD_S).max() < 1e-6


def test_the_storage_of_a_bag_is_read_without_its_folder(files: dict[str, Path], tmp_path: Path) -> None:
    (storage,) = files["bag"].glob("*.db3")
    whole, inside = contents_of(files["bag"]), contents_of(storage)
    # beside the metadata of another bag
    shutil.copy(files["bag"] / "metadata.yaml", tmp_path)
    alone = contents_of(Path(shutil.copy(storage, tmp_path / "elbow.db3")))
    assert whole is not None and inside is not None and alone is not None
    for one in (inside, alone):
        for group, same in zip(one.groups, whole.groups, strict=True):
            assert group.columns.keys() == same.columns.keys()
            np.testing.assert_array_equal(group.time_s, same.time_s)
            for name in same.columns:
                np.testing.assert_array_equal(group.columns[name], same.columns[name])


def test_units_of_the_file_are_applied_and_unknown_columns_refused_with_the_near_ones(files: dict[str, Path]) -> None:
    columns = ColumnMap.of_words(["joint.position=Axis.Angle", "joint.torque=Axis.Torque"])
    table = read_signals(files["bus.blf"], ("joint",), columns=columns, resample=True)
    assert np.ptp(table.position("joint")) == pytest.approx(np.ptp(POSITION), rel=1e-3)
    wrong = ColumnMap.of_words(["joint.position=Axis.Angel", "joint.torque=Axis.Torque"])
    with pytest.raises(BadInputError, match=r"no column 'Axis.Angel'.*perhaps Axis.Angle"):
        read_signals(files["bus.blf"], ("joint",), columns=wrong)


def test_torque_of_another_message_keeps_its_impulse(tmp_path: Path) -> None:
    """A command that is sent a tenth of a period after the position acts from then: nine tenths of it in that row."""
    from asammdf import MDF, Signal

    file = MDF(version="4.10")
    file.append([Signal(POSITION, TIME, name="q", unit="rad")])
    command = np.zeros(ROWS)
    command[200:] = 1.0
    file.append([Signal(command, TIME + 0.1 * written.PERIOD_S, name="u", unit="Nm")])
    file.save(tmp_path / "late.mf4")
    file.close()
    columns = ColumnMap.of_words(["joint.position=q", "joint.torque=u"])
    table = read_signals(tmp_path / "late.mf4", ("joint",), columns=columns)
    step = int(np.argmax(table.torque("joint") > 0.0))
    assert table.torque("joint")[step] == pytest.approx(0.9, abs=1e-6) and table.torque("joint")[step + 1] == 1.0
    assert any("held" in note for note in table.notes)


@pytest.mark.parametrize("signal", ["Angle", "Torque"])
def test_a_number_on_a_bus_that_nobody_measures_is_told_and_refused_and_spoils_no_other_row(
    tmp_path: Path, signal: str
) -> None:
    """Of one message the position, of another the torque, which acts from there to the next position."""
    (tmp_path / "bus.dbc").write_text(_DBC_OF_TWO)
    lines = []
    for k, (t, q, u) in enumerate(zip(TIME, POSITION, TORQUE, strict=True)):
        q, u = (1e30 if k == 200 and signal == one else value for one, value in (("Angle", q), ("Torque", u)))
        lines.append(f"({1000.0 + t:.6f}) can0 110#{struct.pack('<ff', q, 0.0).hex().upper()}")
        lines.append(f"({1000.001 + t:.6f}) can0 111#{struct.pack('<ff', 0.0, u).hex().upper()}")
    path = tmp_path / "bus.log"
    path.write_text("\n".join(lines) + "\n")
    (seen,) = check_files([path], ("joint",))
    assert "holds 1e+30 in row 201 (1 such rows in all)" in seen.text
    columns = ColumnMap.of_words(["joint.position=Axis.Angle", "joint.torque=Axes.Torque"])
    with pytest.raises(BadInputError, match=rf"row 200, column \w+.{signal}: .* rows without one: [12];"):
        read_signals(path, ("joint",), columns=columns)
    table = read_signals(path, ("joint",), columns=columns, resample=True)
    assert table.torque("joint")[300:310] == pytest.approx(TORQUE[300:310], abs=0.1)


def test_the_longest_episode_is_read_and_the_others_told(files: dict[str, Path]) -> None:
    columns = ColumnMap.of_words(words_of(WRITTEN["episodes.parquet"][1]))
    table = read_signals(files["episodes.parquet"], ("joint",), columns=columns, resample=True)
    assert any("episode 1 was read, the longest of 2" in note for note in table.notes)


@pytest.mark.parametrize(
    ("start", "said"),
    [
        (b"\x89HDF\r\n\x1a\n", "HDF5"),
        (b"TDSm", "TDMS"),
        (b"TLOG0003", "moteus"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "Excel workbook of the old kind"),
        (b"\x80\x04\x95", "pickle"),
        (b"SQLite format 3\0", "SQLite"),
    ],
)
def test_a_container_that_is_not_read_is_refused_by_its_name(tmp_path: Path, start: bytes, said: str) -> None:
    path = tmp_path / "log.dat"
    path.write_bytes(start + bytes(100))
    with pytest.raises(BadInputError, match=rf"log\.dat: is .*{said}.*not read; expected "):
        read_signals(path, ("joint",))


def test_a_can_recording_without_its_dbc_says_where_it_is_to_lie(files: dict[str, Path], tmp_path: Path) -> None:
    bare = tmp_path / "bus.asc"
    bare.write_bytes(files["bus.asc"].read_bytes())
    with pytest.raises(
        BadInputError, match=r"takes a DBC to read, and none lies beside it; expected the DBC as .*bus\.dbc"
    ):
        contents_of(bare)


def test_a_library_that_is_missing_is_one_line_with_its_extra(
    files: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    for name, package, extra in (("bag", "rosbags.highlevel", "bags"), ("flight.ulg", "pyulog", "ulog")):
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(BadInputError, match=rf"pip install 'gimbal-hil\[{extra}\]'"):
            contents_of(files[name])


def test_text_tables_are_no_containers(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("time_s,joint.torque,joint.position\n" + "".join(f"{t},0,0\n" for t in range(20)))
    assert contents_of(path) is None
    packed = tmp_path / "log.csv.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert contents_of(packed) is None


def test_every_container_stands_in_the_registry_once() -> None:
    assert len({one.name for one in CONTAINERS}) == len(CONTAINERS) >= 9


@pytest.mark.heavy
@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    name=st.sampled_from([name for name in WRITTEN if name not in ("bag", "bag.mcap")]),
    cut=st.floats(0.0, 1.0),
    flips=st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(1, 255)), max_size=4),
)
def test_a_damaged_container_is_refused_in_one_line_or_read(
    files: dict[str, Path], tmp_path_factory: pytest.TempPathFactory, name: str, cut: float, flips: list
) -> None:
    data = bytearray(files[name].read_bytes())
    data = data[: max(1, round(cut * len(data)))]
    for place, change in flips:
        data[min(len(data) - 1, int(place * len(data)))] ^= change
    folder = tmp_path_factory.mktemp("damaged")
    path = folder / name
    path.write_bytes(bytes(data))
    if name.startswith("bus"):
        path.with_suffix(".dbc").write_text(written.DBC)
    try:
        contents_of(path)
    except BadInputError as error:
        assert "\n" not in str(error)


_READ_ALL = """
import sys
from pathlib import Path
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.containers import contents_of
for name in sys.argv[1:]:
    try:
        contents_of(Path(name))
    except BadInputError as refused:
        print(refused)
"""


def test_what_a_library_says_when_it_drops_a_broken_file_is_not_printed(files: dict[str, Path], tmp_path: Path) -> None:
    cut = []
    for name, share in ((name, share) for name in WRITTEN if files[name].is_file() for share in (0.1, 0.6)):
        data = files[name].read_bytes()
        cut.append(tmp_path / f"{share}{name}")
        cut[-1].write_bytes(data[: round(share * len(data))])
    told = subprocess.run([sys.executable, "-c", _READ_ALL, *map(str, cut)], capture_output=True, text=True, check=True)
    assert told.stderr == "" and "MF4" in told.stdout


MULTIPLEXED = """VERSION ""
NS_ :
BS_:
BU_: HOST SERVO
BO_ 2566844926 Status: 8 SERVO
 SG_ Sel M : 0|8@1+ (1,0) [0|0] "" HOST
 SG_ Angle m0 : 8|24@1- (0.0001,0) [0|0] "rad" HOST
 SG_ Temp m1 : 8|8@1+ (1,-40) [0|0] "degC" HOST
BO_ 512 Cmd: 8 SERVO
 SG_ Torque : 7|16@0- (0.001,0) [0|0] "N m" HOST
"""


def test_of_a_multiplexed_message_the_frames_without_a_signal_are_no_rows_of_it(tmp_path: Path) -> None:
    angle, torque = np.round(np.sin(np.arange(500) / 40.0), 4), np.round(np.cos(np.arange(500) / 40.0), 3)
    lines = []
    for row, (q, u) in enumerate(zip(angle, torque, strict=True)):
        at, identifier = 1_700_000_000.0 + 0.002 * row, 2566844926 & 0x1FFFFFFF
        carried = bytes([0]) + round(q * 1e4).to_bytes(3, "little", signed=True) + bytes(4)
        lines.append(f"({at:.6f}) can0 {identifier:08X}#{carried.hex()}")
        if row % 40 == 20:
            lines.append(f"({at + 2e-4:.6f}) can0 {identifier:08X}#{bytes([1, 65, *bytes(6)]).hex()}")
        lines.append(f"({at:.6f}) can0 200#{(round(u * 1e3).to_bytes(2, 'big', signed=True) + bytes(6)).hex()}")
    (tmp_path / "bus.log").write_text("\n".join(lines) + "\n")
    (tmp_path / "bus.dbc").write_text(MULTIPLEXED)
    words = ColumnMap.of_words(["joint.position=Status.Angle", "joint.torque=Cmd.Torque"])
    table = read_signals(tmp_path / "bus.log", ("joint",), columns=words)
    assert len(table) == 500 and table.period_s == pytest.approx(0.002, rel=1e-6)
    assert table.position("joint") == pytest.approx(angle, abs=1e-9)


def test_the_joint_that_is_called_as_the_axis_is_taken_whatever_the_topic_is_called() -> None:
    names = [f"/joint_states.{signal}[{joint}]" for signal in ("position", "effort") for joint in ("base", "joint")]
    words = guessed([Found(name) for name in names], ("joint",))
    assert words == ("joint.position=/joint_states.position[joint]", "joint.torque=/joint_states.effort[joint]")


def test_of_joints_that_nobody_named_one_that_moves_is_taken() -> None:
    rows = np.arange(9.0)
    found = [
        Found.of(f"{name}[{joint}]", "", k * rows) for k, joint in enumerate("ab") for name in ("position", "effort")
    ]
    assert guessed(found, ("AXIS",)) == ("AXIS.position=position[b]", "AXIS.torque=effort[b]")
    assert guessed(found, ("a",)) == ("a.position=position[a]", "a.torque=effort[a]")
    seen = Contents(Path("arm.csv"), "table", (SampledGroup("rows", rows, {one.column: rows for one in found}),))
    assert (
        "positions of 2 joints (a, b); where they are those of an arm: gimbal-hil joint" in survey(seen, (), False)[-1]
    )


def test_a_position_that_a_drive_logs_in_turns_is_read_in_turns() -> None:
    odrive = [Found(name) for name in ("timestamp", "axis0.pos_estimate", "axis0.Iq_setpoint")]
    assert guessed(odrive, ("joint",))[0] == "joint.position=axis0.pos_estimate:turn"
    moteus = [Found(f"joint.{name}") for name in ("POSITION", "TORQUE", "MODE")]
    assert guessed(moteus, ("joint",))[0] == "joint.position=joint.POSITION:turn"
    assert guessed(moteus[:2], ("joint",))[0] == "joint.position=joint.POSITION"


def test_a_sheet_is_read_wherever_its_header_is_and_however_its_numbers_are_written(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl", reason="the extra xlsx is not installed")
    book, path = openpyxl.Workbook(), tmp_path / "log.xlsx"
    for row in (["Bench 3"], ["Rate", 250], [], ["time [ms]", "angle [deg]", "M [Nm]"]):
        book.active.append(row)
    for t, q, u in zip(TIME, POSITION, TORQUE, strict=True):
        book.active.append([round(1e3 * t, 3), float(np.rad2deg(q)), f"{u:.6f}".replace(".", ",")])
    # a sheet of words beside it is no reason to refuse the file
    for line in range(15):
        book.create_sheet("Read me") if line == 0 else book["Read me"].append([f"remark {'of the bench' * line}"])
    book.save(path)
    columns = ColumnMap.of_words(["joint.position=angle [deg]", "joint.torque=M [Nm]"])
    table = read_signals(path, ("joint",), columns=columns)
    assert table.period_s == pytest.approx(written.PERIOD_S)
    assert np.allclose(table.position("joint"), POSITION) and np.allclose(table.torque("joint"), TORQUE, atol=1e-6)


def test_records_may_have_their_numbers_and_times_as_words(tmp_path: Path) -> None:
    rows = (
        {"at": f"2024-05-01T10:00:{t:09.6f}", "q": f"{q:.6f}", "tau": u, "mode": "run"}
        for t, q, u in zip(TIME, POSITION, TORQUE, strict=True)
    )
    (path := tmp_path / "log.jsonl").write_text("\n".join(map(json.dumps, rows)) + "\n")
    columns = ColumnMap.of_words(["time_s=at", "joint.position=q", "joint.torque=tau"])
    table = read_signals(path, ("joint",), columns=columns)
    assert table.period_s == pytest.approx(written.PERIOD_S)
    assert np.allclose(table.position("joint"), POSITION, atol=1e-6)
