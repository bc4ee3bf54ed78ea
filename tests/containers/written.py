"""One joint's motion in every container, each written by the library that owns the format, as a stranger would."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np

ROWS, PERIOD_S, START_S = 500, 0.004, 1_700_000_000.0
TIME = np.arange(ROWS) * PERIOD_S
POSITION = 0.8 * np.sin(2.0 * TIME)
TORQUE = 0.05 * np.sign(np.cos(2.0 * TIME)) - 0.3 * np.sin(2.0 * TIME)
DBC = """VERSION ""
NS_ :
BS_:
BU_: X
BO_ 272 Axis: 8 X
 SG_ Angle : 0|32@1- (1,0) [0|0] "deg" X
 SG_ Torque : 32|32@1- (1,0) [0|0] "Nm" X
SIG_VALTYPE_ 272 Angle : 1;
SIG_VALTYPE_ 272 Torque : 1;
"""


def rosbag2(path: Path) -> Path:
    """A bag of ROS 2 with two joints in one JointState, header stamps and a topic of another type."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    state, head, stamp = (
        store.types[name]
        for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    text = store.types["std_msgs/msg/String"]
    plugin = StoragePlugin.MCAP if path.suffix == ".mcap" else StoragePlugin.SQLITE3
    with Writer(path.with_suffix(""), version=9, storage_plugin=plugin) as writer:
        joints = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        words = writer.add_connection("/say", text.__msgtype__, typestore=store)
        for k in range(ROWS):
            ns = round((START_S + TIME[k]) * 1e9)
            at = stamp(sec=ns // 10**9, nanosec=ns % 10**9)
            message = state(
                header=head(stamp=at, frame_id=""),
                name=["shoulder", "elbow"],
                position=np.array([0.1, POSITION[k]]),
                velocity=np.zeros(2),
                effort=np.array([0.0, TORQUE[k]]),
            )
            # the recorder is late by up to two milliseconds, the header is not
            late = ns + (k * 7919) % 2_000_000
            writer.write(joints, late, store.serialize_cdr(message, state.__msgtype__))
        writer.write(words, late, store.serialize_cdr(text(data="done"), text.__msgtype__))
    return path.with_suffix("")


def mcap_json(path: Path) -> Path:
    """MCAP with JSON, as Foxglove's examples have it."""
    from mcap.writer import Writer

    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("joint", "jsonschema", b'{"type": "object"}')
        channel = writer.register_channel("/joint", "json", schema)
        for k in range(ROWS):
            ns = round((START_S + TIME[k]) * 1e9)
            data = json.dumps({"state": {"angle": POSITION[k], "torque": TORQUE[k]}}).encode()
            writer.add_message(channel, ns, data, ns)
        writer.finish()
    return path


def ulog(path: Path) -> Path:
    """A ULog by its specification, then read and written again by pyulog."""
    from pyulog import ULog

    def message(kind: bytes, data: bytes) -> bytes:
        return struct.pack("<HB", len(data), kind[0]) + data

    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000), message(b"B", bytes(40))]
    parts.append(message(b"F", b"joint:uint64_t timestamp;float angle;float[2] torque;"))
    parts.append(message(b"A", struct.pack("<BH", 0, 0) + b"joint"))
    for k in range(ROWS):
        row = struct.pack("<QfffH", round(1e6 * (1.0 + TIME[k])), POSITION[k], 0.0, TORQUE[k], 0)[:-2]
        parts.append(message(b"D", struct.pack("<H", 0) + row))
    first = path.with_suffix(".first")
    first.write_bytes(b"".join(parts))
    ULog(str(first)).write_ulog(str(path))
    return path


def mf4(path: Path) -> Path:
    """An MF4 with two channel groups of unlike rates, with units."""
    from asammdf import MDF, Signal

    file = MDF(version="4.10")
    file.append([Signal(POSITION, TIME, name="Angle", unit="rad")], acq_name="encoder")
    fine = np.arange(2 * ROWS) * PERIOD_S / 2.0
    file.append([Signal(np.repeat(TORQUE, 2), fine, name="Torque", unit="Nm")], acq_name="drive")
    file.save(path, overwrite=True)
    file.close()
    return path


def matlab(path: Path) -> Path:
    """A .mat with a struct, a matrix, and settings that are no signals."""
    from scipy.io import savemat

    savemat(
        path,
        {"t": TIME[:, None], "log": {"q": POSITION, "tau": TORQUE}, "both": np.stack([POSITION, TORQUE]), "kp": 4.0},
    )
    return path


def can_log(path: Path) -> Path:
    """A recording by python-can's writer of that ending; its DBC lies beside it."""
    import can

    path.with_suffix(".dbc").write_text(DBC, encoding="utf-8")
    with can.Logger(str(path)) as writer:
        for k in range(ROWS):
            data = struct.pack("<ff", np.rad2deg(POSITION[k]), TORQUE[k])
            at = START_S + float(TIME[k])
            writer.on_message_received(
                can.Message(timestamp=at, arbitration_id=272, data=data, is_extended_id=False, channel=0)
            )
            writer.on_message_received(
                can.Message(timestamp=at, arbitration_id=5, data=b"\0", is_extended_id=False, channel=0)
            )
    return path


def workbook(path: Path) -> Path:
    """Two sheets, of which one has the log, with units in its header."""
    import pandas as pd

    with pd.ExcelWriter(path) as writer:
        pd.DataFrame({"who": ["me"], "when": ["today"]}).to_excel(writer, sheet_name="about", index=False)
        frame = pd.DataFrame({"time [s]": TIME, "angle [deg]": np.rad2deg(POSITION), "torque [Nm]": TORQUE})
        frame.to_excel(writer, sheet_name="log", index=False)
    return path


def lerobot(path: Path) -> Path:
    """Two episodes with lists in cells, as LeRobot's data sets have them, and their names beside."""
    import pyarrow as pa
    import pyarrow.parquet as parquet

    info = path.parent / "meta" / "info.json"
    info.parent.mkdir(exist_ok=True)
    info.write_text(json.dumps({"features": {"observation.state": {"names": ["pan.pos", "lift.pos"]}}}))
    short = ROWS // 5
    states = [[0.0, value] for value in (*POSITION[:short], *POSITION)]
    table = {
        "observation.state": pa.array(states, pa.list_(pa.float32(), 2)),
        "observation.effort": pa.array([[value] for value in (*TORQUE[:short], *TORQUE)], pa.list_(pa.float64())),
        "timestamp": np.concatenate([TIME[:short], TIME]).astype(np.float32),
        "episode_index": np.repeat([0, 1], [short, ROWS]),
        "task": ["lift"] * (short + ROWS),
    }
    parquet.write_table(pa.table(table), path)
    return path


def json_lines(path: Path) -> Path:
    """One record a line, as scripts around moteus and ODrive write them; the last line is cut."""
    rows = [
        json.dumps({"timestamp": START_S + TIME[k], "state": {"position": POSITION[k], "torque": TORQUE[k]}})
        for k in range(ROWS)
    ]
    path.write_text("\n".join([*rows, rows[0][:20]]), encoding="utf-8")
    return path


def json_entries(path: Path) -> Path:
    """One document with a head and a list of records, as BAM has it."""
    entries = [
        {"timestamp": TIME[k], "position": POSITION[k], "load_torque": TORQUE[k], "on": True} for k in range(ROWS)
    ]
    path.write_text(json.dumps({"mass": 0.5, "entries": entries}), encoding="utf-8")
    return path


#: name of the file, what writes it, and the words for --column that read it
WRITTEN = {
    "bag": (rosbag2, "joint.position=/joint_states.position[elbow] joint.torque=/joint_states.effort[elbow]"),
    "bag.mcap": (rosbag2, "joint.position=/joint_states.position[elbow] joint.torque=/joint_states.effort[elbow]"),
    "foxglove.mcap": (mcap_json, "joint.position=/joint.state.angle joint.torque=/joint.state.torque"),
    "flight.ulg": (ulog, "joint.position=joint.angle joint.torque=joint.torque[1]"),
    "drive.mf4": (mf4, "joint.position=Angle joint.torque=Torque"),
    "rig.mat": (matlab, "joint.position=log.q joint.torque=log.tau"),
    "bus.log": (can_log, "joint.position=Axis.Angle:deg joint.torque=Axis.Torque"),
    "bus.trc": (can_log, "joint.position=Axis.Angle:deg joint.torque=Axis.Torque"),
    "bus.asc": (can_log, "joint.position=Axis.Angle:deg joint.torque=Axis.Torque"),
    "bus.blf": (can_log, "joint.position=Axis.Angle:deg joint.torque=Axis.Torque"),
    "log.xlsx": (workbook, "joint.position=angle [deg]:deg joint.torque=torque [Nm]"),
    "episodes.parquet": (lerobot, "joint.position=observation.state[lift.pos] joint.torque=observation.effort[0]"),
    "lines.jsonl": (json_lines, "joint.position=state.position joint.torque=state.torque"),
    "bam.json": (json_entries, "joint.position=entries.position joint.torque=entries.load_torque"),
}


def words_of(text: str) -> list[str]:
    """The words for `--column` in a text, parted where the next name begins."""
    return text.replace(" joint.torque=", "\njoint.torque=").split("\n")
