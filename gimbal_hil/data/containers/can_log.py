"""Recordings of CAN buses: candump, TRC, ASC and BLF (`python-can` reads them), decoded by a DBC (`cantools`).

The DBC lies beside the recording: with its name and the ending .dbc, or as the only one in the folder.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.data.containers.contents import Contents, Floats, SampledGroup, broken, from_first, missing

_CANDUMP = re.compile(rb"\A\s*\(\d+\.\d+\)\s+\S+\s+[0-9A-Fa-f]{3,8}#")
_ASC = re.compile(rb"\Adate |\A//.*\n?date |\Abase (?:hex|dec)", re.IGNORECASE)
_TRC = re.compile(rb"\A;\$FILEVERSION|\A;\s*Start time|\A;-+\s*\n;\s*Start", re.IGNORECASE)


def is_can_log(path: Path, start: bytes) -> bool:
    """By how each of the four begins."""
    return start.startswith(b"LOGG") or bool(_CANDUMP.match(start) or _ASC.match(start) or _TRC.match(start))


def read_can_log(path: Path) -> Contents:
    """Every message that the DBC knows, as a group; signals as `Message.Signal`, in the DBC's units."""
    try:
        import cantools
    except ImportError:
        raise missing(path, "a recording of a CAN bus", "cantools", "dbc") from None
    beside = dbc_of(path)
    try:
        database: Any = cantools.database.load_file(beside)
    except Exception as error:  # the parser raises whatever a damaged line ran into
        raise broken(beside, "DBC file", error) from error
    rows: dict[str, list[tuple[float, Json]]] = {}
    unknown: set[int] = set()
    undecoded = 0
    for stamp, identifier, data in _frames(path):
        try:
            message = database.get_message_by_frame_id(identifier)
        except KeyError:
            unknown.add(identifier)
            continue
        try:
            rows.setdefault(message.name, []).append((stamp, message.decode(data, decode_choices=False)))
        except (cantools.database.DecodeError, ValueError, KeyError, OverflowError):
            undecoded += 1
    if not any(rows.values()):
        seen = ", ".join(f"{one:X}" for one in sorted(unknown)[:8]) or "none"
        raise BadInputError(
            str(path),
            f"holds no frame that {beside.name} decodes; identifiers: {seen}",
            "the DBC of this bus beside it",
        )
    return _contents(path, database, rows, beside, unknown, undecoded)


def dbc_of(path: Path) -> Path:
    """The DBC of a recording; BadInputError where there is none, or several of which none has its name."""
    own = path.with_suffix(".dbc")
    if own.exists():
        return own
    found = sorted(path.parent.glob("*.dbc"))
    if len(found) == 1:
        return found[0]
    problem = f"{len(found)} of them lie" if found else "none lies"
    raise BadInputError(
        str(path),
        f"is a recording of a CAN bus, which takes a DBC to read, and {problem} beside it",
        f"the DBC as {own}",
    )


def _frames(path: Path) -> list[tuple[float, int, bytes]]:
    """(time s, identifier, data) of all data frames, in the order of the file."""
    from can import ASCReader, BLFReader, CanutilsLogReader, TRCReader

    with path.open("rb") as file:
        start = file.read(4096)
    reader: Any = CanutilsLogReader
    if start.startswith(b"LOGG"):
        reader = BLFReader
    elif _TRC.match(start):
        reader = TRCReader
    elif not _CANDUMP.match(start):
        reader = ASCReader
    with reader(path) as messages:
        return [
            (float(one.timestamp), one.arbitration_id, bytes(one.data))
            for one in messages
            if not one.is_error_frame and not one.is_remote_frame
        ]


def _of_message(
    name: str, time_s: Floats, rows: Sequence[Json], signals: Sequence[str], units: Mapping[str, str]
) -> Iterator[SampledGroup]:
    """One group of the signals that all frames of a message carry, and one for each selector of a multiplexed one."""
    together: dict[bytes, dict[str, Floats]] = {}
    for signal in signals:
        carried = np.array([signal in row for row in rows], np.bool_).tobytes()
        values = np.array([float(row[signal]) for row in rows if signal in row])
        if len(values):
            together.setdefault(carried, {})[f"{name}.{signal}"] = values
    for carried, columns in together.items():
        inside = np.frombuffer(carried, dtype=np.bool_)
        called = name if inside.all() else f"{name} with {next(iter(columns)).removeprefix(f'{name}.')}"
        yield SampledGroup(called, time_s[inside], columns, {one: units[one] for one in columns if one in units})


def _contents(
    path: Path,
    database: Any,
    rows: dict[str, list[tuple[float, Json]]],
    dbc: Path,
    unknown: set[int],
    undecoded: int,
) -> Contents:
    filled = {name: found for name, found in rows.items() if found}
    times = from_first({name: np.array([stamp for stamp, _ in found]) for name, found in filled.items()})
    groups: list[SampledGroup] = []
    for name, found in filled.items():
        signals = database.get_message_by_name(name).signals
        units = {f"{name}.{one.name}": str(one.unit) for one in signals if one.unit}
        groups += _of_message(name, times[name], [row for _, row in found], [one.name for one in signals], units)
    notes = [f"decoded by {dbc.name}"]
    if unknown:
        notes.append(f"{len(unknown)} identifiers are not in it: {', '.join(f'{x:X}' for x in sorted(unknown)[:8])}")
    if undecoded:
        notes.append(f"{undecoded} frames did not decode")
    return Contents(path, "recording of a CAN bus", tuple(groups), tuple(notes))
