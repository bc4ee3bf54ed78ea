"""A run as a bag of ROS 2, in ROS's own messages: joints, gyros, transforms, state and events.

Topics: `/joint_states` (position and commanded effort of both joints), `/AXIS/gyro` (inertial rate about the joint's
axis), `/tf` (earth, base, outer, inner), `/diagnostics` (state of host and link, once a second), `/rosout` (events).
Axes are x forward, y left, z up, as REP 103 has them for bodies; `earth` is x north, y west, z up.
"""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.exports.groups import PROGRESS_ROWS, Progress, missing_extra, start_ns, table_times_ns
from gimbal_hil.data.runs import EventKind, RecordedRun
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.loop.host import HostState, LinkStatus, word_of

EARTH, BASE = "earth", "base_link"
#: transforms a second, and diagnostics
_TRANSFORM_HZ, _DIAGNOSTIC_HZ = 50.0, 1.0
_METADATA = "metadata.yaml"
_BAD_STATES = (HostState.FAULT, HostState.STOPPING)
_BAD_EVENTS = (EventKind.FAULT, EventKind.LINK)


@dataclass(frozen=True)
class _Record:
    time_ns: int
    topic: str
    kind: str
    message: Any


def export_ros2(run: RecordedRun, table: SignalsTable, folder: Path, force: bool, progress: Progress) -> int:
    """Write the folder of a bag (MCAP inside, message definitions beside the data); answers the number of messages.

    Raises BadInputError where the folder exists and is not a bag that `force` may replace.
    """
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise missing_extra("ros2", "rosbags", "bags") from None
    if folder.exists() and not (force and (folder / _METADATA).is_file()):
        raise BadInputError(str(folder), "already exists", "a new name, or --force to overwrite a bag")
    if not folder.parent.is_dir():
        raise BadInputError(str(folder.parent), "is not a folder", "a folder to write to")
    store = get_typestore(Stores.ROS2_HUMBLE)
    records = sorted(_records(run, table, store.types), key=lambda one: one.time_ns)
    # the file inside has the name of its folder
    beside = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    try:
        with Writer(beside / folder.name, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            topics = {
                topic: writer.add_connection(topic, kind, typestore=store)
                for topic, kind in sorted({(one.topic, one.kind) for one in records})
            }
            for done, one in enumerate(records):
                writer.write(topics[one.topic], one.time_ns, store.serialize_cdr(one.message, one.kind))
                if done % PROGRESS_ROWS == 0:
                    progress(done, len(records))
        if folder.exists():
            shutil.rmtree(folder)
        (beside / folder.name).replace(folder)
    except OSError as error:
        raise BadInputError(str(folder), error.strerror or str(error), "a place that can be written to") from error
    finally:
        shutil.rmtree(beside, ignore_errors=True)
    progress(len(records), len(records))
    return len(records)


def _records(run: RecordedRun, table: SignalsTable, types: Any) -> Iterator[_Record]:
    make = _Messages(types)
    began_ns = start_ns(run)
    axes = run.record.header.axes
    table_ns = began_ns + table_times_ns(run, table)
    column = table.columns
    joints = np.column_stack([column[f"{axis}.position"] for axis in axes]).astype(float)
    efforts = np.column_stack([column[f"{axis}.torque"] for axis in axes]).astype(float)
    for at, position, effort in zip(table_ns.tolist(), joints, efforts, strict=True):
        yield _Record(at, "/joint_states", *make.joint_state(at, axes, position, effort))
    for place, axis in enumerate(axes):
        if f"{axis}.rate" not in column:
            continue
        for at, rate in zip(table_ns.tolist(), column[f"{axis}.rate"].tolist(), strict=True):
            yield _Record(at, f"/{axis}/gyro", *make.gyro(at, axis, place, rate))
    every = max(1, round(1.0 / (_TRANSFORM_HZ * table.period_s)))
    base = [column.get(f"base.{angle}") for angle in ("roll", "pitch", "yaw")]
    for row in range(0, len(table), every):
        roll, pitch, yaw = (0.0 if angle is None else float(angle[row]) for angle in base)
        at, (outer, inner) = int(table_ns[row]), joints[row]
        yield _Record(at, "/tf", *make.transforms(at, axes, (roll, pitch, yaw), float(outer), float(inner)))
    for at, row in _once_a_second(run):
        yield _Record(began_ns + at, "/diagnostics", *make.diagnostics(began_ns + at, run, row))
    for event in run.events:
        at = began_ns + event.time_ns
        yield _Record(at, "/rosout", *make.log(at, event.kind, event.text))


def _once_a_second(run: RecordedRun) -> Iterator[tuple[int, Any]]:
    next_ns = 0
    for row in run.ticks:
        if int(row["time_ns"]) >= next_ns:
            next_ns = int(row["time_ns"]) + round(1e9 / _DIAGNOSTIC_HZ)
            yield int(row["time_ns"]), row


class _Messages:
    """ROS's messages with their type names; `types` are those of a release of ROS."""

    def __init__(self, types: Any) -> None:
        self._types = types

    def joint_state(self, at_ns: int, axes: tuple[str, ...], position: Any, effort: Any) -> tuple[str, Any]:
        """Positions and commanded efforts; no velocity, since the gyros measure inertial rates."""
        kind = "sensor_msgs/msg/JointState"
        none = np.zeros(0)
        return kind, self._types[kind](self._header(at_ns, ""), list(axes), position, none, effort)

    def gyro(self, at_ns: int, axis: str, place: int, rate: float) -> tuple[str, Any]:
        """The rate about z of the outer gimbal or y of the inner one, NaN about the others; neither attitude nor
        acceleration.
        """
        kind = "sensor_msgs/msg/Imu"
        about = [math.nan, math.nan, math.nan]
        about[(2, 1)[place]] = rate
        absent = np.array([-1.0, *[0.0] * 8])
        vector, turn = self._types["geometry_msgs/msg/Vector3"], self._types["geometry_msgs/msg/Quaternion"]
        header = self._header(at_ns, axis)
        none = vector(0.0, 0.0, 0.0)
        return kind, self._types[kind](
            header, turn(0.0, 0.0, 0.0, 1.0), absent, vector(*about), np.zeros(9), none, absent
        )

    def transforms(
        self, at_ns: int, axes: tuple[str, ...], base: tuple[float, float, float], outer: float, inner: float
    ) -> tuple[str, Any]:
        """Earth to base, base to outer gimbal (about z), outer to inner (about y)."""
        kind = "tf2_msgs/msg/TFMessage"
        ways = ((EARTH, BASE, base), (BASE, axes[0], (0.0, 0.0, outer)), (axes[0], axes[1], (0.0, inner, 0.0)))
        stamped, transform = (self._types[f"geometry_msgs/msg/{name}"] for name in ("TransformStamped", "Transform"))
        vector, turn = self._types["geometry_msgs/msg/Vector3"], self._types["geometry_msgs/msg/Quaternion"]
        return kind, self._types[kind](
            [
                stamped(
                    self._header(at_ns, parent), child, transform(vector(0.0, 0.0, 0.0), turn(*_quaternion(*angles)))
                )
                for parent, child, angles in ways
            ]
        )

    def diagnostics(self, at_ns: int, run: RecordedRun, row: Any) -> tuple[str, Any]:
        """Host and link as one status, with the ticks that were missed so far in its values."""
        kind = "diagnostic_msgs/msg/DiagnosticArray"
        status, pair = self._types["diagnostic_msgs/msg/DiagnosticStatus"], self._types["diagnostic_msgs/msg/KeyValue"]
        state, link = HostState(int(row["host_state"])), LinkStatus(int(row["link_status"]))
        bad = state in _BAD_STATES
        level = status.ERROR if bad else status.OK if link is LinkStatus.OK else status.WARN
        values = [pair("link", word_of(link)), pair("tick", str(int(row["tick"])))]
        values += [pair("segment", str(int(row["segment"]))), pair("rejected_frames", str(int(row["rejected_frames"])))]
        told = status(level, "gimbal-hil: host", word_of(state), run.folder.name, values)
        return kind, self._types[kind](self._header(at_ns, ""), [told])

    def log(self, at_ns: int, event: EventKind, text: str) -> tuple[str, Any]:
        """One event."""
        kind = "rcl_interfaces/msg/Log"
        log = self._types[kind]
        level = log.ERROR if event in _BAD_EVENTS else log.INFO
        return kind, log(self._time(at_ns), level, f"gimbal_hil.{event.value}", text, "", "", 0)

    def _time(self, at_ns: int) -> Any:
        return self._types["builtin_interfaces/msg/Time"](at_ns // 1_000_000_000, at_ns % 1_000_000_000)

    def _header(self, at_ns: int, frame: str) -> Any:
        return self._types["std_msgs/msg/Header"](self._time(at_ns), frame)


def _quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """x, y, z, w of Rz(yaw) Ry(pitch) Rx(roll)."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat()
    return float(x), float(y), float(z), float(w)
