"""A run as MCAP: a topic a group, JSON records that keep to the schema beside them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from firmware_protocol.json_object import Json
from gimbal_hil.data.exports.groups import PROGRESS_ROWS, ExportedSignal, Group, Progress, missing_extra, start_ns
from gimbal_hil.data.runs import RecordedRun


def export_mcap(run: RecordedRun, groups: tuple[Group, ...], path: Path, progress: Progress) -> int:
    """One record a row of each group, in the order of time; answers the number of records."""
    try:
        from mcap.writer import Writer
    except ImportError:
        raise missing_extra("mcap", "mcap") from None

    began_ns = start_ns(run)
    sizes = [len(group.time_ns) for group in groups]
    of_group = np.repeat(np.arange(len(groups)), sizes)
    order = np.argsort(np.concatenate([group.time_ns for group in groups]), kind="stable")
    rows = [zip(group.time_ns.tolist(), *(one.named() for one in group.channels), strict=True) for group in groups]
    names = [[channel.name for channel in group.channels] for group in groups]
    with path.open("wb") as file:
        writer: Any = Writer(file)
        writer.start(profile="", library="gimbal-hil")
        topics = [_topic(writer, group) for group in groups]
        for done, group in enumerate(of_group[order].tolist()):
            time_ns, *values = next(rows[group])
            at = began_ns + time_ns
            writer.add_message(
                topics[group], log_time=at, data=_json(dict(zip(names[group], values, strict=True))), publish_time=at
            )
            if done % PROGRESS_ROWS == 0:
                progress(done, sum(sizes))
        writer.finish()
    progress(sum(sizes), sum(sizes))
    return sum(sizes)


def schema_of(group: Group) -> Json:
    """JSON schema (draft 2020-12) of a group's records; `description` is the unit."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": group.name,
        "type": "object",
        "properties": {channel.name: _property(channel) for channel in group.channels},
        "required": [channel.name for channel in group.channels],
    }


def _property(channel: ExportedSignal) -> Json:
    unit = {"description": channel.unit} if channel.unit else {}
    if channel.labels is not None:
        return {"type": "string"} | ({"enum": sorted(set(channel.labels.values()))} if channel.closed else {})
    if channel.values.dtype.kind != "f":
        return {"type": "integer"} | unit
    # a loop that is open has no reference
    return {"type": "number" if bool(np.isfinite(channel.values).all()) else ["number", "null"]} | unit


def _topic(writer: Any, group: Group) -> int:
    schema = writer.register_schema(name=group.name, encoding="jsonschema", data=_json(schema_of(group)))
    units = {channel.name: channel.unit for channel in group.channels if channel.unit}
    number: int = writer.register_channel(
        topic=f"/{group.name}", message_encoding="json", schema_id=schema, metadata=units
    )
    return number


def _json(content: dict[str, object]) -> bytes:
    return json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
