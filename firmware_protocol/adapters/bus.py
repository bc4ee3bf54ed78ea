"""CAN frames of any kind (classic, FD, extended), through python-can or a Unix socket on this machine."""

from __future__ import annotations

import errno
import logging
import socket
import struct
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from firmware_protocol.errors import LinkError
from firmware_protocol.links import UnixListener, connected_to, unix_reason

_HEAD = struct.Struct("<IB")
_EXTENDED, _FD = 1, 2
_MOST_FRAMES = 1024
_GONE = {errno.ENODEV, errno.ENETDOWN, errno.ENXIO, errno.EIO, errno.EBADF, errno.EPIPE}


@dataclass(frozen=True)
class CanFrame:
    """One data frame; an FD frame may hold 64 bytes."""

    identifier: int
    data: bytes
    extended: bool = False
    fd: bool = False


class Bus(Protocol):
    """Frames out and in without waiting; OSError when the bus is gone."""

    def send(self, frame: CanFrame) -> bool:
        """Whether there was room for it."""

    def receive(self) -> list[CanFrame]:
        """Everything that has come."""

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


class PythonCanBus:
    """Any interface of python-can, read without its Notifier thread; FD where a data bit rate is given."""

    def __init__(
        self,
        interface: str,
        channel: str | int,
        bitrate: int,
        data_bitrate: int | None = None,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        import can

        logging.getLogger("can").setLevel(logging.ERROR)
        given: dict[str, Any] = {"bitrate": bitrate, **(options or {})}
        if data_bitrate is not None:
            given = {"fd": True, "data_bitrate": data_bitrate, **given}
        try:
            self._bus = can.Bus(channel=channel, interface=interface, ignore_config=True, **given)
        except Exception as error:  # every interface fails in its own way: missing driver, port, permission, option
            raise LinkError(
                f"link: {interface} {channel}: {error}; expected an interface and a channel that python-can can open"
            ) from error
        self._message, self._error = can.Message, can.CanError

    def send(self, frame: CanFrame) -> bool:
        message = self._message(
            arbitration_id=frame.identifier,
            data=frame.data,
            is_extended_id=frame.extended,
            is_fd=frame.fd,
            bitrate_switch=frame.fd,
        )
        try:
            self._bus.send(message, timeout=0)
        except (self._error, OSError, ValueError) as error:
            number = getattr(error, "error_code", None) or getattr(error, "errno", None)
            if number in _GONE:
                raise OSError(number, str(error)) from error
            return False
        return True

    def receive(self) -> list[CanFrame]:
        found = []
        for _ in range(_MOST_FRAMES):
            try:
                message = self._bus.recv(0.0)
            except self._error as error:
                raise OSError(errno.EIO, str(error)) from error
            if message is None:
                break
            if not (message.is_error_frame or message.is_remote_frame):
                data = bytes(message.data)
                found.append(CanFrame(message.arbitration_id, data, message.is_extended_id, message.is_fd))
        return found

    def fileno(self) -> int:
        with suppress(Exception):
            return int(self._bus.fileno())
        return -1

    def close(self) -> None:
        with suppress(Exception):
            self._bus.shutdown()


class UnixCanBus:
    """Frames over a Unix socket of the packet kind, one a packet: a simulated drive in another process of this machine.

    A listening end serves one peer after the other.
    """

    def __init__(self, path: Path, listen: bool = False) -> None:
        self._listener: UnixListener | None = None
        self._peer: socket.socket | None = None
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
        return found

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
