"""Read a run folder: finished, still being written, killed, cut anywhere or damaged."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.runs.arrow_stream import StreamContent, read_rows
from gimbal_hil.runs.header import RunRecord, read_header
from gimbal_hil.runs.integrity import broken_rows, content_hash
from gimbal_hil.runs.schema import EVENTS_FILE, FRAME_ROW, FRAMES_FILE, TICK_ROW, TICKS_FILE, Event, EventKind


@dataclass(frozen=True)
class Run:
    """A run as far as its files are whole. `ticks` has TICK_ROW, `frames` FRAME_ROW rows in the order of recording.

    `replayable_ticks` counts the leading tick rows whose frames are certain to be in `frames`. `notes` say in words what is
    missing or unreadable; a row that fails its check is still in the arrays, and `broken_ticks`, `broken_frames` point at it.
    `holes` are damaged stretches inside the files: where, and the tick with which the log goes on (-1: not at all).
    """

    folder: Path
    record: RunRecord
    ticks: NDArray[np.void]
    frames: NDArray[np.void]
    events: tuple[Event, ...]
    replayable_ticks: int
    holes: tuple[tuple[str, int], ...]
    notes: tuple[str, ...]

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
    """Whether a path should be read as a run folder (any folder) and not as a table file."""
    return path.is_dir()


def open_run(folder: Path) -> Run:
    """Read all that is whole; raises BadInputError that names the file when something else than a run is there."""
    folder = Path(folder)
    record = read_header(folder)
    ticks = _read_stream(folder / TICKS_FILE, TICK_ROW, record.header.axes)
    frames = _read_stream(folder / FRAMES_FILE, FRAME_ROW, record.header.axes)
    events, event_note = _read_events(folder / EVENTS_FILE)
    both = min(len(ticks.batch_ends), len(frames.batch_ends))
    whole = ticks.batch_ends[both - 1] if both else 0
    if not frames.skipped and (frames.ended or len(frames.batch_ends) >= len(ticks.batch_ends)):
        whole = len(ticks.rows)
    notes = [
        f"{folder / name}: bytes {start} to {end} hold no whole batch and were left out"
        for name, content in ((TICKS_FILE, ticks), (FRAMES_FILE, frames))
        for start, end, _ in content.skipped
    ]
    notes += event_note + _missing_rows(folder, record, {"ticks": len(ticks.rows), "frames": len(frames.rows), "events": len(events)})
    if record.end is None:
        notes.append(f"{folder}: the run goes on or was killed: it has no exit status")
    holes = _holes(folder / TICKS_FILE, ticks) + _holes(folder / FRAMES_FILE, frames)
    return Run(folder, record, ticks.rows, frames.rows, events, whole, holes, tuple(notes))


def _holes(path: Path, content: StreamContent) -> tuple[tuple[str, int], ...]:
    """Stretches that are unreadable although the stream goes on, or is closed, behind them."""
    size = path.stat().st_size
    ticks = content.rows["tick"]
    inside = [(start, before) for start, end, before in content.skipped if end < size or content.ended]
    return tuple((f"{path.name} from byte {start} on", int(ticks[before]) if before < len(ticks) else -1) for start, before in inside)


def _read_stream(path: Path, row_type: np.dtype, axes: tuple[str, str]) -> StreamContent:
    if not path.exists():
        raise BadInputError(str(path), "is missing", "the log of the run")
    return read_rows(path, row_type, axes)


def _missing_rows(folder: Path, record: RunRecord, found: dict[str, int]) -> list[str]:
    counts = record.end.counts if record.end is not None else {}
    return [f"{folder}: {found[part]} of {count} {part} are left" for part, count in counts.items() if found[part] < count]


def _read_events(path: Path) -> tuple[tuple[Event, ...], list[str]]:
    """All whole lines; a cut last line is left out with a note, any other line that is no event is refused."""
    try:
        lines = path.read_bytes().split(b"\n")
    except OSError as error:
        raise BadInputError(str(path), error.strerror or "cannot be read", "the events of the run") from error
    events = []
    for number, line in enumerate(lines[:-1], 1):
        try:
            event = json.loads(line)
            events.append(
                Event(int(event["tick"]), int(event["time_ns"]), EventKind(event["kind"]), str(event["text"]), dict(event["data"]))
            )
        except (ValueError, KeyError, TypeError) as error:
            raise BadInputError(f"{path}: line {number}", "is not an event", "a line that gimbal-hil wrote") from error
    if lines[-1] and _is_whole(lines[-1][:-1]):
        # a cut line is never whole: its line feed is what was damaged
        raise BadInputError(f"{path}: line {len(lines)}", "does not end in a line feed", "a line that gimbal-hil wrote")
    cut = [f"{path}: the last line is cut and was left out"] if lines[-1] else []
    return tuple(events), cut


def _is_whole(line: bytes) -> bool:
    """Whether a line is complete JSON."""
    try:
        json.loads(line)
    except ValueError:
        return False
    return True
