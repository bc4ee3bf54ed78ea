"""A run as a bag of ROS 2, opened by the decoder of MCAP's authors, by rosbags, and by the project's own reader."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from scipy.spatial.transform import Rotation

from gimbal_hil.data.runs import open_run
from gimbal_hil.data.signals import signals_of_run
from gimbal_hil.surface.cli import app
from tests.runs.lockstep import record_lockstep


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("ros2") / "run"
    record_lockstep(folder, 1500)
    return folder


@pytest.fixture(scope="module")
def bag(recorded: Path) -> Path:
    out = recorded.parent / "bag"
    assert app.run("export", [str(recorded), "--format", "ros2", "--out", str(out)]) == 0
    return out


def messages(bag: Path, topic: str) -> list[tuple[int, object]]:
    """(log time, message) of a topic, decoded by mcap-ros2-support from the definitions in the file."""
    (file,) = bag.glob("*.mcap")
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [(one.log_time, ros) for _, _, one, ros in reader.iter_decoded_messages(topics=[topic])]


def test_joint_states_are_the_rows_of_the_table(recorded: Path, bag: Path) -> None:
    table, states = signals_of_run(open_run(recorded)), messages(bag, "/joint_states")
    assert len(states) == len(table) > 1000
    assert {tuple(state.name) for _, state in states} == {("outer", "inner")}  # type: ignore[attr-defined]
    for column, axis in enumerate(("outer", "inner")):
        position = [state.position[column] for _, state in states]  # type: ignore[attr-defined]
        effort = [state.effort[column] for _, state in states]  # type: ignore[attr-defined]
        assert np.array_equal(position, table.columns[f"{axis}.position"])
        assert np.array_equal(effort, table.columns[f"{axis}.torque"])
    times = np.array([at for at, _ in states])
    assert np.array_equal(np.round(np.diff(times) / 1e9, 9), np.round(np.diff(table.time_s), 9))
    stamps = [state.header.stamp.sec * 10**9 + state.header.stamp.nanosec for _, state in states]  # type: ignore[attr-defined]
    assert np.array_equal(stamps, times)


def test_the_gyro_of_each_axis_is_about_its_own_axis(recorded: Path, bag: Path) -> None:
    table = signals_of_run(open_run(recorded))
    for axis, about, other in (("outer", "z", "y"), ("inner", "y", "z")):
        rates = [message.angular_velocity for _, message in messages(bag, f"/{axis}/gyro")]  # type: ignore[attr-defined]
        assert np.array_equal([getattr(rate, about) for rate in rates], table.columns[f"{axis}.rate"])
        assert all(np.isnan(getattr(rate, other)) for rate in rates)


def test_the_transforms_turn_the_boresight_as_the_joints_do(recorded: Path, bag: Path) -> None:
    table, transforms = signals_of_run(open_run(recorded)), messages(bag, "/tf")
    at_row = {round(time_s * 1e9): row for row, time_s in enumerate(table.time_s)}
    began = messages(bag, "/joint_states")[0][0]
    for at, message in transforms:
        row = at_row[at - began + round(table.time_s[0] * 1e9)]
        names = [(one.header.frame_id, one.child_frame_id) for one in message.transforms]  # type: ignore[attr-defined]
        assert names == [("earth", "base_link"), ("base_link", "outer"), ("outer", "inner")]
        turn = Rotation.identity()
        for one in message.transforms:  # type: ignore[attr-defined]
            turn = turn * Rotation.from_quat([getattr(one.transform.rotation, axis) for axis in "xyzw"])
        angles = [table.columns[name][row] for name in ("base.yaw", "base.pitch", "base.roll")]
        outer, inner = (table.columns[f"{axis}.position"][row] for axis in ("outer", "inner"))
        expected = Rotation.from_euler("ZYX", angles) * Rotation.from_euler("ZY", [outer, inner])
        assert (turn.inv() * expected).magnitude() < 1e-9
    assert len(transforms) >= 50 * (table.time_s[-1] - table.time_s[0]) - 1


def test_states_and_events_are_told(recorded: Path, bag: Path) -> None:
    said = [message.status[0] for _, message in messages(bag, "/diagnostics")]  # type: ignore[attr-defined]
    assert len(said) == 2 and {status.name for status in said} == {"gimbal-hil: host"}
    assert said[-1].message == "active" and said[-1].level in (0, b"\x00")
    assert [message.msg for _, message in messages(bag, "/rosout")] == [  # type: ignore[attr-defined]
        event.text for event in open_run(recorded).events
    ]


def test_rosbags_opens_it_too_and_counts_the_same(bag: Path) -> None:
    with AnyReader([bag]) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
    assert set(counts) == {"/joint_states", "/outer/gyro", "/inner/gyro", "/tf", "/diagnostics", "/rosout"}
    assert counts["/joint_states"] == len(messages(bag, "/joint_states"))


def test_the_project_s_own_reader_sees_joints_in_it(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert app.run("check", [str(bag)]) == 0
    assert "joint_states" in capsys.readouterr().out


def test_a_folder_that_is_no_bag_is_never_replaced(recorded: Path, bag: Path, tmp_path: Path) -> None:
    kept = tmp_path / "mine"
    kept.mkdir()
    (kept / "thesis.txt").write_text("years of work")
    for more in ([], ["--force"]):
        with pytest.raises(SystemExit) as end:
            app.run("export", [str(recorded), "--format", "ros2", "--out", str(kept), *more])
        assert end.value.code == 2
    assert [path.name for path in tmp_path.rglob("*")] == ["mine", "thesis.txt"]
    assert app.run("export", [str(recorded), "--format", "ros2", "--out", str(bag), "--force"]) == 0
    assert [path.name for path in bag.parent.iterdir() if path.name.startswith(".")] == []
