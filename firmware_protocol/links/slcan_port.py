"""The host's side of slcan once python-can has opened the channel: lines in bulk, and never a wait.

python-can asks its serial port for one byte at a time (two system calls each), answers an acknowledgement as if nothing
had come, lets `flush` wait for the line to drain, does not get over a byte that is no text, and takes 20 us for a
frame. So it opens the channel and closes it; between the two, lines are written at once and what has come is read at
once.
"""

from __future__ import annotations

from firmware_protocol.links.descriptor import DescriptorPort
from firmware_protocol.links.slcan_text import LINE_END

#: longer lines belong to no frame: an FD frame with extended identifier, 64 bytes and a time stamp
_LINE_LIMIT = 160

#: the adapter's yes to a command, and to a frame
_ANSWERS = (b"", b"z", b"Z")
_NO = b"\a"


class SlcanPort:
    """Lines of an open channel, and what slcanBus uses of a pyserial port when it closes that."""

    write_timeout: float | None = None

    def __init__(self, port: DescriptorPort) -> None:
        self._port = port
        self._partial = b""
        #: lines that were no frames, for whoever reads them to add to and to take
        self.malformed = 0
        #: how often the adapter said no: its queue was full, or its bus refuses frames
        self.refused = 0

    def send(self, lines: bytes) -> bool:
        """Hand whole lines over; False when the adapter has no room for them. Raises OSError when it has gone."""
        return self._port.write(lines)

    def receive(self) -> list[bytes]:
        """Whole lines that have come since the last call, without their ends and without what only acknowledges;
        OSError when the adapter has gone.
        """
        octets = self._port.read()
        if not octets:
            return []
        self.refused += octets.count(_NO)
        *lines, self._partial = (self._partial + octets).split(LINE_END)
        if len(self._partial) > _LINE_LIMIT:
            self.malformed += 1
            self._partial = b""
        # a bell is the adapter's no, and no line end: it stands before the next line
        return [line for line in (line.lstrip(_NO) for line in lines) if line not in _ANSWERS]

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
