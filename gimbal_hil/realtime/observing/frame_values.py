"""Values out of frames, one at a time and fast: for an onlooker that reads every tick."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from firmware_protocol import schema

_RECORD = schema.RECORD_SIZE


@dataclass(frozen=True, slots=True)
class FieldReader:
    """Reads one field out of a frame's payload, in its unit."""

    shift: int
    mask: int
    sign: int
    step: float

    @classmethod
    def of(cls, message: str, field: str) -> FieldReader:
        """The reader of a field; StopIteration where there is none."""
        found = schema.BY_NAME[message]
        wanted = next(one for one in found.fields if one.name == field)
        sign = 1 << (wanted.bits - 1) if wanted.signed else 0
        return cls(found.start(field), (1 << wanted.bits) - 1, sign, wanted.step)

    def value(self, word: int) -> float:
        """The value in a payload read as a little-endian word."""
        raw = (word >> self.shift) & self.mask
        return ((raw ^ self.sign) - self.sign) * self.step


def frames_in(block: bytes) -> Iterator[tuple[int, int]]:
    """(identifier, payload) of every frame of a block."""
    for at in range(0, len(block), _RECORD):
        yield int.from_bytes(block[at : at + 2], "little"), int.from_bytes(block[at + 2 : at + _RECORD], "little")
