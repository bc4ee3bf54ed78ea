"""Lockstep over a link: the frame that ends what is for one tick, in both directions.

An antenna in lockstep goes on by one tick with every edge, on what came since the edge before, and ends its answer with
an edge of the same number; without one its time stands still. Number 0 begins: nothing is ticked, and the next edge is
number 1. The frame is sealed as every other; an antenna with a clock of its own drops it as an unknown identifier.
"""

from __future__ import annotations

from typing import Protocol

from firmware_protocol.layout import CRC_TABLE, EDGE_INITIAL
from firmware_protocol.schema import COUNTER_START, CRC_START, EDGE_BITS, EDGE_CAN_ID, RECORD_SIZE
from firmware_protocol.words import crc12

_ID = EDGE_CAN_ID.to_bytes(2, "little")
_NUMBERS = 1 << EDGE_BITS
#: what is kept of a sender that sends no edges, the newest
_MOST_KEPT = 65536 - 65536 % RECORD_SIZE
#: begins a conversation; the numbers of ticks leave it out
BEGIN = 0


class Ticking(Protocol):
    """An antenna that goes on by one tick when it is told to: a `Device`, or one in lockstep over a link."""

    def tick(self, received: bytes = b"") -> bytes:
        """Take a block of frames, go on by one tick, answer the block of this tick."""


def next_edge(number: int) -> int:
    """The number behind this one: BEGIN does not come again."""
    return (number + 1) % _NUMBERS or 1


def edge(number: int) -> bytes:
    """Record of the edge of this number."""
    word = number | (number & 15) << COUNTER_START
    return _ID + (word | crc12(word, EDGE_INITIAL, CRC_TABLE) << CRC_START).to_bytes(RECORD_SIZE - 2, "little")


class EdgeParser:
    """Whole records in, in pieces as they come; what stands before each edge of a wanted number out."""

    def __init__(self) -> None:
        self._pending = b""

    def feed(self, block: bytes) -> None:
        """Keep what has come."""
        self._pending = (self._pending + block)[-_MOST_KEPT:]

    def before(self, number: int) -> bytes | None:
        """Everything before the edge of this number, which is taken out with it; None as long as it has not come."""
        at = self._find(edge(number))
        if at < 0:
            return None
        block, self._pending = self._pending[:at], self._pending[at + RECORD_SIZE :]
        return block

    @property
    def kept(self) -> int:
        """Bytes that wait for their edge."""
        return len(self._pending)

    def _find(self, record: bytes) -> int:
        at = self._pending.find(record)
        while at % RECORD_SIZE and at >= 0:
            at = self._pending.find(record, at + 1)
        return at
