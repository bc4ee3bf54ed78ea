"""The log of a run that goes on, read as it grows: what came since the last look, nothing twice."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.runs.arrow_stream import GrowingStream
from gimbal_hil.data.runs.event_lines import GrowingEvents
from gimbal_hil.data.runs.header import read_header
from gimbal_hil.data.runs.reader import RecordedRun
from gimbal_hil.data.runs.schema import FRAME_ROW, FRAMES_FILE, TICK_ROW, TICKS_FILE, Event
from gimbal_hil.data.runs.segments import segment_name, segments_of


class GrowingLog:
    """Ticks and frames of the run in `folder`, from a tick on; raises BadInputError where there is no such run."""

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)
        self.record = read_header(self.folder)
        self._ticks = _Kept(self.folder, TICKS_FILE, TICK_ROW, self.record.header.axes)
        self._frames = _Kept(self.folder, FRAMES_FILE, FRAME_ROW, self.record.header.axes)
        self._events = GrowingEvents(self.folder)

    def look(self, from_tick: int) -> RecordedRun:
        """The log from a tick on as far as it is written by now, without events; rows before that tick are let go."""
        # frames of a tick are written before its row: read the other way round, a row could come without its frames
        ticks = self._ticks.from_tick(from_tick)
        frames = self._frames.from_tick(from_tick)
        return RecordedRun(self.folder, self.record, ticks, frames, (), len(ticks), (), ())

    def new_events(self) -> list[Event]:
        """Events since the last call; those of a tick are written before the row of a later tick is."""
        return self._events.new_events()


class _Kept:
    """Rows of a stream that are still wanted, read segment after segment."""

    def __init__(self, folder: Path, name: str, row_type: np.dtype, axes: tuple[str, str]) -> None:
        self._folder, self._name, self._row_type, self._axes = folder, name, row_type, axes
        there = segments_of(folder, name)
        self._segment = there[0][0] if there else 1
        self._stream = self._opened()
        self._pieces: list[NDArray[np.void]] = []

    def from_tick(self, tick: int) -> NDArray[np.void]:
        # a segment is complete when there is one behind it: what came to it meanwhile is read before going on
        while (following := self._following()) is not None:
            self._take_new(tick)
            self._segment, self._stream = following, self._opened(following)
        self._take_new(tick)
        rows = np.concatenate(self._pieces) if self._pieces else np.zeros(0, self._row_type)
        return rows[rows["tick"] >= tick]

    def _opened(self, number: int | None = None) -> GrowingStream:
        return GrowingStream(
            self._folder / segment_name(self._name, number or self._segment), self._row_type, self._axes
        )

    def _following(self) -> int | None:
        return next((number for number, _ in segments_of(self._folder, self._name) if number > self._segment), None)

    def _take_new(self, tick: int) -> None:
        for rows in self._stream.new_batches():
            self._pieces.append(rows)
            self._drop_before(tick)
        self._drop_before(tick)

    def _drop_before(self, tick: int) -> None:
        """Whole batches only: their rows are in order of time."""
        while self._pieces and (not len(self._pieces[0]) or self._pieces[0]["tick"][-1] < tick):
            self._pieces.pop(0)
