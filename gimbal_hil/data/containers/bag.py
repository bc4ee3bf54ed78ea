"""Recordings of ROS and of whoever writes MCAP: ROS 2 bags (folder, .db3, .mcap), ROS 1 bags, MCAP with JSON.

`rosbags` owns the bags, `mcap` the container alone.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.containers.contents import Contents, SampledGroup, from_first, missing
from gimbal_hil.data.containers.flattening import columns_of

MCAP_START, ROS1_START, SQLITE_START = b"\x89MCAP0\r\n", b"#ROSBAG V2", b"SQLite format 3"
_METADATA = "metadata.yaml"
#: a header's stamp counts where it is set and runs along with the recorder's clock within this many seconds a message
_ALONG_S = 1.0


def is_bag(path: Path, start: bytes) -> bool:
    """A folder of rosbag2, its .db3 alone, a ROS 1 bag."""
    if path.is_dir():
        return (path / _METADATA).exists()
    return start.startswith(ROS1_START) or (start.startswith(SQLITE_START) and path.suffix == ".db3")


def is_mcap(path: Path, start: bytes) -> bool:
    """A file of MCAP, by its magic bytes."""
    return start.startswith(MCAP_START)


def read_bag(path: Path) -> Contents:
    """All topics of a bag; messages of types that the bag defines, else of ROS 2 Humble's."""
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise missing(path, "a bag of ROS", "rosbags", "bags") from None
    if path.is_dir() and path.suffix == ".bag":
        raise BadInputError(
            str(path),
            "is a folder whose name ends like a ROS 1 bag, so the bag library misreads it",
            f"another name, as in mv {path.name} {path.stem}_bag",
        )
    kind = "bag of ROS 1" if path.suffix == ".bag" else "bag of ROS 2"
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        found: dict[str, list[tuple[int, object]]] = {}
        unread: set[str] = set()
        for connection, stamp_ns, raw in reader.messages():
            try:
                message = reader.deserialize(raw, connection.msgtype)
            except (AnyReaderError, KeyError):
                unread.add(f"{connection.topic} ({connection.msgtype})")
                continue
            found.setdefault(connection.topic, []).append((stamp_ns, message))
    return _contents(path, kind, found, unread, {})


def read_mcap(path: Path) -> Contents:
    """All channels of an MCAP file: JSON as it stands, ROS 2 (CDR) by the definitions in the file."""
    try:
        from mcap.reader import make_reader
    except ImportError:
        raise missing(path, "an MCAP file", "mcap", "bags") from None
    found: dict[str, list[tuple[int, Any]]] = {}
    unread: set[str] = set()
    units: dict[str, dict[str, str]] = {}
    with path.open("rb") as file:
        decoders: dict[int, Any] = {}
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.id not in decoders:
                decoders[channel.id] = _decoder(path, schema, channel.message_encoding)
                units.setdefault(channel.topic, {}).update(channel.metadata)
            decoded = decoders[channel.id]
            if decoded is None:
                unread.add(f"{channel.topic} ({channel.message_encoding})")
            else:
                found.setdefault(channel.topic, []).append((message.log_time, decoded(message.data)))
    return _contents(path, "MCAP file", found, unread, units)


def _decoder(path: Path, schema: Any, encoding: str) -> Any:
    """What turns a message's bytes into fields; None where nothing here does."""
    if encoding == "json":
        return json.loads
    if encoding != "cdr" or schema is None or schema.encoding != "ros2msg":
        return None
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError:
        raise missing(path, "an MCAP file of ROS 2", "rosbags", "bags") from None
    store = get_typestore(Stores.EMPTY)
    name = schema.name if "/msg/" in schema.name else schema.name.replace("/", "/msg/", 1)
    store.register(get_types_from_msg(schema.data.decode(), name))
    return lambda data: store.deserialize_cdr(data, name)


def _contents(
    path: Path,
    kind: str,
    found: dict[str, list[tuple[int, object]]],
    unread: set[str],
    units: dict[str, dict[str, str]],
) -> Contents:
    stamps = {topic: np.array([float(ns) for ns, _ in rows]) for topic, rows in _stamped(found).items()}
    times = from_first(stamps, 1e-9)
    groups = []
    for topic, rows in found.items():
        own = columns_of([message for _, message in rows])
        columns = {f"{topic}.{name}" if name else topic: values for name, values in own.items() if _is_signal(name)}
        said = {f"{topic}.{name}": unit for name, unit in units.get(topic, {}).items()}
        groups.append(SampledGroup(topic, times[topic], columns, said))
    notes = tuple(f"messages that nothing here reads: {one}" for one in sorted(unread))
    return Contents(path, kind, tuple(group for group in groups if group.columns), notes)


def _is_signal(name: str) -> bool:
    return not name.startswith("header.") and ".header." not in name


def _stamped(found: dict[str, list[tuple[int, object]]]) -> dict[str, list[tuple[int, Any]]]:
    """Messages with the time of their header, where all of a topic have one that runs along with the recorder's."""
    stamped = {}
    for topic, rows in found.items():
        own = list(_header_stamps(rows))
        steady = len(own) == len(rows) and all(b > a for a, b in pairwise(own))
        logged_s = 1e-9 * (rows[-1][0] - rows[0][0])
        along = steady and abs(1e-9 * (own[-1] - own[0]) - logged_s) < _ALONG_S
        stamped[topic] = [(ns, row[1]) for ns, row in zip(own, rows, strict=True)] if along else rows
    return stamped


def _header_stamps(rows: list[tuple[int, Any]]) -> Iterator[int]:
    for _, message in rows:
        header = message.get("header") if isinstance(message, dict) else getattr(message, "header", None)
        stamp = header.get("stamp") if isinstance(header, dict) else getattr(header, "stamp", None)
        if stamp is None:
            return
        parts: Any = stamp if isinstance(stamp, dict) else vars(stamp)
        seconds, rest = parts.get("sec") or 0, parts.get("nanosec") or parts.get("nsec") or 0
        if not seconds and not rest:
            return
        yield int(seconds) * 10**9 + int(rest)
