"""One writer to a run folder: a lock that the system gives back whatever becomes of the process that held it."""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from firmware_protocol.errors import BadInputError

LOCK_FILE = ".lock"

#: descriptors of the locks that this process holds
_held: set[int] = set()


def _let_go() -> None:
    """In a forked child: a lock belongs to who took it, and a worker that lives on must not keep it."""
    for file in _held:
        os.close(file)
    _held.clear()


os.register_at_fork(after_in_child=_let_go)


class RunLock:
    """Held from before the first file is touched until `release`; BadInputError where another process records into the
    folder.
    """

    def __init__(self, folder: Path) -> None:
        self._file = os.open(folder / LOCK_FILE, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            holder = os.pread(self._file, 20, 0).decode(errors="replace").strip()
            os.close(self._file)
            if not isinstance(error, BlockingIOError):
                raise
            raise BadInputError(
                str(folder),
                f"is being recorded into by process {holder or 'unknown'}",
                "another folder, or that run ended first",
            ) from None
        os.ftruncate(self._file, 0)
        os.pwrite(self._file, f"{os.getpid()}\n".encode(), 0)
        _held.add(self._file)

    def release(self) -> None:
        """Let others in; the empty lock file stays, because taking it away could take it from under somebody who
        waits.
        """
        if self._file >= 0:
            _held.discard(self._file)
            os.close(self._file)
            self._file = -1


@contextlib.contextmanager
def one_writer(folder: Path) -> Iterator[None]:
    """A folder that is there, for one process alone; BadInputError where another one writes into it."""
    lock = RunLock(folder)
    try:
        yield
    finally:
        lock.release()
