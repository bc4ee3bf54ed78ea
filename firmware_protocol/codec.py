"""Frames to typed messages and back in plain Python: for tools, tests and everything outside the tick.

Table-driven straight from the schema, with the same integer arithmetic (`words`, `receiver`) that `block_codec` has
compiled. What comes from the wire never raises: it becomes a message or a `Rejection`.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from enum import Enum

from firmware_protocol.layout import CRC_TABLE, INITIAL_BY_NAME, ROWS_BY_NAME
from firmware_protocol.messages import CLASSES, AnyMessage
from firmware_protocol.schema import (
    BY_CAN_ID,
    COUNTER_START,
    CRC_START,
    MESSAGES,
    PAYLOAD_SIZE,
    RECORD_FORMAT,
    RECORD_SIZE,
    Field,
    Message,
)
from firmware_protocol.words import crc12, extract, insert, quantise, saturate

_RECORD = struct.Struct(RECORD_FORMAT)
_WORD = struct.Struct("<Q")
_SEALED = (1 << CRC_START) - 1
_SCHEMA = {CLASSES[message.name]: message for message in MESSAGES}


class Rejection(Enum):
    """Why a frame was not taken."""

    UNKNOWN_IDENTIFIER = "no message has this identifier"
    WRONG_LENGTH = "the payload is not eight bytes long"
    BAD_CRC = "the CRC does not match"
    OUT_OF_RANGE = "a field is outside its bounds"
    WRONG_DIRECTION = "the message belongs to the other direction"
    DUPLICATE = "the alive counter repeats or comes late"
    TRUNCATED = "the block ends inside a record"


def schema_of(message: AnyMessage) -> Message:
    """Definition of a message object."""
    return _SCHEMA[type(message)]


def raw_values(message: AnyMessage) -> tuple[int, ...]:
    """Raw integers of a message in schema order; values beyond a bound are held at it, NaN becomes zero."""
    definition = schema_of(message)
    rows = ROWS_BY_NAME[definition.name]
    return tuple(
        _raw(each, row, getattr(message, each.attribute)) for each, row in zip(definition.fields, rows, strict=True)
    )


def from_raw(definition: Message, raw: Sequence[int]) -> AnyMessage:
    """Message object from raw integers that are within bounds."""
    build: Callable[..., AnyMessage] = CLASSES[definition.name]
    return build(*(_value(each, number) for each, number in zip(definition.fields, raw, strict=True)))


def pack(message: AnyMessage, counter: int) -> bytes:
    """Payload of eight bytes with this alive counter (modulo 16)."""
    return pack_raw(schema_of(message), raw_values(message), counter)


def pack_raw(definition: Message, raw: Sequence[int], counter: int) -> bytes:
    """Payload of eight bytes from raw integers in schema order; numbers beyond a bound are held at it."""
    word = (counter & 15) << COUNTER_START
    for (start, bits, _, low, high), number in zip(ROWS_BY_NAME[definition.name], raw, strict=True):
        word = insert(word, start, bits, saturate(number, low, high))
    return _WORD.pack(word | crc12(word, INITIAL_BY_NAME[definition.name], CRC_TABLE) << CRC_START)


def unpack(can_id: int, payload: bytes) -> AnyMessage | Rejection:
    """Message in a frame, or why there is none."""
    definition = BY_CAN_ID.get(can_id)
    if definition is None:
        return Rejection.UNKNOWN_IDENTIFIER
    raw = unpack_raw(definition, payload)
    return raw if isinstance(raw, Rejection) else from_raw(definition, raw)


def unpack_raw(definition: Message, payload: bytes) -> tuple[int, ...] | Rejection:
    """Raw integers in a payload in schema order, or why they cannot be trusted."""
    if len(payload) != PAYLOAD_SIZE:
        return Rejection.WRONG_LENGTH
    word = int.from_bytes(payload, "little")
    sealed = word & _SEALED
    if crc12(sealed, INITIAL_BY_NAME[definition.name], CRC_TABLE) != word >> CRC_START:
        return Rejection.BAD_CRC
    raw = []
    for start, bits, signed, low, high in ROWS_BY_NAME[definition.name]:
        number = extract(sealed, start, bits, signed)
        if number < low or number > high:
            return Rejection.OUT_OF_RANGE
        raw.append(number)
    return tuple(raw)


def alive_counter(payload: bytes) -> int:
    """Alive counter of a payload of eight bytes."""
    return payload[6] & 15


def record(can_id: int, payload: bytes) -> bytes:
    """One frame as a record of ten bytes."""
    return _RECORD.pack(can_id, payload)


def records(block: bytes) -> Iterator[tuple[int, bytes]]:
    """Identifier and payload of each whole record of a block."""
    return _RECORD.iter_unpack(block[: len(block) - len(block) % RECORD_SIZE])  # type: ignore[return-value]


def _raw(definition: Field, row: tuple[int, ...], value: float) -> int:
    low, high = row[3:]
    return quantise(value, definition.step, low, high) if definition.is_physical else saturate(int(value), low, high)


def _value(definition: Field, raw: int) -> object:
    if definition.enum is not None:
        return definition.enum(raw)
    if definition.is_flag:
        return bool(raw)
    return raw * definition.step if definition.is_physical else raw
