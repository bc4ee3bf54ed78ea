"""Serial framing without any input or output of its own: blocks to packets, and bytes in any pieces back to blocks.

Packet: COBS(block, CRC-16 of the block, most significant byte first), 0x00. COBS (Cheshire and Baker, IEEE/ACM
Transactions on Networking 7, 1999) leaves no zero inside a packet, so a receiver that lost its place is right again
after the next zero. The CRC is CRC-16/CCITT-FALSE (polynomial 0x1021, start 0xFFFF), which the standard library
computes as `binascii.crc_hqx`.
"""

from __future__ import annotations

from binascii import crc_hqx
from dataclasses import dataclass

from cobs import cobs

from firmware_protocol.schema import RECORD_SIZE

#: most frames in one packet; a longer block goes out as several packets
PACKET_FRAMES = 48

_PACKET_BLOCK = PACKET_FRAMES * RECORD_SIZE
_CRC_SIZE = 2
_LONGEST_RUN = 254

#: longest packet without its delimiter: one byte of COBS per 254, and one
PACKET_LIMIT = _PACKET_BLOCK + _CRC_SIZE + (_PACKET_BLOCK + _CRC_SIZE) // _LONGEST_RUN + 1

DELIMITER = b"\0"


def encode_packets(block: bytes) -> bytes:
    """A block of whole records as packets with their delimiters."""
    if len(block) <= _PACKET_BLOCK:
        return _packet(block)
    return b"".join(_packet(block[at : at + _PACKET_BLOCK]) for at in range(0, len(block), _PACKET_BLOCK))


def _packet(block: bytes) -> bytes:
    return cobs.encode(block + crc_hqx(block, 0xFFFF).to_bytes(_CRC_SIZE, "big")) + DELIMITER


@dataclass
class StreamCounts:
    """What a parser has seen."""

    packets: int = 0
    bad_coding: int = 0
    bad_crc: int = 0
    bad_length: int = 0
    too_long: int = 0

    @property
    def bad(self) -> int:
        """All packets that were dropped."""
        return self.bad_coding + self.bad_crc + self.bad_length + self.too_long


class StreamParser:
    """Collects bytes until a delimiter and lets good packets through. Never raises on what it is fed, never holds more
    than one packet.
    """

    def __init__(self) -> None:
        self.counts = StreamCounts()
        self._partial = b""
        self._overflowed = False

    def feed(self, octets: bytes) -> bytes:
        """All records of the good packets that end in these bytes, as one block."""
        pieces = (self._partial + octets).split(DELIMITER)
        self._partial = pieces.pop()
        if pieces and self._overflowed:
            self._overflowed = False
            pieces[0] = b""
        if len(self._partial) > PACKET_LIMIT or self._overflowed:
            if not self._overflowed:
                self.counts.too_long += 1
            self._partial, self._overflowed = b"", True
        return b"".join(filter(None, map(self._open, pieces)))

    def reset(self) -> None:
        """Forget a half packet, after a reconnection."""
        self._partial, self._overflowed = b"", False

    def _open(self, packet: bytes) -> bytes | None:
        if not packet:
            return None
        if len(packet) > PACKET_LIMIT:
            self.counts.too_long += 1
            return None
        try:
            sealed = cobs.decode(packet)
        except cobs.DecodeError:
            self.counts.bad_coding += 1
            return None
        if len(sealed) <= _CRC_SIZE or (len(sealed) - _CRC_SIZE) % RECORD_SIZE:
            self.counts.bad_length += 1
        elif crc_hqx(sealed, 0xFFFF):  # a CRC over data and its own CRC is zero
            self.counts.bad_crc += 1
        else:
            self.counts.packets += 1
            return sealed[:-_CRC_SIZE]
        return None
