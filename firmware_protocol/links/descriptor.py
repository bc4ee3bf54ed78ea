"""Bulk reads and writes on a file descriptor that never wait: terminals, pseudo-terminals and stream sockets alike."""

from __future__ import annotations

import os
import select
from collections.abc import Callable

#: most bytes of one read, and reads of one call: what a peer can have queued during a long stall
_READ_SIZE, _READS = 65536, 16

_GONE = select.POLLHUP | select.POLLERR | select.POLLNVAL


def wait_readable(descriptor: int, timeout_ns: int) -> bool:
    """Sleep until the descriptor can be read, at most that long."""
    try:
        return bool(select.select([descriptor], [], [], max(0, timeout_ns) * 1e-9)[0])
    except (OSError, ValueError):
        return False


class DescriptorPort:
    """A descriptor and what one write left over. A peer that has gone raises an OSError, which the link turns into its
    state.
    """

    def __init__(self, descriptor: int, release: Callable[[], object]) -> None:
        os.set_blocking(descriptor, False)
        self.descriptor = descriptor
        self._release = release
        self._backlog = b""
        self._poll = select.poll()
        self._poll.register(descriptor, select.POLLIN)

    def read(self) -> bytes:
        """All bytes that are there, or none."""
        pieces: list[bytes] = []
        for _ in range(_READS):
            events = self._poll.poll(0)
            if not events:
                break
            piece = os.read(self.descriptor, _READ_SIZE) if events[0][1] & select.POLLIN else b""
            if not piece:
                if pieces:
                    break
                raise ConnectionResetError(
                    "the other end was closed" if events[0][1] & (_GONE | select.POLLIN) else "no data"
                )
            pieces.append(piece)
        return b"".join(pieces)

    def write(self, octets: bytes) -> bool:
        """Hand all bytes over, or keep what did not fit for the next call; False when older bytes are still waiting:
        these are dropped.

        Only the rest of one call is ever kept, so that packets stay whole and a peer that comes back does not find old
        ones.
        """
        if self._backlog:
            self._backlog = self._push(self._backlog)
            if self._backlog:
                return False
        self._backlog = self._push(octets)
        return True

    def close(self) -> None:
        """Give the descriptor back."""
        self._release()

    def _push(self, octets: bytes) -> bytes:
        try:
            return octets[os.write(self.descriptor, octets) :]
        except BlockingIOError:
            return octets
