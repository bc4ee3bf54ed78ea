"""Unix sockets of the packet kind (SOCK_SEQPACKET): who listens keeps the path to itself, who connects never waits."""

from __future__ import annotations

import errno
import socket
from contextlib import ExitStack, suppress
from pathlib import Path

from firmware_protocol.links.name_lock import NameLock


class UnixListener:
    """Listens at `path` and hands out one peer at a time. OSError when the path cannot be had, LinkError when another
    process serves under it.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._lock = path, NameLock(path)
        with ExitStack() as undone:
            undone.callback(self._lock.release)
            self._end = undone.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET))
            if path.is_socket() and not _is_served(path):
                path.unlink()
            self._end.bind(str(path))
            undone.callback(path.unlink, missing_ok=True)
            path.chmod(0o600)
            self._end.listen(1)
            self._end.setblocking(False)
            undone.pop_all()

    def accept(self) -> socket.socket | None:
        """The peer that has come, if any; it never blocks."""
        with suppress(OSError):
            peer = self._end.accept()[0]
            peer.setblocking(False)
            return peer
        return None

    def fileno(self) -> int:
        """Descriptor, readable when a peer has come."""
        return self._end.fileno()

    def close(self) -> None:
        """Take the path away."""
        self._end.close()
        with suppress(OSError):
            self._path.unlink()
        self._lock.release()


def connected_to(path: Path) -> socket.socket:
    """A socket that never blocks, connected to who listens there; OSError, at once, where nobody has room for it."""
    end = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    end.setblocking(False)
    try:
        end.connect(str(path))
    except OSError:
        end.close()
        raise
    return end


def unix_reason(error: OSError) -> str:
    """Why a socket cannot be had, in few words."""
    if error.errno == errno.ENOENT:
        return "no such socket"
    if error.errno == errno.ECONNREFUSED:
        return "nobody listens there"
    if error.errno == errno.EADDRINUSE:
        return "busy: the path is taken"
    if error.errno == errno.EAGAIN:
        return "busy: another process is connected, and one more waits"
    return error.strerror or str(error)


def _is_served(path: Path) -> bool:
    try:
        connected_to(path).close()
    except OSError as error:
        return error.errno != errno.ECONNREFUSED
    return True
