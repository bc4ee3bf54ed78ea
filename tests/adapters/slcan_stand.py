"""The adapter's side of slcan on a pseudo-terminal, frames of any kind: what CANable and its relatives do."""

from __future__ import annotations

import os
import tty
from dataclasses import dataclass, field

from firmware_protocol.adapters import CanFrame

_FD_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)


def line_of(frame: CanFrame) -> bytes:
    """As the protocol writes it, CANable's letters for FD."""
    letter = ("b" if frame.fd else "t").upper() if frame.extended else ("b" if frame.fd else "t")
    width = 8 if frame.extended else 3
    return f"{letter}{frame.identifier:0{width}X}{_FD_LENGTHS.index(len(frame.data)):X}{frame.data.hex()}\r".encode()


@dataclass
class SlcanStand:
    """A bus whose host is behind a pseudo-terminal; `acknowledges` each frame as most adapters do, `noise` precedes
    every line of its own.
    """

    acknowledges: bool = True
    noise: bytes = b""
    heard: list[bytes] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs)
        os.set_blocking(self._ours, False)
        self.path, self._partial = os.ttyname(self._theirs), b""

    def send(self, frame: CanFrame) -> bool:
        self.say(self.noise + line_of(frame))
        return True

    def say(self, octets: bytes) -> None:
        """Octets for the host as they are."""
        os.write(self._ours, octets)

    def receive(self) -> list[CanFrame]:
        """Frames that the host sent, each acknowledged; everything stands in `heard` too."""
        try:
            octets = os.read(self._ours, 65536)
        except BlockingIOError:
            return []
        *lines, self._partial = (self._partial + octets).split(b"\r")
        self.heard += lines
        return [frame for frame in map(self._taken, lines) if frame is not None]

    def fileno(self) -> int:
        return self._ours

    def close(self) -> None:
        """Pull the cable."""
        for descriptor in (self._ours, self._theirs):
            os.close(descriptor)

    def _taken(self, line: bytes) -> CanFrame | None:
        letter = line[:1].decode()
        if letter not in "tTbB" or not letter:
            self.say(b"\r" if letter in "COSYZM" else b"\a")
            return None
        extended, fd = letter.isupper(), letter in "bB"
        at = 9 if extended else 4
        if self.acknowledges:
            self.say(b"Z\r" if extended else b"z\r")
        data = bytes.fromhex(line[at + 1 :].decode())
        assert len(data) == _FD_LENGTHS[int(line[at : at + 1], 16)]
        return CanFrame(int(line[1:at], 16), data, extended, fd)
