"""A link over a Unix socket of the packet kind (SOCK_SEQPACKET): one packet is one block, no framing needed, nothing
leaves the machine.
"""

from __future__ import annotations

import errno
import select
import socket
from contextlib import suppress
from pathlib import Path

from firmware_protocol.errors import LinkError
from firmware_protocol.links.descriptor import wait_readable
from firmware_protocol.links.link import LinkBasis, LinkState
from firmware_protocol.links.name_lock import NameLock
from firmware_protocol.schema import RECORD_SIZE

#: longest packet; a longer block goes out in parts
_PACKET_LIMIT = 3200 * RECORD_SIZE

_PACKETS = 4096

#: how long connecting may take when the listener's queue is full
_CONNECT_TIMEOUT_S = 1.0


class UnixLink(LinkBasis):
    """One end of a socket at `path`; the listening end serves one peer after the other. LinkError when it cannot be
    opened.
    """

    def __init__(self, path: Path, listen: bool = False) -> None:
        super().__init__(f"unix {path}")
        self._path, self._listen = path, listen
        self._listener: socket.socket | None = None
        self._lock: NameLock | None = None
        self._peer: socket.socket | None = None
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
            with suppress(OSError):
                self._path.unlink()
        if self._lock is not None:
            self._lock.release()
            self._lock = None
        self._state = LinkState.CLOSED

    def fileno(self) -> int:
        """Descriptor of the peer, else of the listener, else -1."""
        current = self._peer or self._listener
        return -1 if current is None else current.fileno()

    def _connect(self) -> None:
        if self._listener is not None:
            self._accept()
            return
        end = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            if self._listen:
                self._bind(end)
            else:
                end.settimeout(_CONNECT_TIMEOUT_S)
                end.connect(str(self._path))
        except OSError as error:
            end.close()
            raise LinkError(
                f"link.path: {self._path}: {_reason(error)}; expected a Unix socket that a peer listens on"
            ) from error
        if self._listen:
            end.setblocking(False)
            self._listener = end
            self._state = LinkState.WAITING
        else:
            self._take_peer(end)

    def _bind(self, end: socket.socket) -> None:
        self._lock = NameLock(self._path)
        try:
            if self._path.is_socket() and not _is_served(self._path):
                self._path.unlink()
            end.bind(str(self._path))
        except OSError:
            self._lock.release()
            raise
        self._path.chmod(0o600)
        end.listen(1)

    def _accept(self) -> bool:
        if self._listener is None:
            return False
        with suppress(OSError):
            self._take_peer(self._listener.accept()[0])
            return True
        return False

    def _take_peer(self, peer: socket.socket) -> None:
        peer.setblocking(False)
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


def _is_served(path: Path) -> bool:
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as probe:
        try:
            probe.settimeout(_CONNECT_TIMEOUT_S)
            probe.connect(str(path))
        except OSError as error:
            return error.errno != errno.ECONNREFUSED
    return True


def _reason(error: OSError) -> str:
    if error.errno == errno.ENOENT:
        return "no such socket"
    if error.errno == errno.ECONNREFUSED:
        return "nobody listens there"
    if error.errno == errno.EADDRINUSE:
        return "busy: the path is taken"
    return error.strerror or str(error)
