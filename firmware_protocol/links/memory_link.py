"""A link inside one process: two ends, two queues."""

from __future__ import annotations

from collections import deque

from firmware_protocol.errors import LinkError
from firmware_protocol.links.link import BLOCK_LIMIT, LinkBasis, LinkState


class MemoryLink(LinkBasis):
    """One end; the other is `peer`. What the peer does not fetch is kept up to a bound, then dropped and counted."""

    peer: MemoryLink

    def __init__(self, name: str = "memory") -> None:
        super().__init__(name)
        self._inbox: deque[bytes] = deque()
        self._waiting = 0
        self._opened()

    def send(self, block: bytes) -> None:
        """Put a block into the peer's inbox."""
        if not block:
            return
        fits = (
            self.state is LinkState.OPEN
            and self.peer.state is LinkState.OPEN
            and self.peer._waiting + len(block) <= BLOCK_LIMIT
        )
        if fits:
            self.peer._inbox.append(block)
            self.peer._waiting += len(block)
        elif self.state is LinkState.OPEN and self.peer.state is LinkState.CLOSED:
            self._lost("the other end was closed")
        self._count_sent(block, fits)

    def receive(self) -> bytes:
        """All blocks in the inbox, joined."""
        if not self._inbox:
            if self.state is LinkState.OPEN and self.peer.state is LinkState.CLOSED:
                self._lost("the other end was closed")
            return b""
        block = b"".join(self._inbox)
        self._inbox.clear()
        self._waiting = 0
        return self._count_received(block)

    def wait(self, timeout_ns: int) -> bool:
        """Whether something is there; answers at once, since both ends live in the thread that asks."""
        return bool(self._inbox)

    def close(self) -> None:
        """Leave; what was not fetched is gone."""
        self._inbox.clear()
        self._waiting = 0
        self._state = LinkState.CLOSED

    def fileno(self) -> int:
        """There is none."""
        return -1

    def _connect(self) -> None:
        if self.peer.state is LinkState.CLOSED:
            raise LinkError("the other end was closed")
        self._opened()


def memory_pair(name: str = "memory") -> tuple[MemoryLink, MemoryLink]:
    """Two ends of one link."""
    near, far = MemoryLink(name), MemoryLink(f"{name} (far end)")
    near.peer, far.peer = far, near
    return near, far
