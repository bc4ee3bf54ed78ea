"""Read a run folder: finished, still being written, killed, cut anywhere or damaged."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from firmware_protocol.protocol_versions import Protocol, protocol
from gimbal_hil.data.runs.arrow_stream import StreamContent, read_rows
from gimbal_hil.data.runs.chain import SealedBlock, read_chain
from gimbal_hil.data.runs.event_lines import read_event_lines
from gimbal_hil.data.runs.header import RUN_FILE, RunRecord, read_header
from gimbal_hil.data.runs.integrity import broken_rows, content_hash
from gimbal_hil.data.runs.schema import FRAME_ROW, FRAMES_FILE, TICK_ROW, TICKS_FILE, Event, EventKind
from gimbal_hil.data.runs.segments import segments_of

#: what stands in the folder of a bag of ROS 2
_BAG_FILE = "metadata.yaml"


@dataclass(frozen=True)
class RecordedRun:
    """A run as far as its files are whole. `ticks` has TICK_ROW, `frames` FRAME_ROW rows in the order of recording.

    `replayable_ticks` counts the leading tick rows whose frames are certain to be in `frames`. `notes` say in words
    what is missing or unreadable; a row that fails its check is still in the arrays, and `broken_ticks`,
    `broken_frames` point at it. `holes` are damaged stretches inside the files: where, and the tick with which the log
    goes on (-1: not at all).
    """

    folder: Path
    record: RunRecord
    ticks: NDArray[np.void]
    frames: NDArray[np.void]
    events: tuple[Event, ...]
    replayable_ticks: int
    holes: tuple[tuple[str, int], ...]
    notes: tuple[str, ...]
    #: lines of the events' file as they stand, and the numbers of those that hold no event
    event_lines: tuple[bytes, ...] = ()
    damaged_events: tuple[int, ...] = ()
    #: the chain that seals the run as far as it is readable, and whether it is not
    blocks: tuple[SealedBlock, ...] = ()
    chain_damaged: bool = False
    #: the segment that the log begins with; above 1 where older ones were given up on purpose
    first_segment: int = 1

    @cached_property
    def protocol(self) -> Protocol:
        """The version of the wire that the frames are of; BadInputError for one that is not known."""
        return protocol(self.record.protocol, f"{self.folder / RUN_FILE}: protocol")

    @cached_property
    def broken_ticks(self) -> NDArray[np.int64]:
        """Indices into `ticks` of rows that fail their check."""
        return broken_rows(self.ticks)

    @cached_property
    def broken_frames(self) -> NDArray[np.int64]:
        """Indices into `frames` of rows that fail their check."""
        return broken_rows(self.frames)

    def commands(self) -> tuple[Event, ...]:
        """What operators and plans asked for, in order."""
        return tuple(event for event in self.events if event.kind is EventKind.COMMAND)

    def content_hashes(self) -> dict[str, str]:
        """Hashes of `ticks` (without the wall clock's columns) and `frames`: equal for two runs that did the same."""
        return {"ticks": content_hash(self.ticks), "frames": content_hash(self.frames)}


def is_run_folder(path: Path) -> bool:
    """Whether a path should be read as a run folder (any folder but a bag of ROS 2) and not as a file of columns."""
    return path.is_dir() and ((path / RUN_FILE).exists() or not (path / _BAG_FILE).exists())


def open_run(folder: Path) -> RecordedRun:
    """Read all that is whole; raises BadInputError that names the file when something else than a run is there."""
    folder = Path(folder)
    record = read_header(folder)
    ticks = _read_stream(folder, TICKS_FILE, TICK_ROW, record.header.axes)
    frames = _read_stream(folder, FRAMES_FILE, FRAME_ROW, record.header.axes)
    events = read_event_lines(folder)
    blocks, chain_damaged = read_chain(folder)
    both = min(len(ticks.batch_ends), len(frames.batch_ends))
    whole = ticks.batch_ends[both - 1] if both else 0
    if not frames.skipped and (frames.ended or len(frames.batch_ends) >= len(ticks.batch_ends)):
        whole = len(ticks.rows)
    notes = [
        f"{path}: bytes {start} to {end} hold no whole batch and were left out"
        for stream in (ticks, frames)
        for path, start, end, _, _ in stream.skipped
    ]
    first = max(ticks.first_segment, frames.first_segment, events.first_segment)
    notes += events.notes
    if first > 1:
        notes.append(
            f"{folder}: the log begins with segment {first}; what was before it was given up (recording.keep_mb)"
        )
    else:
        found = {"ticks": len(ticks.rows), "frames": len(frames.rows), "events": len(events.lines)}
        notes += _missing_rows(folder, record, blocks, chain_damaged, found)
    notes += _adjusted(folder, events.events)
    if record.end is None:
        notes.append(f"{folder}: the run goes on or was killed: it has no exit status")
    holes = tuple(
        (f"{path.name} from byte {start} on", int(stream.rows["tick"][before]) if before < len(stream.rows) else -1)
        for stream in (ticks, frames)
        for path, start, _, before, inside in stream.skipped
        if inside
    )
    return RecordedRun(
        folder,
        record,
        ticks.rows,
        frames.rows,
        events.events,
        whole,
        holes,
        tuple(notes),
        events.lines,
        events.damaged,
        blocks,
        chain_damaged,
        first,
    )


@dataclass(frozen=True)
class _Stream:
    """All segments of a stream: rows, row count after each batch, and unreadable stretches.

    A stretch is: file, first byte, byte past the last, rows before it, and whether the stream goes on, or is closed,
    behind it.
    """

    rows: NDArray[np.void]
    batch_ends: tuple[int, ...]
    skipped: tuple[tuple[Path, int, int, int, bool], ...]
    ended: bool
    first_segment: int


def _read_stream(folder: Path, name: str, row_type: np.dtype, axes: tuple[str, str]) -> _Stream:
    segments = segments_of(folder, name)
    if not segments:
        raise BadInputError(str(folder / name), "is missing", "the log of the run")
    pieces: list[NDArray[np.void]] = []
    ends: list[int] = []
    skipped: list[tuple[Path, int, int, int, bool]] = []
    total, ended = 0, False
    for place, (_, path) in enumerate(segments):
        content: StreamContent = read_rows(path, row_type, axes)
        size, last = path.stat().st_size, place == len(segments) - 1
        ends += [total + end for end in content.batch_ends]
        skipped += [
            (path, start, end, total + before, end < size or content.ended or not last)
            for start, end, before in content.skipped
        ]
        pieces.append(content.rows)
        total += len(content.rows)
        ended = content.ended
    return _Stream(np.concatenate(pieces), tuple(ends), tuple(skipped), ended, segments[0][0])


def _adjusted(folder: Path, events: tuple[Event, ...]) -> list[str]:
    """Which gains and limits an operator changed: the configuration in run.yaml is what the run began with."""
    found = [event for event in events if event.data.get("command") == "adjust"]
    if not found:
        return []
    values = found[-1].data.get("values")
    numbers = [
        f"{axis}.{key} {value:g}"
        for axis, own in (values.items() if isinstance(values, dict) else ())
        for key, value in (own.items() if isinstance(own, dict) else ())
        if isinstance(value, int | float)
    ]
    last = f"in force at the end: {', '.join(numbers)}" if numbers else "at the end as configured"
    ticks = f"tick {found[0].tick}" + (f" (and {len(found) - 1} times later)" if len(found) > 1 else "")
    return [f"{folder}: gains or limits were changed at {ticks}; {last}"]


def _missing_rows(
    folder: Path, record: RunRecord, blocks: tuple[SealedBlock, ...], damaged: bool, found: dict[str, int]
) -> list[str]:
    counts = record.end.counts if record.end is not None else {}
    if record.end is None and blocks and not damaged:
        counts = {"ticks": blocks[-1].ticks, "frames": blocks[-1].frames, "events": blocks[-1].events}
    return [
        f"{folder}: {found[part]} of {count} {part} are left" for part, count in counts.items() if found[part] < count
    ]
