"""The adapter's side of slcan, the text protocol of Lawicel CAN232 and its many relatives; hosts speak the other side.

A line ends in a carriage return. Host to adapter: `S0`..`S8` bit rate, `O` open, `L` open listening, `C` close,
`tiiil<data>` a frame, `V`, `v`, `N`, `F` questions. Adapter to host: `tiiil<data>` a frame, a carriage return for yes
(`z` before it for a frame), a bell for no.
"""

from __future__ import annotations

from firmware_protocol.links.slcan_text import LINE_END, lines_of, record_of

_YES, _NO = b"\r", b"\a"

#: longest line of the protocol: an extended frame with eight bytes and a time stamp
_LINE_LIMIT = 32

_QUESTIONS = {b"V": b"V1013\r", b"v": b"v1013\r", b"N": b"NGHIL\r", b"F": b"F00\r"}


class SlcanDevice:
    """Framing of a pseudo-terminal that an slcan host opens. Frames pass only while the host has the channel open."""

    greeting = b""

    def __init__(self) -> None:
        self.is_open = False
        self.malformed = 0
        self._partial = b""
        self._answer = bytearray()

    def encode(self, block: bytes) -> bytes:
        """Lines for the host; none while the channel is closed."""
        return lines_of(block) if self.is_open else b""

    def feed(self, octets: bytes) -> bytes:
        """Frames that the host sent; commands are carried out and answered."""
        *lines, partial = (self._partial + octets).split(LINE_END)
        if len(partial) > _LINE_LIMIT:
            self.malformed += 1
            partial = b""
        self._partial = partial
        return b"".join(map(self._obey, lines))

    def answer(self) -> bytes:
        """What the host is to hear about its lines since the last call."""
        answer = bytes(self._answer)
        self._answer.clear()
        return answer

    def reset(self) -> None:
        """As after power-on."""
        self.is_open, self._partial = False, b""
        self._answer.clear()

    def _obey(self, line: bytes) -> bytes:
        command = line[:1]
        if command == b"t":
            return self._frame(line)
        if command in (b"O", b"L") and not self.is_open:
            self.is_open = True
            self._answer += _YES
        elif command == b"C":
            self.is_open = False
            self._answer += _YES
        elif command in (b"", b"S", b"s", b"Z", b"M", b"m", b"X", b"Y"):
            self._answer += _YES
        elif command in _QUESTIONS:
            self._answer += _QUESTIONS[command]
        else:
            self._answer += _NO
        return b""

    def _frame(self, line: bytes) -> bytes:
        found = record_of(line) if self.is_open else b""
        self.malformed += not found
        self._answer += b"z\r" if found else _NO
        return found
