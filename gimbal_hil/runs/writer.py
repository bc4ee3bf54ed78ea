"""Write a run folder while the run goes on.

The tick path only appends to a list; whole batches go to the files about four times a second, so a kill loses a fraction of a
second. Between two flushes the frames of a tick are written before its tick row, and every flush adds one batch to each stream: the
first n batches of both are a run that can be replayed. A disk that refuses ends the recording, not the run: `failure` says why.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import time
from collections.abc import Callable, Mapping
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import EXIT_DONE, EXIT_INTERRUPTED, EXIT_NO, BadInputError
from gimbal_hil.runs.arrow_stream import END_OF_STREAM, batch_bytes, header_bytes
from gimbal_hil.runs.header import RUN_FILE, RunEnd, RunHeader, wall_clock_utc, write_header
from gimbal_hil.runs.integrity import seal
from gimbal_hil.runs.reader import open_run
from gimbal_hil.runs.schema import (
    EVENTS_FILE,
    FRAME_ROW,
    FRAMES_FILE,
    TICK_ROW,
    TICKS_FILE,
    EventKind,
    FrameDirection,
    frames_of_blocks,
    frames_of_rejected,
)

FLUSH_INTERVAL_NS = 200_000_000
FLUSH_TICKS = 16384
#: kept free on the disk so that a full one can still take the last events and the exit status
RESERVE_FILE, RESERVE_BYTES = ".reserve", 65536


class RunWriter:
    """The log of one run. Not for several threads; call `append_ticks` between ticks, never inside one.

    `clock_ns` only paces the flushes. Raises BadInputError when the folder cannot be used or already holds a run and `force` is false.
    """

    def __init__(self, folder: Path, header: RunHeader, *, force: bool = False, clock_ns: Callable[[], int] = time.monotonic_ns) -> None:
        self.folder = Path(folder)
        self.failure: str | None = None
        self._header, self._clock_ns = header, clock_ns
        self._blocks: list[object] = []
        self._frames: list[NDArray[np.void]] = []
        self._ticks: list[NDArray[np.void]] = []
        self._events: list[str] = []
        self._waiting_ticks = 0
        self._counts = {TICKS_FILE: 0, FRAMES_FILE: 0, EVENTS_FILE: 0}
        self._content = {name: hashlib.sha256() for name in self._counts}
        self._closed = False
        self._started_utc = wall_clock_utc()
        self._files = _open_folder(self.folder, header, self._started_utc, force)
        self._flushed_ns = clock_ns()

    @classmethod
    def resumed(cls, folder: Path, header: RunHeader, mark: Mapping[str, int], *, clock_ns: Callable[[], int] = time.monotonic_ns) -> Self:
        """Go on writing a run that was stopped: what came after `mark` (see there) is cut off. Raises BadInputError."""
        folder = Path(folder)
        try:
            for name in (TICKS_FILE, FRAMES_FILE, EVENTS_FILE):
                if (folder / name).stat().st_size < mark[name]:
                    raise BadInputError(str(folder / name), "is shorter than at its checkpoint", "the files that the stopped run left")
                os.truncate(folder / name, mark[name])
        except (OSError, KeyError) as error:
            raise BadInputError(str(folder), f"cannot be gone on with ({error})", "the folder of a stopped run") from error
        run = open_run(folder)
        writer = cls.__new__(cls)
        writer.folder, writer.failure, writer._header, writer._clock_ns = folder, None, header, clock_ns
        writer._blocks, writer._frames, writer._ticks, writer._events, writer._waiting_ticks = [], [], [], [], 0
        writer._closed, writer._started_utc, writer._flushed_ns = False, run.record.started_utc, clock_ns()
        flags = os.O_WRONLY | os.O_APPEND | os.O_CLOEXEC
        writer._files = {name: os.open(folder / name, flags) for name in (TICKS_FILE, FRAMES_FILE, EVENTS_FILE)}
        writer._counts = {TICKS_FILE: len(run.ticks), FRAMES_FILE: len(run.frames), EVENTS_FILE: len(run.events)}
        content = {
            TICKS_FILE: seal(run.ticks.copy()).tobytes(),
            FRAMES_FILE: seal(run.frames.copy()).tobytes(),
            EVENTS_FILE: (folder / EVENTS_FILE).read_bytes(),
        }
        writer._content = {name: hashlib.sha256(data) for name, data in content.items()}
        (folder / RESERVE_FILE).write_bytes(bytes(RESERVE_BYTES))
        write_header(folder, header, writer._started_utc, None)
        return writer

    def mark(self) -> dict[str, int]:
        """Write what waits, and answer the size of each file in bytes: where a resumed run goes on."""
        self.flush()
        return {name: os.fstat(file).st_size for name, file in self._files.items()}

    def append_block(self, tick: int, direction: FrameDirection, block: bytes) -> None:
        """Keep the frames of one block (a run of ten-byte records)."""
        self._blocks.extend((tick, direction, block))

    def append_exchange(self, tick: int, received: bytes, sent: bytes) -> None:
        """Keep what one tick received and then sent: two blocks for the price of one call."""
        self._blocks.extend((tick, 1, received, tick, 0, sent))

    def append_rejected(self, tick: int, data: bytes) -> None:
        """Keep raw bytes that the link refused before they were a frame."""
        self.append_frames(frames_of_rejected(tick, data))

    def append_frames(self, frames: NDArray[np.void]) -> None:
        """Keep frame rows, shape (n,) of FRAME_ROW; `check` need not be set."""
        self._take_blocks()
        self._frames.append(np.array(frames, FRAME_ROW))

    def append_ticks(self, rows: NDArray[np.void]) -> None:
        """Keep tick rows, shape (n,) of TICK_ROW, after all frames of these ticks; writes to disk when it is time to."""
        self._ticks.append(np.array(rows, TICK_ROW))
        self._waiting_ticks += len(rows)
        if self._waiting_ticks >= FLUSH_TICKS or self._clock_ns() - self._flushed_ns >= FLUSH_INTERVAL_NS:
            self.flush()

    def event(self, tick: int, time_ns: int, kind: EventKind, text: str, data: Mapping[str, object] | None = None) -> None:
        """Keep one event; `data` must be plain JSON."""
        line = {"tick": tick, "time_ns": time_ns, "kind": kind.value, "text": text, "data": dict(data or {})}
        self._events.append(json.dumps(line, ensure_ascii=False) + "\n")

    def command(self, tick: int, time_ns: int, text: str, data: Mapping[str, object]) -> None:
        """Keep what an operator or a plan asked of the host core before its tick `tick`: replay asks the same again."""
        self.event(tick, time_ns, EventKind.COMMAND, text, data)

    def flush(self) -> None:
        """Write all that waits: events, then one batch of frames, then one of tick rows."""
        self._take_blocks()
        self._flushed_ns = self._clock_ns()
        events, frames, ticks = self._events, self._frames, self._ticks
        self._events, self._frames, self._ticks, self._waiting_ticks = [], [], [], 0
        if events:
            lines = "".join(events).encode()
            self._append(EVENTS_FILE, lines, len(events), lines)
        if frames or ticks:
            self._append_rows(FRAMES_FILE, FRAME_ROW, frames)
            self._append_rows(TICKS_FILE, TICK_ROW, ticks)

    def close(self, exit_code: int = EXIT_DONE, reason: str = "") -> None:
        """Write what waits, close the streams and put the end into `run.yaml`. A second call does nothing."""
        if self._closed:
            return
        self._closed = True
        self.flush()
        for name in (FRAMES_FILE, TICKS_FILE):
            self._append(name, END_OF_STREAM, 0, b"")
        if self.failure is not None:
            reason = f"{reason}; recording ended early: {self.failure}".removeprefix("; ")
        _remove(self.folder / RESERVE_FILE)
        hashes = {name.split(".")[0]: content.hexdigest() for name, content in self._content.items()}
        end = RunEnd(exit_code, reason, {name.split(".")[0]: count for name, count in self._counts.items()}, hashes)
        try:
            write_header(self.folder, self._header, self._started_utc, end)
        except OSError as error:
            self.failure = self.failure or f"{self.folder / RUN_FILE}: {error.strerror}"
        for file in self._files.values():
            os.close(file)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if error is None:
            self.close()
        elif isinstance(error, KeyboardInterrupt):
            self.close(EXIT_INTERRUPTED, "interrupted")
        else:
            self.close(getattr(error, "exit_code", EXIT_NO), str(error) or type(error).__name__)

    def _take_blocks(self) -> None:
        waiting, self._blocks = self._blocks, []
        if waiting:
            count = len(waiting) // 3
            ticks = np.fromiter(islice(waiting, 0, None, 3), np.int64, count)  # type: ignore[arg-type]
            directions = np.fromiter(islice(waiting, 1, None, 3), np.int64, count)  # type: ignore[arg-type]
            self._frames.append(frames_of_blocks(ticks, directions, waiting[2::3]))  # type: ignore[arg-type]

    def _append_rows(self, name: str, row_type: np.dtype, pieces: list[NDArray[np.void]]) -> None:
        if self.failure is not None:
            return
        rows = np.concatenate(pieces) if pieces else np.zeros(0, row_type)
        content = seal(rows)
        self._append(name, batch_bytes(rows, self._header.axes), len(rows), content.tobytes())

    def _append(self, name: str, data: bytes, count: int, content: bytes) -> None:
        """Write one whole piece or, when the disk refuses, none of it, and end the recording with the reason."""
        if self.failure is not None:
            return
        file = self._files[name]
        good = os.lseek(file, 0, os.SEEK_END)
        try:
            _write_all(file, data)
        except OSError as error:
            os.ftruncate(file, good)
            self.failure = f"{self.folder / name}: {error.strerror}"
            self._note_failure()
        else:
            self._counts[name] += count
            self._content[name].update(content)

    def _note_failure(self) -> None:
        _remove(self.folder / RESERVE_FILE)
        line = {"tick": -1, "time_ns": -1, "kind": EventKind.RECORDING.value, "text": self.failure, "data": {}}
        data = (json.dumps(line) + "\n").encode()
        with contextlib.suppress(OSError):  # the reason stays in `failure`, which the daemon shows
            _write_all(self._files[EVENTS_FILE], data)
            self._counts[EVENTS_FILE] += 1
            self._content[EVENTS_FILE].update(data)


def _open_folder(folder: Path, header: RunHeader, started_utc: str, force: bool) -> dict[str, int]:
    """Make the folder and its files; file descriptors by name."""
    names = (TICKS_FILE, FRAMES_FILE, EVENTS_FILE)
    if not force and any((folder / name).exists() for name in (RUN_FILE, *names)):
        raise BadInputError(str(folder), "already holds a run", "a new folder, or --force to overwrite it")
    files: dict[str, int] = {}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in names:
            files[name] = os.open(folder / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND | os.O_CLOEXEC, 0o644)
        _write_all(files[TICKS_FILE], header_bytes(TICK_ROW, header.axes))
        _write_all(files[FRAMES_FILE], header_bytes(FRAME_ROW, header.axes))
        (folder / RESERVE_FILE).write_bytes(bytes(RESERVE_BYTES))
        write_header(folder, header, started_utc, None)
    except OSError as error:
        for file in files.values():
            os.close(file)
        raise BadInputError(str(folder), error.strerror or str(error), "a folder that can be written to") from error
    return files


def _write_all(file: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(file, view) :]


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):  # an empty place on the disk is all that is lost
        path.unlink(missing_ok=True)
