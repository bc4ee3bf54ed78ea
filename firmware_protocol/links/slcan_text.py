"""Frames as lines of slcan, and back: what host and adapter say alike. A line ends in a carriage return.

`t` begins a frame with a standard identifier (three digits), `T` one with an extended identifier (eight); `b`, `B`,
`d`, `D` the FD frames of CANable's firmware with and without a faster data phase. Then come a digit for the length, the
data, and from some adapters four digits of time stamp.
"""

from __future__ import annotations

import re

from firmware_protocol.codec import record, records
from firmware_protocol.links.can_frame import CanFrame
from firmware_protocol.schema import PAYLOAD_SIZE

LINE_END = b"\r"

#: a standard data frame of eight bytes, with or without a time stamp
_RECORD = re.compile(rb"t[0-7][0-9A-Fa-f]{2}8[0-9A-Fa-f]{16}(?:[0-9A-Fa-f]{4})?")
_RECORD_LENGTH = 5 + 2 * PAYLOAD_SIZE

#: any data frame: letter, identifier, length, digits of data and time stamp
_FRAME = re.compile(rb"(?:([tbd])([0-7][0-9A-Fa-f]{2})|([TBD])([01][0-9A-Fa-f]{7}))([0-9A-Fa-f])((?:[0-9A-Fa-f]{2})*)")
_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)
_CLASSIC = 8
_STAMP = 2


def lines_of(block: bytes) -> bytes:
    """A line for each frame of a block."""
    return b"".join([b"t%03X8%b\r" % (can_id, payload.hex().upper().encode()) for can_id, payload in records(block)])


def record_of(line: bytes) -> bytes:
    """The record of a line without its end; nothing for a line that is no standard data frame of eight bytes."""
    if not _RECORD.fullmatch(line):
        return b""
    return record(int(line[1:4], 16), bytes.fromhex(line[5:_RECORD_LENGTH].decode("ascii")))


def line_of(frame: CanFrame) -> bytes:
    """The line of a frame, FD with the faster data phase; ValueError for a length that no frame has."""
    length = _LENGTHS.index(len(frame.data))
    if length > _CLASSIC and not frame.fd:
        raise ValueError(f"{len(frame.data)} bytes in a classic frame; expected 8 at most")
    letter = b"b" if frame.fd else b"t"
    head = b"%b%08X" % (letter.upper(), frame.identifier) if frame.extended else b"%b%03X" % (letter, frame.identifier)
    return b"%b%X%b\r" % (head, length, frame.data.hex().upper().encode())


def frame_of(line: bytes) -> CanFrame | None:
    """The frame of a line without its end; None for a line that is no whole data frame."""
    found = _FRAME.fullmatch(line)
    if found is None:
        return None
    standard, short, _, long, digit, digits = found.groups()
    fd = line[:1] in b"bdBD"
    length = int(digit, 16)
    size = _LENGTHS[length]
    if (length > _CLASSIC and not fd) or len(digits) // 2 not in (size, size + _STAMP):
        return None
    return CanFrame(int(short or long, 16), bytes.fromhex(digits[: 2 * size].decode("ascii")), standard is None, fd)
