"""Two logs of one joint in the raw files of six kinds of benches, each as its tool leaves it.

`python -m tests.docs.raw_files DIR` writes them there, goes both steps of the page as a new user would, each in a
process of its own, and prints its table.
"""

from __future__ import annotations

import json
import re
import shlex
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from tests.change.rig import Machine
from tests.containers.written import DBC

Log = tuple[np.ndarray, np.ndarray, np.ndarray]
#: the joint has this ripple and a higher Coulomb level than the model of the page
MACHINE, START_S, PER_AMPERE = Machine(coulomb=0.05, ripple=0.01), 1_700_000_000.0, 0.062


@cache
def logs() -> dict[str, Log]:
    """Time, position and torque of log `a`, which is searched, and `b`, which judges."""
    random = np.random.default_rng(41)
    tables = {name: MACHINE.log(random) for name in "ab"}
    return {name: (one.time_s, one.position("joint"), one.torque("joint")) for name, one in tables.items()}


def odrive(path: Path, log: Log) -> None:
    """A CSV of odrivetool: seconds, turns, and the current of the motor."""
    rows = (f"{t:.4f},{q / (2 * np.pi):.7f},{u / PER_AMPERE:.6f},24.1" for t, q, u in zip(*log, strict=True))
    path.write_text("\n".join(["timestamp,axis0.pos_estimate,axis0.Iq_setpoint,vbus_voltage", *rows]) + "\n")


def moteus(path: Path, log: Log) -> None:
    """One line of JSON a cycle, by a script around the moteus library: revolutions and N m."""
    rows = (
        json.dumps({"timestamp": START_S + t, "joint": {"POSITION": q / (2 * np.pi), "TORQUE": u, "MODE": 10}})
        for t, q, u in zip(*log, strict=True)
    )
    path.write_text("\n".join(rows) + "\n")


def rosbag(path: Path, log: Log) -> None:
    """A bag of ROS 2 with the joint states of two joints."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    names = ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    state, head, stamp = (store.types[name] for name in names)
    with Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        joints = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for t, q, u in zip(*log, strict=True):
            ns = round((START_S + t) * 1e9)
            message = state(
                header=head(stamp=stamp(sec=ns // 10**9, nanosec=ns % 10**9), frame_id=""),
                name=["base", "joint"],
                position=np.array([0.0, q]),
                velocity=np.zeros(2),
                effort=np.array([0.0, u]),
            )
            writer.write(joints, ns + 300_000, store.serialize_cdr(message, state.__msgtype__))


def candump(path: Path, log: Log) -> None:
    """What `candump -l` writes, with a DBC beside it."""
    path.with_name("bus.dbc").write_text(DBC)
    rows = (
        f"({START_S + t:.6f}) can0 110#{struct.pack('<ff', np.rad2deg(q), u).hex().upper()}"
        for t, q, u in zip(*log, strict=True)
    )
    path.write_text("\n".join(rows) + "\n")


def headerless(path: Path, log: Log) -> None:
    """Numbers alone: milliseconds, degrees, N m."""
    rows = (f"{1e3 * t:.1f},{np.rad2deg(q):.5f},{u:.6f}" for t, q, u in zip(*log, strict=True))
    path.write_text("\n".join(rows) + "\n")


def matlab(path: Path, log: Log) -> None:
    """A struct with a time, an angle and a torque."""
    from scipy.io import savemat

    savemat(path, {"t": log[0][:, None], "log": {"q": log[1], "tau": log[2]}, "kp": 4.0})


#: ending of the page's files -> what writes them
WRITERS: dict[str, Callable[[Path, Log], None]] = {
    "odrive.csv": odrive,
    "moteus.jsonl": moteus,
    "rosbag2": rosbag,
    "log": candump,
    "numbers.csv": headerless,
    "mat": matlab,
}

PAGE = Path(__file__).resolve().parent.parent.parent / "docs" / "how-to" / "from-a-raw-file-to-a-verdict.md"


def ways() -> dict[str, tuple[list[str], list[str], list[str]]]:
    """Kind of file -> what the page's `init`, `check` and `discrepancy` are called with, those words included."""
    commands = [shlex.split(line) for line in re.findall(r"^gimbal-hil (.*)$", PAGE.read_text(encoding="utf-8"), re.M)]
    inits = {words[1]: words for words in commands if words[0] == "init"}
    asked = [words for words in commands if words[0] != "init"]
    pairs = zip(asked[::2], asked[1::2], strict=True)
    return {check[1].removeprefix("a."): (inits[Path(check[-1]).parent.name], check, ask) for check, ask in pairs}


def write_all(folder: Path) -> None:
    """Both logs in each kind of file."""
    for name, log in logs().items():
        for kind, write in WRITERS.items():
            write(folder / f"{name}.{kind}", log)


def _timed(folder: Path, words: list[str]) -> tuple[float, str]:
    begin = time.perf_counter()
    done = subprocess.run(["gimbal-hil", *words], cwd=folder, capture_output=True, text=True, check=True)
    return time.perf_counter() - begin, done.stdout


def _table(folder: Path) -> None:
    write_all(folder)
    for kind, (init, check, _) in ways().items():
        if not (folder / init[1]).exists():
            print(f"init: {_timed(folder, init)[0]:.1f} s")
        looked, said = _timed(folder, check)
        words = shlex.split(said.rpartition("next: gimbal-hil ")[2])
        asked, answer = _timed(folder, [*words[:-1], f"verdict_{kind}"])
        print(f"| {kind} | {looked:.1f} | {asked:.1f} | {looked + asked:.1f} |", answer[:90])


if __name__ == "__main__":
    _table(Path(sys.argv[1]))
