"""A record ring in shared memory: one writer that never waits, one reader that may be slow, dead or absent.

The writer overwrites the oldest records when the ring is full; the reader finds out how many it lost from the record
numbers. Every record carries a CRC-32, so a reader on a machine that reorders stores sees an unfinished record as
unfinished and not as data. The memory is an anonymous file handed to the other process by descriptor: it has no name
that a killed process could leave behind.

    word 0       1         2          3             4              from byte 64
    magic        capacity  head       tail          reader         records
                           (end of    (start of     (how far the
                           written)   oldest whole) reader is)

Positions count bytes since the start and never wrap; a record is at `position % capacity` and does not run over the
end.
"""

from __future__ import annotations

import mmap
import os
import struct
import tempfile
import zlib
from dataclasses import dataclass

_MAGIC = 0x676D626C52494E47
_HEADER_BYTES = 64
_RECORD = struct.Struct("=QIIII")  # number, kind, length, CRC-32 of number, kind and payload, padding
_FILLER = 0xFFFFFFFF  # kind of the record that fills the rest of the ring before its end
_HEAD, _TAIL, _READER = 2, 3, 4


@dataclass(frozen=True, slots=True)
class RingRecord:
    """One message: a small number that says what it is, and its bytes."""

    kind: int
    payload: bytes


def anonymous_memory(size: int) -> int:
    """Descriptor of `size` bytes of zeroed memory without a name; inherited by children that are given it."""
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("gimbal-hil")
    else:
        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.ftruncate(descriptor, size)
    return descriptor


def create_ring(capacity: int) -> int:
    """Descriptor of a new, empty ring that holds `capacity` bytes of records (rounded up to a page)."""
    size = -(-(capacity + _HEADER_BYTES) // mmap.PAGESIZE) * mmap.PAGESIZE
    descriptor = anonymous_memory(size)
    with mmap.mmap(descriptor, size) as memory, memoryview(memory).cast("Q") as words:
        words[0], words[1] = _MAGIC, size - _HEADER_BYTES
    return descriptor


class _Mapped:
    def __init__(self, descriptor: int) -> None:
        self._memory = mmap.mmap(descriptor, os.fstat(descriptor).st_size)
        view = memoryview(self._memory)
        #: eight-byte items are stored and loaded in one instruction; `struct` in standard byte order would go byte by
        #: byte
        self._words = view[:_HEADER_BYTES].cast("Q")
        self._records = view[_HEADER_BYTES:]
        if self._words[0] != _MAGIC:
            raise ValueError("the descriptor does not hold a record ring")
        self._capacity = self._words[1]

    @property
    def backlog(self) -> int:
        """Bytes written that the reader has not taken yet, lost ones included."""
        return self._words[_HEAD] - self._words[_READER]

    @property
    def reader_position(self) -> int:
        """How far the reader is, in bytes since the start: it moves on as long as the reader lives and there is
        something to take.
        """
        return self._words[_READER]

    def close(self) -> None:
        """Unmap the ring; the other side is not affected."""
        self._words.release()
        self._records.release()
        self._memory.close()


class RingWriter(_Mapped):
    """The only writer of a ring. `push` takes bounded time whatever the reader does."""

    def __init__(self, descriptor: int) -> None:
        super().__init__(descriptor)
        self._head = self._words[_HEAD]
        self._tail = self._words[_TAIL]
        self.pushed = 0

    @property
    def largest_payload(self) -> int:
        """A record may take a quarter of the ring, so that a reader in step always finds one that stays."""
        return self._capacity // 4 - _RECORD.size

    def push(self, kind: int, payload: bytes) -> None:
        """Append a record, over the oldest ones if need be; ValueError when it is larger than `largest_payload`."""
        if len(payload) > self.largest_payload:
            raise ValueError(f"a record of {len(payload)} bytes does not fit a ring that takes {self.largest_payload}")
        position = self._make_room(_span(len(payload)))
        self._fill(position, kind, payload)
        self._publish(position + _span(len(payload)))

    def push_if_room(self, kind: int, payload: bytes) -> bool:
        """Append a record only where it overwrites nothing that the reader has yet to take; answers whether it did."""
        room = self._capacity - (self._head - self._words[_READER])
        if len(payload) > self.largest_payload or 2 * _span(len(payload)) > room:
            return False
        self.push(kind, payload)
        return True

    def _make_room(self, span: int) -> int:
        """Give up the oldest records, tell the reader so, and answer where the new one goes."""
        offset = self._head % self._capacity
        position = self._head if offset + span <= self._capacity else self._head + self._capacity - offset
        if position + span - self._tail > self._capacity:
            # what has been read goes all at once, so that a reader in step costs nothing once a round
            self._tail = max(self._tail, min(self._words[_READER], self._head))
            while position + span - self._tail > self._capacity:
                self._tail = _next(self._records, self._tail, self._capacity)
            self._words[_TAIL] = self._tail
        return position

    def _fill(self, position: int, kind: int, payload: bytes) -> None:
        offset = self._head % self._capacity
        if position != self._head and self._capacity - offset >= _RECORD.size:
            _RECORD.pack_into(self._records, offset, 0, _FILLER, 0, 0, 0)
        offset = position % self._capacity
        crc = _checksum(self.pushed, kind, payload)
        _RECORD.pack_into(self._records, offset, self.pushed, kind, len(payload), crc, 0)
        self._records[offset + _RECORD.size : offset + _RECORD.size + len(payload)] = payload

    def _publish(self, head: int) -> None:
        self._head = head
        self.pushed += 1
        self._words[_HEAD] = head


class RingReader(_Mapped):
    """The only reader of a ring. `lost` counts the records that were overwritten before they were read."""

    def __init__(self, descriptor: int) -> None:
        super().__init__(descriptor)
        self._position = self._words[_TAIL]
        self._next_number = 0
        self.taken = 0
        self.lost = 0

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing new: a look at one word."""
        return self._position >= self._words[_HEAD]

    def take(self, most: int = 1 << 30) -> list[RingRecord]:
        """Up to `most` records in the order in which they were pushed; empty when there is nothing new."""
        records: list[RingRecord] = []
        while len(records) < most and self._position < self._words[_HEAD]:
            record = self._read_one()
            if record is None:
                break
            if record.kind != _FILLER:
                records.append(record)
        self._words[_READER] = self._position
        return records

    def _read_one(self) -> RingRecord | None:
        """The record at the reader's position; None while it is unfinished. Jumps to the oldest one after an
        overrun.
        """
        position = self._position
        if position >= self._words[_TAIL]:
            offset = position % self._capacity
            if self._capacity - offset < _RECORD.size:
                self._position = position + self._capacity - offset
                return RingRecord(_FILLER, b"")
            number, kind, length, crc, _ = _RECORD.unpack_from(self._records, offset)
            payload = bytes(self._records[offset + _RECORD.size : min(offset + _RECORD.size + length, self._capacity)])
            if position >= self._words[_TAIL]:
                if kind == _FILLER:
                    self._position = position + self._capacity - offset
                    return RingRecord(_FILLER, b"")
                if crc != _checksum(number, kind, payload):
                    return None
                self._position = position + _span(length)
                self.lost += number - self._next_number
                self._next_number = number + 1
                self.taken += 1
                return RingRecord(kind, payload)
        self._position = max(self._words[_TAIL], position)
        return RingRecord(_FILLER, b"")


def _span(length: int) -> int:
    return (_RECORD.size + length + 7) & ~7


def _next(records: memoryview, position: int, capacity: int) -> int:
    offset = position % capacity
    if capacity - offset < _RECORD.size:
        return position + capacity - offset
    _, kind, length, _, _ = _RECORD.unpack_from(records, offset)
    return position + (capacity - offset if kind == _FILLER else _span(length))


def _checksum(number: int, kind: int, payload: bytes) -> int:
    return zlib.crc32(payload, (number * 0x9E3779B1 + kind) & 0xFFFFFFFF)
