"""A run's frames in other people's formats: BLF (raw), MCAP (decoded, JSON) and MF4 (decoded channels)."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from firmware_protocol.errors import BadInputError
from firmware_protocol.schema import Message
from gimbal_hil.runs.frame_columns import MessageColumns, columns_of
from gimbal_hil.runs.reader import Run
from gimbal_hil.runs.schema import TICK_ROW, FrameDirection, stored_name

#: told how far an export is: steps done, of how many
Progress = Callable[[int, int], None]
_PROGRESS_ROWS = 4096
_STANDARD_IDENTIFIERS = 0x800


def export_blf(run: Run, path: Path, progress: Progress) -> int:
    """Frames as Vector BLF, both directions, as they were on the wire, damaged ones included; answers how many."""
    from can import Message as CanMessage
    from can.io.blf import BLFWriter

    frames = _frames(run)
    frames = frames[(frames["direction"] != FrameDirection.REJECTED) & (frames["identifier"] < _STANDARD_IDENTIFIERS)]
    start_s, period_s = _start_ns(run) / 1e9, run.record.header.period_ns / 1e9
    with BLFWriter(path) as writer:
        for place, frame in enumerate(frames):
            message = CanMessage(
                timestamp=start_s + int(frame["tick"]) * period_s,
                arbitration_id=int(frame["identifier"]),
                is_extended_id=False,
                data=frame["payload"].tobytes(),
                is_rx=bool(frame["direction"] == FrameDirection.DEVICE_TO_HOST),
                channel=0,
            )
            writer.on_message_received(message)
            if place % _PROGRESS_ROWS == 0:
                progress(place, len(frames))
    progress(len(frames), len(frames))
    return len(frames)


def export_mcap(run: Run, path: Path, progress: Progress) -> int:
    """Good frames decoded to JSON, one topic a message, and the tick rows as `/tick`; answers the number of records."""
    try:
        from mcap.writer import Writer
    except ImportError:
        raise _missing("mcap", "mcap") from None

    start_ns, period_ns = _start_ns(run), run.record.header.period_ns
    sources = [(f"/{message.name}", _properties(message), columns) for message, columns in _decoded(run)]
    places = np.concatenate([columns.place for _, _, columns in sources])
    total = len(places) + len(run.ticks)
    with path.open("wb") as file:
        writer: Any = Writer(file)
        writer.start(profile="", library="gimbal-hil")
        streams = [_json_records(columns, start_ns, period_ns) for _, _, columns in sources]
        channels = [_channel(writer, topic, properties) for topic, properties, _ in sources]
        of_frame = np.repeat(np.arange(len(sources)), [len(columns.place) for _, _, columns in sources])
        for done, source in enumerate(of_frame[np.argsort(places)].tolist()):
            time_ns, data = next(streams[source])
            writer.add_message(channels[source], log_time=time_ns, data=data, publish_time=time_ns)
            if done % _PROGRESS_ROWS == 0:
                progress(done, total)
        names = [name for name in TICK_ROW.names or () if name != "check"]
        named = {name: stored_name(name, run.record.header.axes) for name in names}
        channel = _channel(writer, "/tick", dict.fromkeys(named.values(), "number"))
        for row in run.ticks:
            values = {named[name]: row[name].item() for name in names}
            time_ns = start_ns + values["time_ns"]
            writer.add_message(channel, log_time=time_ns, data=_json(values), publish_time=time_ns)
        writer.finish()
    progress(total, total)
    return total


def export_mf4(run: Run, path: Path, progress: Progress) -> int:
    """Good frames and tick rows as MDF 4 channel groups in physical units, time in seconds of the run; answers the
    number of channels.
    """
    try:
        from asammdf import MDF, Signal
    except ImportError:
        raise _missing("mf4", "asammdf") from None

    period_s = run.record.header.period_ns / 1e9
    groups = [
        [
            Signal(
                columns.physical(field.name),
                columns.tick * period_s,
                unit=field.unit,
                name=f"{message.name}.{field.name}",
            )
            for field in message.fields
        ]
        for message, columns in _decoded(run)
    ]
    times, axes = run.ticks["time_ns"] / 1e9, run.record.header.axes
    names = [name for name in TICK_ROW.names or () if name not in ("tick", "time_ns", "check")]
    groups.append(
        [Signal(np.ascontiguousarray(run.ticks[name]), times, name=f"host.{stored_name(name, axes)}") for name in names]
    )
    with MDF(version="4.10") as file:
        for done, signals in enumerate(groups):
            progress(done, len(groups))
            file.append(signals, comment=signals[0].name.partition(".")[0])
        file.header.start_time = datetime.fromisoformat(run.record.started_utc)
        file.save(path, overwrite=True)
    progress(len(groups), len(groups))
    return sum(map(len, groups))


def _frames(run: Run) -> Any:
    if not len(run.frames):
        raise BadInputError(str(run.folder), "keeps no frames", "a run recorded with recording.frames: true")
    return run.frames


def _decoded(run: Run) -> list[tuple[Message, MessageColumns]]:
    frames = _frames(run)
    decoded = [(message, columns_of(frames, message.name, run.protocol)) for message in run.protocol.messages]
    return [(message, columns) for message, columns in decoded if len(columns.place)]


def _start_ns(run: Run) -> int:
    """Time of day of tick 0 in nanoseconds since 1970, as far as the run knows it."""
    try:
        start = datetime.fromisoformat(run.record.started_utc)
    except ValueError:
        where = f"{run.folder / 'run.yaml'}: when.started_utc"
        raise BadInputError(
            where, f"is {run.record.started_utc!r}", "a time such as 2026-01-31T12:00:00.000+00:00"
        ) from None
    return round(start.timestamp() * 1000) * 1_000_000


def _json_records(columns: MessageColumns, start_ns: int, period_ns: int) -> Iterator[tuple[int, bytes]]:
    fields = columns.message.fields
    values = [
        columns.physical(field.name).tolist() if field.is_physical else columns.raw[field.name].tolist()
        for field in fields
    ]
    names = [field.attribute for field in fields]
    for tick, *row in zip(columns.tick.tolist(), *values, strict=True):
        yield start_ns + tick * period_ns, _json({"host_tick": tick, **dict(zip(names, row, strict=True))})


def _properties(message: Message) -> dict[str, str]:
    return {"host_tick": "integer"} | {
        field.attribute: "number" if field.is_physical else "integer" for field in message.fields
    }


def _channel(writer: Any, topic: str, properties: dict[str, str]) -> int:
    schema = {"type": "object", "properties": {name: {"type": kind} for name, kind in properties.items()}}
    schema_id = writer.register_schema(name=topic[1:], encoding="jsonschema", data=_json(schema))
    channel: int = writer.register_channel(topic=topic, message_encoding="json", schema_id=schema_id)
    return channel


def _json(content: dict[str, Any]) -> bytes:
    """JSON proper: numbers that are none (references where there is no loop) become null."""
    plain = {
        name: None if isinstance(value, float) and not np.isfinite(value) else value for name, value in content.items()
    }
    return json.dumps(plain, separators=(",", ":")).encode()


def _missing(extra: str, package: str) -> BadInputError:
    return BadInputError(
        f"--format {extra}",
        f"needs the package {package}, which is not installed",
        f"pip install 'gimbal-hil[{extra}]'",
    )
