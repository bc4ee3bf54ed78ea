"""The files of a run that begins: made, locked, with their headers; and how bytes get into them."""

from __future__ import annotations

import contextlib
import os
import shutil
from pathlib import Path

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs.arrow_messages import header_bytes
from gimbal_hil.data.runs.chain import CHAIN_FILE
from gimbal_hil.data.runs.header import RUN_FILE, RunHeader, write_header
from gimbal_hil.data.runs.run_lock import RunLock
from gimbal_hil.data.runs.schema import EVENTS_FILE, FRAME_ROW, FRAMES_FILE, TICK_ROW, TICKS_FILE
from gimbal_hil.data.runs.segments import segment_name, segments_of

#: kept free on the disk so that a full one can still take the last events and the exit status
RESERVE_FILE, RESERVE_BYTES = ".reserve", 65536
STREAMS = {FRAMES_FILE: FRAME_ROW, TICKS_FILE: TICK_ROW}
#: run folders of what the scope caught
SCOPE_FOLDER = "scope"
FILES = (TICKS_FILE, FRAMES_FILE, EVENTS_FILE, CHAIN_FILE)


def open_folder(folder: Path, header: RunHeader, started_utc: str, force: bool) -> tuple[RunLock, dict[str, int], str]:
    """Make the folder and its files, locked: the lock, file descriptors by name, and the first hash of the chain."""
    lock: RunLock | None = None
    files: dict[str, int] = {}
    try:
        there = [name for name in (RUN_FILE, *FILES) if (folder / name).exists()]
        if there and not force:
            raise BadInputError(str(folder), "already holds a run", "a new folder, or --force to overwrite it")
        folder.mkdir(parents=True, exist_ok=True)
        lock = RunLock(folder)
        for name in FILES:
            for _, path in segments_of(folder, name):
                path.unlink()
        shutil.rmtree(folder / SCOPE_FOLDER, ignore_errors=True)
        files = open_segment(folder, 1, header.axes, b"")
        (folder / RESERVE_FILE).write_bytes(bytes(RESERVE_BYTES))
        return lock, files, write_header(folder, header, started_utc, None)
    except OSError as error:
        for file in files.values():
            os.close(file)
        if lock is not None:
            lock.release()
        raise BadInputError(str(folder), error.strerror or str(error), "a folder that can be written to") from error


def open_segment(folder: Path, number: int, axes: tuple[str, str], last_line: bytes) -> dict[str, int]:
    """Make the files of a segment: descriptors by name of the part. Its chain begins with the last line of the chain
    before, so that it can be checked without it. OSError with nothing left behind where one of them cannot be made.
    """
    files: dict[str, int] = {}
    try:
        for name in FILES:
            files[name] = created(folder / segment_name(name, number))
        for name, row_type in STREAMS.items():
            write_all(files[name], header_bytes(row_type, axes))
        write_all(files[CHAIN_FILE], last_line)
    except OSError:
        for name, file in files.items():
            os.close(file)
            remove(folder / segment_name(name, number))
        raise
    return files


def created(path: Path) -> int:
    """Descriptor of a new, empty file that is only appended to."""
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND | os.O_CLOEXEC, 0o644)


def write_all(file: int, data: bytes) -> None:
    """Write every byte, in as many calls as the system wants; OSError where it refuses."""
    view = memoryview(data)
    while view:
        view = view[os.write(file, view) :]


def remove(path: Path) -> None:
    """Remove a file that nothing depends on."""
    with contextlib.suppress(OSError):  # an empty place on the disk is all that is lost
        path.unlink(missing_ok=True)
