"""Write a run folder while the run goes on.

The tick path only appends to a list; whole batches go to the files twenty times a second, so a kill loses a tenth of a
second at most. Between two flushes the frames of a tick are written before its tick row, and every flush adds one batch
to each stream and one line to the chain that seals the run (see `chain`): the first n batches of both are a run that
can be replayed. A disk that refuses, or a folder that is taken away, ends the recording, not the run: `failure` says
why. A disk that is nearly full asks for an end in good order: `running_out`.
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

from firmware_protocol.documents import printable, text_problem
from firmware_protocol.errors import EXIT_DONE, EXIT_INTERRUPTED, EXIT_NO, BadInputError, SafetyStopError
from gimbal_hil.data.runs.arrow_messages import batch_bytes
from gimbal_hil.data.runs.arrow_stream import END_OF_STREAM
from gimbal_hil.data.runs.chain import CHAIN_FILE, SealedBlock, linked, read_chain
from gimbal_hil.data.runs.disk import MB, Retention, free_mb, require_free, vanished
from gimbal_hil.data.runs.header import RUN_FILE, RunEnd, RunHeader, write_header
from gimbal_hil.data.runs.integrity import seal
from gimbal_hil.data.runs.new_folder import (
    FILES,
    RESERVE_BYTES,
    RESERVE_FILE,
    STREAMS,
    open_folder,
    open_segment,
    remove,
    write_all,
)
from gimbal_hil.data.runs.reader import open_run
from gimbal_hil.data.runs.run_lock import RunLock
from gimbal_hil.data.runs.schema import (
    EVENTS_FILE,
    FRAME_ROW,
    FRAMES_FILE,
    TICK_ROW,
    TICKS_FILE,
    EventKind,
    frames_of_blocks,
)
from gimbal_hil.data.runs.segments import give_up_old_segments, segment_name, segments_of
from gimbal_hil.loop.timing import wall_clock_utc

FLUSH_INTERVAL_NS = 50_000_000
FLUSH_TICKS = 16384
#: how often the disk is looked at
_LOOK_INTERVAL_NS = 1_000_000_000
_SEGMENT = "segment"


class RunWriter:
    """The log of one run. Not for several threads; call `append_ticks` between ticks, never inside one.

    `clock_ns` only paces the flushes. Raises BadInputError when the folder cannot be used, is recorded into by another
    process, or already holds a run and `force` is false.
    """

    def __init__(
        self,
        folder: Path,
        header: RunHeader,
        *,
        force: bool = False,
        retention: Retention | None = None,
        clock_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._begin(Path(folder), header, retention, clock_ns)
        require_free(self.folder, self._retention)
        self._started_utc = wall_clock_utc()
        self._lock, self._files, self._last_hash = open_folder(self.folder, header, self._started_utc, force)

    def _begin(self, folder: Path, header: RunHeader, retention: Retention | None, clock_ns: Callable[[], int]) -> None:
        self.folder = folder
        self.failure: str | None = None
        self.running_out: str | None = None
        self._header, self._clock_ns, self._retention = header, clock_ns, retention or Retention()
        self._blocks: list[object] = []
        self._frames: list[NDArray[np.void]] = []
        self._ticks: list[NDArray[np.void]] = []
        self._events: list[str] = []
        self._waiting_ticks = 0
        self._counts = {TICKS_FILE: 0, FRAMES_FILE: 0, EVENTS_FILE: 0}
        self._content = {name: hashlib.sha256() for name in self._counts}
        self._segment, self._segment_bytes, self._warned = 1, 0, False
        self._closed = False
        #: what an operator changed of gains and limits, as the last such command has it
        self._adjusted: dict[str, Mapping[str, float]] = {}
        #: the line that says why recording has ended, until it is sealed
        self._noted = b""
        self._flushed_ns = self._looked_ns = clock_ns()

    @classmethod
    def resumed(
        cls,
        folder: Path,
        header: RunHeader,
        mark: Mapping[str, int],
        *,
        retention: Retention | None = None,
        clock_ns: Callable[[], int] = time.monotonic_ns,
    ) -> Self:
        """Go on writing a run that was stopped: what came after `mark` (see there) is cut off. Raises BadInputError."""
        folder = Path(folder)
        writer = cls.__new__(cls)
        writer._begin(folder, header, retention, clock_ns)
        try:
            writer._lock = RunLock(folder)
            writer._segment = mark[_SEGMENT]
            paths = {name: folder / writer._name_of(name) for name in FILES}
            for name, path in paths.items():
                if path.stat().st_size < mark[name]:
                    raise BadInputError(
                        str(path), "is shorter than at its checkpoint", "the files that the stopped run left"
                    )
                os.truncate(path, mark[name])
            for name in FILES:
                for number, path in segments_of(folder, name):
                    if number > writer._segment:
                        path.unlink()
        except (OSError, KeyError) as error:
            raise BadInputError(str(folder), f"cannot be continued ({error})", "the folder of a stopped run") from error
        run = open_run(folder)
        blocks, _ = read_chain(folder)
        writer._started_utc, writer._last_hash = (
            run.record.started_utc,
            blocks[-1].sha256 if blocks else run.record.genesis,
        )
        writer._files = {name: os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CLOEXEC) for name, path in paths.items()}
        writer._segment_bytes = sum(mark[name] for name in FILES)
        last = blocks[-1] if blocks else SealedBlock(0, 0, 0, "")
        writer._counts = {TICKS_FILE: last.ticks, FRAMES_FILE: last.frames, EVENTS_FILE: last.events}
        content = {
            TICKS_FILE: seal(run.ticks.copy()).tobytes(),
            FRAMES_FILE: seal(run.frames.copy()).tobytes(),
            EVENTS_FILE: b"".join(run.event_lines),
        }
        writer._content = {name: hashlib.sha256(data) for name, data in content.items()}
        (folder / RESERVE_FILE).write_bytes(bytes(RESERVE_BYTES))
        write_header(folder, header, writer._started_utc, None)
        return writer

    def mark(self) -> dict[str, int]:
        """Write what waits, and answer the segment and the size of each file in bytes: where a resumed run goes on."""
        self.flush()
        return {name: os.fstat(file).st_size for name, file in self._files.items()} | {_SEGMENT: self._segment}

    def require_room(self) -> None:
        """SafetyStopError where the recording has failed, or should end because the disk is nearly full."""
        if self.failure is not None or self.running_out is not None:
            raise SafetyStopError(f"recording has to end: {self.failure or self.running_out}")

    @property
    def is_low(self) -> bool:
        """Whether it has been said that the disk runs full."""
        return self._warned

    @property
    def free_mb(self) -> float | None:
        """Free space of the disk that is recorded to, MiB."""
        return free_mb(self.folder)

    def append_exchange(self, tick: int, received: bytes, sent: bytes) -> None:
        """Keep what one tick received and then sent: two blocks for the price of one call."""
        self._blocks.extend((tick, 1, received, tick, 0, sent))

    def append_frames(self, frames: NDArray[np.void]) -> None:
        """Keep frame rows, shape (n,) of FRAME_ROW; `check` need not be set."""
        self._take_blocks()
        self._frames.append(np.array(frames, FRAME_ROW))

    def append_ticks(self, rows: NDArray[np.void]) -> None:
        """Keep tick rows, shape (n,) of TICK_ROW, after all frames of these ticks; writes to disk when it is time
        to.
        """
        self._ticks.append(np.array(rows, TICK_ROW))
        self._waiting_ticks += len(rows)
        if self._waiting_ticks >= FLUSH_TICKS or self._clock_ns() - self._flushed_ns >= FLUSH_INTERVAL_NS:
            self.flush()

    def event(
        self, tick: int, time_ns: int, kind: EventKind, text: str, data: Mapping[str, object] | None = None
    ) -> None:
        """Keep one event; `data` must be plain JSON."""
        line = {"tick": tick, "time_ns": time_ns, "kind": kind.value, "text": text, "data": dict(data or {})}
        text = json.dumps(line, ensure_ascii=False)
        if text_problem(text) is not None:
            text = json.dumps(printable(line), ensure_ascii=False)
        self._events.append(text + "\n")

    def command(self, tick: int, time_ns: int, text: str, data: Mapping[str, object]) -> None:
        """Keep the request of an operator or plan to the host core before its tick `tick`; replay repeats it."""
        if data.get("command") == "adjust":
            values = data.get("values")
            self._adjusted = dict(values) if isinstance(values, Mapping) else {}
        self.event(tick, time_ns, EventKind.COMMAND, text, data)

    def flush(self) -> None:
        """Write all that waits: events, then one batch of frames, then one of tick rows, then the line that seals
        them.
        """
        self._take_blocks()
        self._flushed_ns = self._clock_ns()
        if self._flushed_ns - self._looked_ns >= _LOOK_INTERVAL_NS:
            self._look_at_the_disk()
        events, frames, ticks = self._events, self._frames, self._ticks
        self._events, self._frames, self._ticks, self._waiting_ticks = [], [], [], 0
        if not (events or frames or ticks) or self.failure is not None:
            return
        lines = "".join(events).encode()
        if events and not self._append(EVENTS_FILE, lines, len(events), lines):
            lines = b""
        written = dict.fromkeys(STREAMS, b"")
        if frames or ticks:
            written = {
                name: self._append_rows(name, pieces) for name, pieces in ((FRAMES_FILE, frames), (TICKS_FILE, ticks))
            }
        self._link(written[TICKS_FILE], written[FRAMES_FILE], lines)
        if self._segment_bytes >= self._retention.segment_mb * MB and self.failure is None:
            self._begin_segment()

    def close(self, exit_code: int = EXIT_DONE, reason: str = "") -> None:
        """Write what waits, close the streams and put the end into `run.yaml`. A second call does nothing.

        After it, `failure` says whether all that was given is in the folder.
        """
        if self._closed:
            return
        self._closed = True
        self._look_at_the_disk()
        self.flush()
        for name in STREAMS:
            self._append(name, END_OF_STREAM, 0, b"")
        if self._noted:
            self._link(b"", b"", b"")
        if self.failure is not None:
            reason = f"{reason}; recording ended early: {self.failure}".removeprefix("; ")
        remove(self.folder / RESERVE_FILE)
        hashes = {name.split(".")[0]: content.hexdigest() for name, content in self._content.items()}
        counts = {name.split(".")[0]: count for name, count in self._counts.items()}
        ending = RunEnd(exit_code, reason, counts, hashes, self._last_hash, self._adjusted)
        try:
            write_header(self.folder, self._header, self._started_utc, ending)
        except OSError as error:
            self.failure = self.failure or f"{self.folder / RUN_FILE}: {error.strerror}"
        for file in self._files.values():
            os.close(file)
        self._lock.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
            self.require_room()
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

    def _append_rows(self, name: str, pieces: list[NDArray[np.void]]) -> bytes:
        """One batch of rows; answers the rows as they are sealed."""
        rows = np.concatenate(pieces) if pieces else np.zeros(0, STREAMS[name])
        content = seal(rows)
        data = batch_bytes(rows)
        if not self._append(name, data, len(rows), content.tobytes()):
            return b""
        self._segment_bytes += len(data)
        return rows.tobytes()

    def _link(self, ticks: bytes, frames: bytes, events: bytes) -> None:
        """The line that seals what has just been written, with the reason why recording has just ended, if it has."""
        events += self._noted
        self._noted = b""
        self._last_hash = linked(self._last_hash, ticks, frames, events)
        line = self._last_line()
        self._segment_bytes += len(events) + len(line)
        try:
            write_all(self._files[CHAIN_FILE], line)
        except OSError as error:
            self.failure = self.failure or f"{self.folder / self._name_of(CHAIN_FILE)}: {error.strerror}"

    def _last_line(self) -> bytes:
        """The line of the chain that seals all that is written."""
        counts = self._counts
        return SealedBlock(counts[TICKS_FILE], counts[FRAMES_FILE], counts[EVENTS_FILE], self._last_hash).line()

    def _append(self, name: str, data: bytes, count: int, content: bytes) -> bool:
        """Write one whole piece or, when the disk refuses, none of it, and end the recording with the reason; whether
        it is written.
        """
        if self.failure is not None:
            return False
        file = self._files[name]
        good = os.lseek(file, 0, os.SEEK_END)
        try:
            write_all(file, data)
        except OSError as error:
            os.ftruncate(file, good)
            self.failure = f"{self.folder / self._name_of(name)}: {error.strerror}"
            self._note_failure()
            return False
        if name in self._counts:
            self._counts[name] += count
            self._content[name].update(content)
        return True

    def _name_of(self, name: str) -> str:
        """Name of the file that a kind of content goes to now."""
        return segment_name(name, self._segment)

    def _look_at_the_disk(self) -> None:
        """Does what is written still reach the folder, and is there room for more?"""
        self._looked_ns = self._clock_ns()
        if self.failure is None:
            self.failure = vanished(self.folder, [(self._name_of(name), file) for name, file in self._files.items()])
        free = free_mb(self.folder)
        if free is None or self.running_out is not None:
            return
        if free < self._retention.stop_below_mb:
            least = self._retention.stop_below_mb
            self.running_out = (
                f"{self.folder}: {free:.0f} MiB are left on the disk, and recording.stop_below_mb is {least:g}"
            )
            self.event(-1, -1, EventKind.RECORDING, self.running_out, {"free_mb": round(free)})
        elif free < self._retention.warn_below_mb and not self._warned:
            self._warned = True
            text = f"{free:.0f} MiB are left on the disk; the run is ended at {self._retention.stop_below_mb:g}"
            self.event(-1, -1, EventKind.RECORDING, text, {"free_mb": round(free)})

    def _begin_segment(self) -> None:
        """Close the streams, go on in the files of the next number, and give up the oldest where not all is kept."""
        for name in STREAMS:
            self._append(name, END_OF_STREAM, 0, b"")
        self._segment_bytes = 0
        if self.failure is not None:
            return
        try:
            fresh = open_segment(self.folder, self._segment + 1, self._header.axes, self._last_line())
        except OSError as error:
            self.failure = f"{self.folder / segment_name(TICKS_FILE, self._segment + 1)}: {error.strerror}"
            self._note_failure()
            self._link(b"", b"", b"")
            return
        for file in self._files.values():
            os.close(file)
        self._files, self._segment = fresh, self._segment + 1
        keep_mb = self._retention.keep_mb
        for number in [] if keep_mb is None else give_up_old_segments(self.folder, FILES, keep_mb * MB):
            text = f"segment {number} of the log was given up: recording.keep_mb is {keep_mb:g}"
            self.event(-1, -1, EventKind.RECORDING, text, {"given_up_segment": number})

    def _note_failure(self) -> None:
        remove(self.folder / RESERVE_FILE)
        line = {"tick": -1, "time_ns": -1, "kind": EventKind.RECORDING.value, "text": self.failure, "data": {}}
        data = (json.dumps(line) + "\n").encode()
        with contextlib.suppress(OSError):  # the reason stays in `failure`, which the daemon shows
            write_all(self._files[EVENTS_FILE], data)
            self._counts[EVENTS_FILE] += 1
            self._content[EVENTS_FILE].update(data)
            self._noted += data
