"""Opens what a serial configuration names: a device or pseudo-terminal through pyserial, or a TCP socket."""

from __future__ import annotations

import socket
from contextlib import suppress
from urllib.parse import urlsplit

from firmware_protocol.errors import LinkError
from firmware_protocol.links.claims import PortClaim, reason_of
from firmware_protocol.links.descriptor import DescriptorPort

SOCKET_SCHEME = "socket://"

_EXPECTED = "expected a device path, a pseudo-terminal or socket://host:port"

#: how long a connection may take to be accepted
_CONNECT_TIMEOUT_S = 1.0

_SOCKET_BUFFER = 8192


def open_serial(port: str, baudrate: int) -> DescriptorPort:
    """Open a port for bulk non-blocking use; LinkError when it is missing, busy or refused."""
    return _open_socket(port) if port.startswith(SOCKET_SCHEME) else _open_terminal(port, baudrate)


def _open_terminal(port: str, baudrate: int) -> DescriptorPort:
    import serial

    claim: PortClaim | None = None
    try:
        claim = PortClaim(port)
        terminal = serial.Serial(port, baudrate, timeout=0)
    except (serial.SerialException, OSError, ValueError) as error:
        if claim is not None:
            claim.release()
        raise LinkError(f"link.port: {port}: {reason_of(error)}; {_EXPECTED}") from error
    # adapters with an FTDI chip hold bytes back for 16 ms unless told otherwise; others do not know the request
    with suppress(OSError, ValueError, RuntimeError, AttributeError):
        terminal.set_low_latency_mode(True)
    claim.exclude(terminal.fileno())

    def release() -> None:
        claim.give_back()
        terminal.close()
        claim.release()

    return DescriptorPort(terminal.fileno(), release)


def _open_socket(url: str) -> DescriptorPort:
    """A TCP connection. Not through pyserial, which leaves small packets to wait for one another and sleeps when it
    closes.
    """
    try:
        parts = urlsplit(url)
        if not parts.hostname or not parts.port:
            raise ValueError("host or port number missing")
        connection = socket.create_connection((parts.hostname, parts.port), timeout=_CONNECT_TIMEOUT_S)
    except (OSError, ValueError) as error:
        raise LinkError(f"link.port: {url}: {reason_of(error)}; {_EXPECTED}") from error
    # a peer that stalls must cost frames, not leave a second of old ones in the queue
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SOCKET_BUFFER)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return DescriptorPort(connection.fileno(), connection.close)
