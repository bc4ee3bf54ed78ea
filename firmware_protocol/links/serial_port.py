"""Opens what a serial configuration names: a device or pseudo-terminal through pyserial, or a TCP socket."""

from __future__ import annotations

import errno
import fcntl
import os
import socket
import termios
from contextlib import suppress
from urllib.parse import urlsplit

from firmware_protocol.errors import LinkError
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

    try:
        terminal = serial.Serial(port, baudrate, timeout=0, exclusive=True)
    except (serial.SerialException, OSError, ValueError) as error:
        raise LinkError(f"link.port: {port}: {_reason(error)}; {_EXPECTED}") from error
    # adapters with an FTDI chip hold bytes back for 16 ms unless told otherwise; others do not know the request
    with suppress(OSError, ValueError, RuntimeError, AttributeError):
        terminal.set_low_latency_mode(True)
    claimed = _claim(terminal.fileno(), port)

    def release() -> None:
        if claimed:
            with suppress(OSError):
                fcntl.ioctl(terminal.fileno(), termios.TIOCNXCL)
        terminal.close()

    return DescriptorPort(terminal.fileno(), release)


def _claim(descriptor: int, port: str) -> bool:
    """Keep other programs from opening the port, beside pyserial's advisory lock that only those see who ask for it.

    Not a pseudo-terminal: its other end keeps it open, and the claim of a host that was killed would outlive it.
    """
    if os.path.realpath(port).startswith("/dev/pts/"):
        return False
    with suppress(OSError):
        fcntl.ioctl(descriptor, termios.TIOCEXCL)
        return True
    return False


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
        raise LinkError(f"link.port: {url}: {_reason(error)}; {_EXPECTED}") from error
    # a peer that stalls must cost frames, not leave a second of old ones in the queue
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SOCKET_BUFFER)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return DescriptorPort(connection.fileno(), connection.close)


def _reason(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == errno.ENOENT:
        return "no such port"
    if number in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in str(error):
        return "busy: another program has this port"
    if number in (errno.EACCES, errno.EPERM):
        return "no permission to open it (on Linux: join the group dialout)"
    if number == errno.ECONNREFUSED:
        return "connection refused: nobody listens there"
    return str(error) or type(error).__name__
