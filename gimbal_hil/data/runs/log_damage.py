"""What is wrong with a log in itself, before anything is run again: damaged rows, holes, content that is not what was
recorded.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs.difference import Difference
from gimbal_hil.data.runs.frame_columns import describe_difference, describe_frame
from gimbal_hil.data.runs.integrity import explain
from gimbal_hil.data.runs.reader import RecordedRun
from gimbal_hil.data.runs.schema import EventKind, stored_name
from gimbal_hil.data.runs.seal_check import broken_seal


def first_damage(run: RecordedRun) -> Difference | None:
    """The earliest damage, None in a sound log. A log that a kill ended early is sound."""
    return min(damage_of(run), key=lambda found: (found.tick < 0, found.tick), default=None)


def require_frames(run: RecordedRun) -> None:
    """BadInputError for a run that was recorded without frames, as thinned ones are."""
    if len(run.frames):
        return
    every = run.record.every_ticks
    problem = "keeps no frames" if every == 1 else f"keeps no frames, and one tick in {every}"
    raise BadInputError(
        str(run.folder), problem, "a run recorded with recording.frames: true (an experiment's --every 1)"
    )


def damage_of(run: RecordedRun) -> Iterator[Difference]:
    """All that is wrong with a log in itself: damaged rows, holes, lost rows and events, content that is not what was
    sealed.
    """
    for row in run.broken_ticks[:1]:
        found = explain(run.ticks, int(row))
        signal = stored_name(found.column, run.record.header.axes) if found.column else "tick row"
        yield Difference(
            found.tick, signal, _value(found.found), _value(found.original), _reason("the row", found.column)
        )
    for row in run.broken_frames[:1]:
        yield _broken_frame(run, int(row))
    for where, tick in run.holes:
        yield Difference(tick, where, "unreadable bytes", "rows of the log", "the log is damaged there")
    gap = _missing_ticks(run)
    if gap is not None:
        yield gap
    yield from _changed_content(run)


def _broken_frame(run: RecordedRun, row: int) -> Difference:
    found = explain(run.frames, row)
    frame = run.frames[row]
    identifier = int(frame["identifier"])
    name = describe_frame(identifier)
    if found.column == "payload":
        assert isinstance(found.original, int)
        signal, expected, recorded = describe_difference(identifier, found.original, int(frame["payload"]))
        return Difference(found.tick, signal, recorded, expected, _reason(f"this {name} frame", found.column))
    signal = f"{name}.{found.column}" if found.column else name
    return Difference(
        found.tick, signal, _value(found.found), _value(found.original), _reason(f"this {name} frame", found.column)
    )


def _reason(what: str, column: str | None) -> str:
    return f"{what} fails its check in the log: " + ("one bit is wrong" if column else "more than one bit is wrong")


def _value(value: object) -> str:
    return "?" if value is None else str(value)


def _missing_ticks(run: RecordedRun) -> Difference | None:
    """Rows that are not there although the host ran: a step in the tick that nothing explains."""
    ticks, every = run.ticks["tick"], _most_between_rows(run)
    steps = np.diff(ticks)
    if every == 1:
        unexplained = np.flatnonzero(steps - 1 != run.ticks["skipped_ticks"][1:])
    else:
        unexplained = np.flatnonzero(steps > every * (1 + _rows_skipped(run, every)))
    begun = [event.tick for event in run.events if event.begins_log]
    unexplained = unexplained[~np.isin(ticks[unexplained + 1], begun)]
    if not len(unexplained):
        return None
    at = int(unexplained[0])
    due = int(ticks[at]) + every
    return Difference(due, "tick", str(ticks[at + 1]), str(due), "the log has lost rows here")


def _most_between_rows(run: RecordedRun) -> int:
    """Ticks from one row to the next where none was skipped: what the run says, and what a segment asks of a recording
    in lockstep.
    """
    from gimbal_hil.loop.host import Program

    every = run.record.every_ticks
    asked = {1}
    for command in run.commands() if run.record.header.lockstep else ():
        program = command.data.get("program")
        if isinstance(program, Mapping):
            with suppress(BadInputError):
                asked |= Program.from_document(program).record_every
    return max(math.lcm(every, wanted) for wanted in asked)


def _rows_skipped(run: RecordedRun, every: int) -> NDArray[np.int64]:
    """Between two rows of a thinned log, how many may be missing because the host lost their ticks: the row that would
    say so is mostly left out itself, the event is not. Of a real clock one more, for a loss that nobody could explain.
    """
    ticks = run.ticks["tick"]
    rows = np.full(max(0, len(ticks) - 1), 0 if run.record.header.lockstep else 1, np.int64)
    for event in run.events:
        periods = event.data.get("periods")
        after = int(np.searchsorted(ticks, event.tick))
        if event.kind is EventKind.TIMING and isinstance(periods, int) and 0 < after < len(ticks):
            rows[after - 1] += -(-periods // every)
    return rows


def _changed_content(run: RecordedRun) -> Iterator[Difference]:
    """Content whose hash is not the one in run.yaml, for what no single row shows."""
    record = run.record
    # a run that was recorded before there was a chain has the hashes of two parts only
    found = {part: value for part, value in record.found_hashes.items() if part in record.hashes or run.blocks}
    if record.end is not None:
        lines = b"".join(run.event_lines)
        counts = {"ticks": len(run.ticks), "frames": len(run.frames), "events": len(run.event_lines)}
        content = run.content_hashes() | {"events": hashlib.sha256(lines).hexdigest()}
        found |= {part: content[part] for part, count in counts.items() if count == record.end.counts[part]}
    for part, value in found.items():
        if record.hashes.get(part) != value:
            expected = str(record.hashes.get(part))[:12]
            yield Difference(
                -1, part, value[:12], expected, f"the {part} of the run are not those whose hash run.yaml has"
            )
    for line in run.damaged_events[:1]:
        yield Difference(-1, f"events.jsonl line {line}", "unreadable", "an event", "the log is damaged there")
    yield from broken_seal(run)
