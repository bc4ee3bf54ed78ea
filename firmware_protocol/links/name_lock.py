"""A lasting name (a symbolic link to a pseudo-terminal, a socket) belongs to the process that serves it, until that
process ends.
"""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from pathlib import Path

from firmware_protocol.errors import LinkError


class NameLock:
    """Held from the moment a name is taken until `release`; the system gives it back when the process dies. LinkError
    where it is held.
    """

    def __init__(self, name: Path) -> None:
        self._path = name.with_name(f".{name.name}.lock")
        self._file = -1
        while self._file < 0:
            self._file = self._locked(name)
        os.ftruncate(self._file, 0)
        os.pwrite(self._file, f"{os.getpid()}\n".encode(), 0)

    def release(self) -> None:
        """Let the name go."""
        if self._file >= 0:
            with suppress(OSError):
                self._path.unlink(missing_ok=True)
            os.close(self._file)
            self._file = -1

    def _locked(self, name: Path) -> int:
        """Descriptor of the locked file; -1 where its holder took it away meanwhile."""
        try:
            file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise LinkError(
                f"{name}: {error.strerror or error}; expected a path in a folder that can be written to"
            ) from error
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if self._path.exists() and os.path.samestat(os.fstat(file), os.stat(self._path)):
                return file
        except BlockingIOError:
            holder = os.pread(file, 20, 0).decode(errors="replace").strip() or "unknown"
            os.close(file)
            raise LinkError(
                f"{name}: busy: process {holder} serves under this name; expected another name, or that one ended"
            ) from None
        except FileNotFoundError:
            pass
        os.close(file)
        return -1
