"""A port for python-can's slcan host that reads in bulk and never waits.

python-can asks its serial port for one byte at a time (two system calls each), lets `flush` wait for the line to drain,
and does not get over a byte that is no text. This port stands in for the serial port once the bus is open. It reads in
bulk, lets whole frame lines through and nothing else, and answers a request for a byte with a whole line, and the next
one with the line's end: all that python-can does with the bytes of a line is to join them.
"""

from __future__ import annotations

from collections import deque

from firmware_protocol.links.descriptor import DescriptorPort
from firmware_protocol.links.slcan_device import FRAME_LINE

#: longer lines belong to no frame
_LINE_LIMIT = 64

#: the adapter's yes to a frame
_ANSWERS = (b"z", b"Z")


class SlcanPort:
    """What slcanBus uses of a pyserial port."""

    write_timeout: float | None = None

    def __init__(self, port: DescriptorPort) -> None:
        self._port = port
        self._partial = b""
        self._ready: deque[bytes] = deque()
        self.malformed = 0
        self.dropped = 0

    @property
    def in_waiting(self) -> int:
        """Requests that can be answered; raises OSError when the adapter has gone."""
        if not self._ready:
            self._fill()
        return len(self._ready)

    def read(self, size: int = 1) -> bytes:
        """The next line or line end."""
        return self._ready.popleft() if self._ready else b""

    def write(self, octets: bytes) -> int:
        """Hand a line over; one that the adapter has no room for is counted and dropped."""
        if not self._port.write(octets):
            self.dropped += 1
        return len(octets)

    def flush(self) -> None:
        """Nothing to wait for: what was written is on its way or in the backlog."""

    def reset_input_buffer(self) -> None:
        """Forget what was read."""
        self._partial = b""
        self._ready.clear()

    def fileno(self) -> int:
        """Descriptor of the port."""
        return self._port.descriptor

    def close(self) -> None:
        """Give the port back."""
        self._port.close()

    def take_malformed(self) -> int:
        """Lines that were dropped since the last call."""
        malformed, self.malformed = self.malformed, 0
        return malformed

    def _fill(self) -> None:
        octets = self._port.read()
        if not octets:
            return
        *lines, self._partial = (self._partial + octets).split(b"\r")
        if len(self._partial) > _LINE_LIMIT:
            self.malformed += 1
            self._partial = b""
        # a bell is the adapter's no, and no line end: it stands before the next line
        whole = [line.lstrip(b"\a") for line in lines]
        # python-can fails on lines that only begin like a frame
        frames = [line for line in whole if FRAME_LINE.fullmatch(line)]
        self.malformed += sum(1 for line in whole if line and line not in _ANSWERS) - len(frames)
        for line in frames:
            self._ready += (line, b"\r")
