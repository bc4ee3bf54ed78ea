"""A link over a Unix socket of the packet kind (SOCK_SEQPACKET): one packet is one block, no framing needed, nothing
leaves the machine.
"""

from __future__ import annotations

import select
import socket
from pathlib import Path

from firmware_protocol.errors import LinkError
from firmware_protocol.links.claims import BusClaim
from firmware_protocol.links.descriptor import wait_readable
from firmware_protocol.links.link import LinkBasis, LinkState
from firmware_protocol.links.unix_socket import UnixListener, connected_to, unix_reason
from firmware_protocol.schema import RECORD_SIZE

#: longest packet; a longer block goes out in parts
_PACKET_LIMIT = 3200 * RECORD_SIZE

_PACKETS = 4096


class UnixLink(LinkBasis):
    """One end of a socket at `path`; the listening end serves one peer after the other. LinkError when it cannot be
    opened.
    """

    def __init__(self, path: Path, listen: bool = False) -> None:
        super().__init__(f"unix {path}")
        self._path, self._listen = path, listen
        self._listener: UnixListener | None = None
        self._peer: socket.socket | None = None
        self._claim: BusClaim | None = None
        self._poll = select.poll()
        self._connect()

    def send(self, block: bytes) -> None:
        """Send whole records; dropped and counted without a peer or when its buffer is full."""
        for at in range(0, len(block), _PACKET_LIMIT):
            part = block[at : at + _PACKET_LIMIT]
            self._count_sent(part, self._send_packet(part))

    def receive(self) -> bytes:
        """Blocks that have come since the last call, joined."""
        if self._peer is None and not self._accept():
            return b""
        packets: list[bytes] = []
        while self._peer is not None and len(packets) < _PACKETS:
            try:
                packet = self._peer.recv(_PACKET_LIMIT)
            except BlockingIOError:
                break
            except OSError as error:
                self._lose(error.strerror or error)
                break
            if not packet:
                self._lose("the other end was closed")
            elif len(packet) % RECORD_SIZE:
                self._statistics.malformed += 1
            else:
                packets.append(packet)
                # asking costs a quarter of an exception that says there is nothing more
                if not self._poll.poll(0):
                    break
        return self._count_received(b"".join(packets))

    def wait(self, timeout_ns: int) -> bool:
        """Sleep until a block, or a peer, has come, at most that long."""
        descriptor = self.fileno()
        return descriptor >= 0 and wait_readable(descriptor, timeout_ns)

    def close(self) -> None:
        """Close both sockets; the listening end takes its path away."""
        self._drop_peer()
        if self._listener is not None:
            self._listener.close()
            self._listener = None
        self._state = LinkState.CLOSED

    def fileno(self) -> int:
        """Descriptor of the peer, else of the listener, else -1."""
        current = self._peer or self._listener
        return -1 if current is None else current.fileno()

    def _connect(self) -> None:
        if self._listener is not None:
            self._accept()
            return
        try:
            if self._listen:
                self._listener = UnixListener(self._path)
                self._state = LinkState.WAITING
            else:
                self._claim = BusClaim.of_socket(self.name, self._path)
                self._take_peer(connected_to(self._path))
        except OSError as error:
            self._give_back()
            raise LinkError(
                f"link.path: {self._path}: {unix_reason(error)}; expected a Unix socket that a peer listens on"
            ) from error

    def _accept(self) -> bool:
        peer = self._listener.accept() if self._listener is not None else None
        if peer is not None:
            self._take_peer(peer)
        return peer is not None

    def _take_peer(self, peer: socket.socket) -> None:
        self._peer, self._poll = peer, select.poll()
        self._poll.register(peer, select.POLLIN)
        self._opened()

    def _send_packet(self, part: bytes) -> bool:
        if self._peer is None:
            self._accept()
        try:
            return self._peer is not None and self._peer.send(part) == len(part)
        except BlockingIOError:
            return False
        except OSError as error:
            self._lose(error.strerror or error)
            return False

    def _lose(self, reason: object) -> None:
        self._drop_peer()
        self._lost(reason, LinkState.LOST if self._listener is None else LinkState.WAITING)

    def _drop_peer(self) -> None:
        if self._peer is not None:
            self._peer.close()
            self._peer = None
        self._give_back()

    def _give_back(self) -> None:
        if self._claim is not None:
            self._claim.release()
            self._claim = None
