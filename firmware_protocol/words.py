"""Integer arithmetic of one frame, written once: plain Python in `codec`, compiled in `block_codec`.

Every function works on integers that fit int64 and gives the same result in Python and in numba. The field word (48
bits) and the sealed word (52 bits: fields and counter) are never negative; the 16-bit tail holds counter and CRC.
"""

from __future__ import annotations

from typing import Protocol

#: 1.5 * 2^52: the numbers around it are the whole numbers
ROUNDER = 6755399441055744.0


class Numbers(Protocol):
    """Anything that answers an integer to an integer index: bytes, a tuple, an array."""

    def __getitem__(self, at: int, /) -> int: ...


class Slots(Numbers, Protocol):
    """Numbers that can be set: a mail, whatever holds it."""

    def __setitem__(self, at: int, raw: int, /) -> None: ...


def extract(word: int, start: int, bits: int, signed: int) -> int:
    """Raw integer of a field: `bits` wide from bit `start`, two's complement when `signed` is 1."""
    raw = (word >> start) & ((1 << bits) - 1)
    return raw - (((raw >> (bits - 1)) & signed) << bits)


def insert(word: int, start: int, bits: int, raw: int) -> int:
    """`word` with a raw integer put into bits that are still zero."""
    return word | ((raw & ((1 << bits) - 1)) << start)


def saturate(raw: int, low: int, high: int) -> int:
    """`raw` held within [low, high]: a number too big for its field must never wrap round to the other sign."""
    if raw < low:
        return low
    return high if raw > high else raw


def quantise(value: float, step: float, low: int, high: int) -> int:
    """Raw integer nearest to a physical value (ties to even), held within [low, high]; NaN becomes the bound nearest
    zero.
    """
    scaled = value / step
    if scaled >= high:
        return high
    if scaled <= low:
        return low
    if scaled != scaled:
        return min(max(0, low), high)
    # added and taken off again it leaves a whole number, ties to even, in a tenth of the time of a call to round()
    return int((scaled + ROUNDER) - ROUNDER)


def crc12(sealed: int, initial: int, table: Numbers) -> int:
    """CRC of a sealed word: `initial` is the part of the data id, `table[256 k + b]` that of byte b at place k (seven
    places).
    """
    crc = initial
    for place in range(7):
        crc ^= table[256 * place + ((sealed >> (8 * place)) & 0xFF)]
    return crc


def read_fields(block: Numbers, at: int) -> int:
    """Field word from the six payload bytes that begin at `at`."""
    return (
        (0 + int(block[at]))
        | ((0 + int(block[at + 1])) << 8)
        | ((0 + int(block[at + 2])) << 16)
        | ((0 + int(block[at + 3])) << 24)
        | ((0 + int(block[at + 4])) << 32)
        | ((0 + int(block[at + 5])) << 40)
    )


def read_pair(block: Numbers, at: int) -> int:
    """Little-endian 16-bit number at `at`: an identifier, or the tail of a payload."""
    return (0 + int(block[at])) | ((0 + int(block[at + 1])) << 8)


def crc_table(polynomial: int, width: int, places: int) -> tuple[int, ...]:
    """Contribution of each byte value at each place to a CRC of `places` bytes that starts from zero, first byte most
    significant.

    A CRC that starts from zero is linear, so the CRC of a row of bytes is the exclusive or of these contributions; they
    do not depend on one another, which lets the processor look them up side by side.
    """
    rows: list[int] = []
    for place in range(places):
        for value in range(256):
            crc = value << (width - 8)
            for _ in range(8 * (places - place)):
                crc = ((crc << 1) ^ (polynomial if crc >> (width - 1) else 0)) & ((1 << width) - 1)
            rows.append(crc)
    return tuple(rows)
