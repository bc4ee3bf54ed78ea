"""A port for python-can's slcan host that reads in bulk and never waits.

python-can asks its serial port for one byte at a time (two system calls each), lets `flush` wait for the line to drain, and does not
get over a byte that is no text. This port stands in for the serial port once the bus is open: whole lines only, frames only, from one
bulk read.
"""

from __future__ import annotations

import re

from firmware_protocol.links.descriptor import DescriptorPort

#: longer lines belong to no frame
_LINE_LIMIT = 64

#: a standard data frame of eight bytes, with or without a time stamp; python-can fails on lines that only begin like one
_FRAME = re.compile(rb"t[0-7][0-9A-Fa-f]{2}8[0-9A-Fa-f]{16}(?:[0-9A-Fa-f]{4})?")

#: the adapter's yes to a frame
_ANSWERS = (b"z", b"Z")


class SlcanPort:
    """What slcanBus uses of a pyserial port."""

    write_timeout: float | None = None

    def __init__(self, port: DescriptorPort) -> None:
        self._port = port
        self._partial = b""
        self._ready = b""
        self._at = 0
        self.malformed = 0
        self.dropped = 0

    @property
    def in_waiting(self) -> int:
        """Bytes of whole frame lines that can be read; raises OSError when the adapter has gone."""
        if self._at >= len(self._ready):
            self._fill()
        return len(self._ready) - self._at

    def read(self, size: int = 1) -> bytes:
        """Up to `size` of those bytes."""
        octets = self._ready[self._at : self._at + size]
        self._at += len(octets)
        return octets

    def write(self, octets: bytes) -> int:
        """Hand a line over; one that the adapter has no room for is counted and dropped."""
        if not self._port.write(octets):
            self.dropped += 1
        return len(octets)

    def flush(self) -> None:
        """Nothing to wait for: what was written is on its way or in the backlog."""

    def reset_input_buffer(self) -> None:
        """Forget what was read."""
        self._partial = self._ready = b""

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
        self._ready, self._at = b"", 0
        octets = self._port.read()
        if not octets:
            return
        *lines, self._partial = (self._partial + octets).split(b"\r")
        if len(self._partial) > _LINE_LIMIT:
            self.malformed += 1
            self._partial = b""
        # a bell is the adapter's no, and no line end: it stands before the next line
        whole = [line.lstrip(b"\a") for line in lines]
        frames = [line for line in whole if _FRAME.fullmatch(line)]
        self.malformed += sum(1 for line in whole if line and line not in _ANSWERS) - len(frames)
        self._ready = b"".join(line + b"\r" for line in frames)
