"""`events.jsonl` and its further segments read line by line: a damaged line costs the event in it, no other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from firmware_protocol.documents import DocumentLimits, json_line
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs.schema import EVENTS_FILE, Event, EventKind
from gimbal_hil.data.runs.segments import segments_of

#: a command carries its whole program
_LIMITS = DocumentLimits(size_bytes=64 << 20, values=4_000_000, finite=False)


@dataclass(frozen=True)
class EventLines:
    """The events that could be read, the lines as they stand (with their line feeds), and the numbers of those that
    hold none, counted through all segments.
    """

    events: tuple[Event, ...]
    lines: tuple[bytes, ...]
    damaged: tuple[int, ...]
    notes: tuple[str, ...]
    #: the segment that they begin with
    first_segment: int


def read_event_lines(folder: Path) -> EventLines:
    """All events of a run; a last line that was cut is no damage but the end of what was written. BadInputError where
    there is no file.
    """
    segments = segments_of(folder, EVENTS_FILE)
    if not segments:
        raise BadInputError(str(folder / EVENTS_FILE), "is missing", "the events of the run")
    lines: list[bytes] = []
    events: list[Event] = []
    damaged: list[int] = []
    notes: list[str] = []
    for _, path in segments:
        here = _lines_of(path)
        lines += here
        for number, line in enumerate(here, 1):
            found = list(_events_in(line))
            events += found
            if number == len(here) and path == segments[-1][1] and not line.endswith(b"\n"):
                notes.append(f"{path}: the last line is cut" + ("" if found else " and was left out"))
            elif len(found) != 1:
                damaged.append(len(lines) - len(here) + number)
                kept = f"{len(found)} events in it were kept" if found else "its event is lost"
                notes.append(f"{path}: line {number} is damaged; {kept}")
    return EventLines(tuple(events), tuple(lines), tuple(damaged), tuple(notes), segments[0][0])


class GrowingEvents:
    """The events of a run that goes on: each look takes the whole lines that are new since the last one."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        segments = segments_of(folder, EVENTS_FILE)
        self._segment = segments[0][0] if segments else 1
        self._at = 0

    def new_events(self) -> list[Event]:
        """Events in the order of recording; damaged lines are left out."""
        found: list[Event] = []
        for number, path in segments_of(self._folder, EVENTS_FILE):
            if number < self._segment:
                continue
            if number > self._segment:
                self._segment, self._at = number, 0
            try:
                with path.open("rb") as file:
                    file.seek(self._at)
                    data = file.read()
            except OSError as error:
                raise BadInputError(str(path), error.strerror or "cannot be read", "the events of the run") from error
            whole = data[: data.rfind(b"\n") + 1]
            self._at += len(whole)
            for line in whole.splitlines(keepends=True):
                found += _events_in(line)
        return found


def _lines_of(path: Path) -> list[bytes]:
    try:
        return path.read_bytes().splitlines(keepends=True)
    except OSError as error:
        raise BadInputError(str(path), error.strerror or "cannot be read", "the events of the run") from error


def _events_in(line: bytes) -> Iterator[Event]:
    """The event of a line; two where the line feed between them was damaged."""
    event = _event(line)
    if event is not None:
        yield event
        return
    at = line.find(b'{"tick"', 1)
    if at > 0:
        for part in (line[: at - 1], line[at:]):
            event = _event(part)
            if event is not None:
                yield event


def _event(line: bytes) -> Event | None:
    try:
        document = json_line(line, "events", "an event", _LIMITS)
    except BadInputError:
        return None
    tick, time_ns, kind, text, data = (document.get(key) for key in ("tick", "time_ns", "kind", "text", "data"))
    whole = all(isinstance(number, int) and not isinstance(number, bool) for number in (tick, time_ns))
    if not whole or not isinstance(text, str) or not isinstance(data, dict) or kind not in EventKind._value2member_map_:
        return None
    return Event(tick, time_ns, EventKind(kind), text, data)  # type: ignore[arg-type]
