"""CAN frames of any kind (classic, FD, extended), through python-can or a Unix socket on this machine."""

from __future__ import annotations

import errno
import socket
import struct
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

from firmware_protocol.errors import LinkError
from firmware_protocol.links import CanFrame, PythonCanBus, UnixListener, connected_to, unix_reason

_HEAD = struct.Struct("<IB")
#: Linux's option that tells when each packet was sent, and what comes beside the packet then: wall clock, s and ns
_SO_TIMESTAMPNS, _STAMP = 35, struct.Struct("@ll")
_BESIDE = socket.CMSG_SPACE(_STAMP.size)
_EXTENDED, _FD = 1, 2
_MOST_FRAMES = 1024


class Bus(Protocol):
    """Frames out and in without waiting; OSError when the bus is gone."""

    def send(self, frame: CanFrame) -> bool:
        """Whether there was room for it."""

    def receive(self) -> list[CanFrame]:
        """Everything that has come."""

    def take_malformed(self) -> int:
        """What came since the last call and was no data frame."""

    def fileno(self) -> int:
        """Descriptor that becomes readable, -1 where there is none."""

    def close(self) -> None:
        """Leave the bus."""


def open_bus(
    interface: str, channel: str | int, bitrate: int, data_bitrate: int | None, options: Mapping[str, object]
) -> Bus:
    """python-can's interface of that name, or `unix` with a path; LinkError when it cannot be opened."""
    if interface == "unix":
        return UnixCanBus(Path(str(channel)))
    return PythonCanBus(interface, channel, bitrate, data_bitrate, options)


class UnixCanBus:
    """Frames over a Unix socket of the packet kind, one a packet: a simulated drive in another process of this machine.

    A listening end serves one peer after the other.
    """

    def __init__(self, path: Path, listen: bool = False) -> None:
        self._listener: UnixListener | None = None
        self._peer: socket.socket | None = None
        self._malformed = 0
        try:
            if listen:
                self._listener = UnixListener(path)
            else:
                self._peer = connected_to(path)
        except OSError as error:
            raise LinkError(
                f"link.channel: {path}: {unix_reason(error)}; expected a socket of simulated drives"
            ) from error

    def send(self, frame: CanFrame) -> bool:
        if not self._has_peer() or self._peer is None:
            return False
        kind = _EXTENDED * frame.extended | _FD * frame.fd
        try:
            self._peer.send(_HEAD.pack(frame.identifier, kind) + frame.data)
        except BlockingIOError:
            return False
        except OSError:
            self._gone()
            return False
        return True

    def receive(self) -> list[CanFrame]:
        return [frame for _, frame in self.arrivals()]

    def arrivals(self) -> list[tuple[int, CanFrame]]:
        """Everything that has come, with the time on the monotonic clock at which the peer sent it, ns; where only the
        peer listens, the time of this look.
        """
        found: list[tuple[int, CanFrame]] = []
        now_ns = time.monotonic_ns()
        from_wall_clock_ns = now_ns - time.time_ns()
        while self._has_peer() and self._peer is not None and len(found) < _MOST_FRAMES:
            try:
                packet, beside, _, _ = self._peer.recvmsg(256, _BESIDE)
            except BlockingIOError:
                break
            except OSError:
                packet, beside = b"", []
            if not packet:
                self._gone()
                break
            if len(packet) >= _HEAD.size:
                identifier, kind = _HEAD.unpack_from(packet)
                data = packet[_HEAD.size :][:64]
                sent_ns = now_ns
                for _, _, stamp in beside:
                    seconds, rest_ns = _STAMP.unpack(stamp)
                    sent_ns = min(now_ns, seconds * 1_000_000_000 + rest_ns + from_wall_clock_ns)
                found.append((sent_ns, CanFrame(identifier, data, bool(kind & _EXTENDED), bool(kind & _FD))))
            else:
                self._malformed += 1
        return found

    def take_malformed(self) -> int:
        malformed, self._malformed = self._malformed, 0
        return malformed

    def fileno(self) -> int:
        end = self._peer or self._listener
        return -1 if end is None else end.fileno()

    def close(self) -> None:
        for end in (self._peer, self._listener):
            if end is not None:
                end.close()
        self._peer = self._listener = None

    def _has_peer(self) -> bool:
        if self._peer is None and self._listener is not None:
            self._peer = self._listener.accept()
            if self._peer is not None:
                self._peer.setsockopt(socket.SOL_SOCKET, _SO_TIMESTAMPNS, 1)
        return self._peer is not None

    def _gone(self) -> None:
        if self._peer is not None:
            self._peer.close()
            self._peer = None
        if self._listener is None:
            raise OSError(errno.EPIPE, "the other end was closed")
