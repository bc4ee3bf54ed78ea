"""CAN frames of any kind (classic, FD, extended), through python-can or a Unix socket on this machine."""

from __future__ import annotations

import errno
import socket
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from firmware_protocol.errors import LinkError
from firmware_protocol.links import CanFrame, PythonCanBus, UnixListener, connected_to, unix_reason

_HEAD = struct.Struct("<IB")
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
    interface: str, channel: str | int, bitrate: int, data_bitrate: int | None, options: Mapping[str, Any]
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
        found: list[CanFrame] = []
        while self._has_peer() and self._peer is not None and len(found) < _MOST_FRAMES:
            try:
                packet = self._peer.recv(256)
            except BlockingIOError:
                break
            except OSError:
                packet = b""
            if not packet:
                self._gone()
                break
            if len(packet) >= _HEAD.size:
                identifier, kind = _HEAD.unpack_from(packet)
                data = packet[_HEAD.size :][:64]
                found.append(CanFrame(identifier, data, bool(kind & _EXTENDED), bool(kind & _FD)))
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
        return self._peer is not None

    def _gone(self) -> None:
        if self._peer is not None:
            self._peer.close()
            self._peer = None
        if self._listener is None:
            raise OSError(errno.EPIPE, "the other end was closed")
