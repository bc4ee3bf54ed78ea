"""Frames as lines of slcan, and back: what host and adapter say alike. A line ends in a carriage return."""

from __future__ import annotations

import re

from firmware_protocol.codec import record, records
from firmware_protocol.schema import PAYLOAD_SIZE

LINE_END = b"\r"

#: a standard data frame of eight bytes, with or without a time stamp
_FRAME = re.compile(rb"t[0-7][0-9A-Fa-f]{2}8[0-9A-Fa-f]{16}(?:[0-9A-Fa-f]{4})?")
_FRAME_LENGTH = 5 + 2 * PAYLOAD_SIZE


def lines_of(block: bytes) -> bytes:
    """A line for each frame of a block."""
    return b"".join([b"t%03X8%b\r" % (can_id, payload.hex().upper().encode()) for can_id, payload in records(block)])


def record_of(line: bytes) -> bytes:
    """The record of a line without its end; nothing for a line that is no standard data frame of eight bytes."""
    if not _FRAME.fullmatch(line):
        return b""
    return record(int(line[1:4], 16), bytes.fromhex(line[5:_FRAME_LENGTH].decode("ascii")))
