"""A recorded run as a reference that is updated on purpose: what the host does today on yesterday's frames.

The frames that arrived and the commands that were given stay as they are; what the host sends and computes is put in
the place of what it sent and computed then. The changes are listed signal by signal before anything is written.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs.difference import Difference
from gimbal_hil.data.runs.frame_columns import describe_frame
from gimbal_hil.data.runs.log_damage import first_damage
from gimbal_hil.data.runs.new_folder import FILES
from gimbal_hil.data.runs.reader import RecordedRun
from gimbal_hil.data.runs.replaying import BlocksByTick, ReplayHost
from gimbal_hil.data.runs.schema import TICK_ROW, WALL_CLOCK_COLUMNS, Event, FrameDirection, stored_name
from gimbal_hil.data.runs.segments import segments_of
from gimbal_hil.data.runs.writer import RunWriter

_RECORD = 10
_SILENT = {"check", *WALL_CLOCK_COLUMNS}


@dataclass(frozen=True)
class Again:
    """What the host does on the recorded frames: its rows (wall clock as recorded) and the block sent at each tick."""

    rows: NDArray[np.void]
    sent: tuple[bytes, ...]


@dataclass(frozen=True)
class Change:
    """One signal that comes out otherwise: at how many ticks, from which on, and by how much at most and rms (in the
    signal's unit; None for frames).
    """

    signal: str
    ticks: int
    first_tick: int
    largest: float | None = None
    rms: float | None = None

    def in_words(self, total: int) -> str:
        """One line for people."""
        size = "" if self.largest is None else f", by {self.largest:.3g} at most, {self.rms:.3g} rms"
        return f"{self.signal}: at {self.ticks} of {total} ticks, from tick {self.first_tick} on{size}"


def run_again(run: RecordedRun, host: ReplayHost, give: Callable[[Event], None]) -> Again:
    """Run the host over the whole log, whatever it answers. BadInputError where the log is damaged or has no start."""
    damage: Difference | None = first_damage(run)
    if damage is not None or run.first_segment > 1 or run.replayable_ticks < len(run.ticks):
        why = damage.in_words() if damage is not None else "its beginning or its end is not there"
        raise BadInputError(str(run.folder), f"cannot be a reference: {why}", "a whole run; record it anew")
    received = BlocksByTick(run.frames, FrameDirection.DEVICE_TO_HOST)
    commands = sorted(run.commands(), key=lambda event: event.tick)
    rows, sent, given = bytearray(), [], 0
    for tick, time_ns in zip(run.ticks["tick"].tolist(), run.ticks["time_ns"].tolist(), strict=True):
        while given < len(commands) and commands[given].tick <= tick:
            give(commands[given])
            given += 1
        sent.append(host.tick(tick, time_ns, received.of(tick)))
        rows += host.row
    table = np.frombuffer(bytes(rows), TICK_ROW).copy()
    for name in WALL_CLOCK_COLUMNS:
        table[name] = run.ticks[name]
    return Again(table, tuple(sent))


def changes(run: RecordedRun, again: Again) -> list[Change]:
    """Every signal of the rows and every frame that comes out otherwise, in the order of the log; empty: identical."""
    found = []
    ticks = run.ticks["tick"]
    for name in TICK_ROW.names or ():
        old, new = run.ticks[name], again.rows[name]
        if name in _SILENT:
            continue
        # the same bits count as the same: a reference that is not there is NaN in both
        other = _bits(old) != _bits(new)
        if not other.any():
            continue
        apart = np.nan_to_num(np.abs(new[other].astype(float) - old[other].astype(float)))
        rms = float(np.sqrt(np.sum(apart**2) / len(ticks)))
        label = stored_name(name, run.record.header.axes)
        found.append(Change(label, int(other.sum()), int(ticks[other][0]), float(apart.max()), rms))
    expected = BlocksByTick(run.frames, FrameDirection.HOST_TO_DEVICE)
    by_frame: dict[str, list[int]] = {}
    for tick, block in zip(ticks.tolist(), again.sent, strict=True):
        for name in _frames_apart(expected.of(tick), block):
            by_frame.setdefault(name, []).append(tick)
    return found + [Change(f"frame sent, {name}", len(at), at[0]) for name, at in by_frame.items()]


def update(run: RecordedRun, again: Again) -> None:
    """Put what the host does now in the place of what it did; everything else in the folder stays."""
    received = BlocksByTick(run.frames, FrameDirection.DEVICE_TO_HOST)
    end = run.record.end
    with tempfile.TemporaryDirectory(dir=run.folder.parent, prefix=f".{run.folder.name}-") as fresh:
        folder = Path(fresh) / "run"
        writer = RunWriter(folder, run.record.header)
        for event in run.events:
            writer.event(event.tick, event.time_ns, event.kind, event.text, dict(event.data))
        for tick, sent in zip(again.rows["tick"].tolist(), again.sent, strict=True):
            writer.append_exchange(tick, received.of(tick), sent)
        writer.append_ticks(again.rows)
        writer.close(0 if end is None else end.exit_code, "updated as a reference")
        if writer.failure:
            raise BadInputError(str(run.folder), f"could not be written: {writer.failure}", "a disk with room")
        fresh_files = [path for path in folder.iterdir() if path.is_file()]
        stale = {path for name in FILES for _, path in segments_of(run.folder, name)}
        for path in fresh_files:
            os.replace(path, run.folder / path.name)
        # only what has no successor goes, and last: an interruption loses nothing
        for path in stale - {run.folder / path.name for path in fresh_files}:
            path.unlink()
        shutil.rmtree(folder, ignore_errors=True)


def _bits(column: NDArray[np.generic]) -> NDArray[np.generic]:
    return np.ascontiguousarray(column).view(f"u{column.dtype.itemsize}")


def _frames_apart(recorded: bytes, again: bytes) -> Sequence[str]:
    """Names of the frames in which two blocks differ."""
    if recorded == again:
        return ()
    pairs = zip(_records(recorded), _records(again), strict=False)
    names = [describe_frame(int.from_bytes(new[:2], "little")) for old, new in pairs if old != new]
    if len(recorded) != len(again):
        names.append("their number")
    return tuple(dict.fromkeys(names))


def _records(block: bytes) -> list[bytes]:
    return [block[at : at + _RECORD] for at in range(0, len(block), _RECORD)]
