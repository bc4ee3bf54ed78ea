"""The host's side of slcan once python-can has opened the channel: blocks in bulk, and never a wait.

python-can asks its serial port for one byte at a time (two system calls each), lets `flush` wait for the line to drain,
does not get over a byte that is no text, and takes 20 us for a frame. So it opens the channel and closes it; between
the two, a block is written at once and what has come is read at once. Lines that are no frames are dropped.
"""

from __future__ import annotations

from firmware_protocol.links.descriptor import DescriptorPort
from firmware_protocol.links.slcan_text import LINE_END, lines_of, record_of

#: longer lines belong to no frame
_LINE_LIMIT = 64

#: the adapter's yes to a command, and to a frame
_ANSWERS = (b"", b"z", b"Z")


class SlcanPort:
    """Frames over an open channel, and what slcanBus uses of a pyserial port when it closes that."""

    write_timeout: float | None = None

    def __init__(self, port: DescriptorPort) -> None:
        self._port = port
        self._partial = b""
        self.malformed = 0

    def send(self, block: bytes) -> bool:
        """Hand a block over; False when the adapter has no room for it. Raises OSError when the adapter has gone."""
        return self._port.write(lines_of(block))

    def receive(self) -> bytes:
        """Frames that have come whole since the last call; raises OSError when the adapter has gone."""
        octets = self._port.read()
        if not octets:
            return b""
        *lines, self._partial = (self._partial + octets).split(LINE_END)
        if len(self._partial) > _LINE_LIMIT:
            self.malformed += 1
            self._partial = b""
        taken = []
        for line in lines:
            # a bell is the adapter's no, and no line end: it stands before the next line
            line = line.lstrip(b"\a")
            if line not in _ANSWERS:
                found = record_of(line)
                self.malformed += not found
                taken.append(found)
        return b"".join(taken)

    def write(self, octets: bytes) -> int:
        """Hand a command over."""
        self._port.write(octets)
        return len(octets)

    def flush(self) -> None:
        """Nothing to wait for: what was written is on its way or in the backlog."""

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
