"""The log of a run that goes on, read as it grows: what came since the last look, nothing twice."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.runs.arrow_stream import GrowingStream
from gimbal_hil.runs.header import read_header
from gimbal_hil.runs.reader import Run
from gimbal_hil.runs.schema import FRAME_ROW, FRAMES_FILE, TICK_ROW, TICKS_FILE


class GrowingLog:
    """Ticks and frames of the run in `folder`, from a tick on; raises BadInputError where there is no such run."""

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)
        self.record = read_header(self.folder)
        self._ticks = _Kept(GrowingStream(self.folder / TICKS_FILE, TICK_ROW, self.record.header.axes))
        self._frames = _Kept(GrowingStream(self.folder / FRAMES_FILE, FRAME_ROW, self.record.header.axes))

    def look(self, from_tick: int) -> Run:
        """The log from a tick on as far as it is written by now, without events; rows before that tick are let go."""
        # frames of a tick are written before its row: read the other way round, a row could come without its frames
        ticks = self._ticks.from_tick(from_tick)
        frames = self._frames.from_tick(from_tick)
        return Run(self.folder, self.record, ticks, frames, (), len(ticks), (), ())


class _Kept:
    """Rows of a stream that are still wanted."""

    def __init__(self, stream: GrowingStream) -> None:
        self._stream = stream
        self._pieces: list[NDArray[np.void]] = []

    def from_tick(self, tick: int) -> NDArray[np.void]:
        for rows in self._stream.new_batches():
            self._pieces.append(rows)
            self._drop_before(tick)
        self._drop_before(tick)
        rows = np.concatenate(self._pieces) if self._pieces else np.zeros(0, self._stream.row_type)
        return rows[rows["tick"] >= tick]

    def _drop_before(self, tick: int) -> None:
        """Whole batches only: their rows are in order of time."""
        while self._pieces and (not len(self._pieces[0]) or self._pieces[0]["tick"][-1] < tick):
            self._pieces.pop(0)
