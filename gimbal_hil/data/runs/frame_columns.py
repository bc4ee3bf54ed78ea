"""Frame rows to physical columns, a whole log at a time, from the wire's one definition."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.protocol_versions import CURRENT, Protocol
from firmware_protocol.schema import COUNTER_START, CRC_START, Message
from firmware_protocol.words import crc12, extract


@dataclass(frozen=True)
class MessageColumns:
    """All good frames of one message in order: `place` in the log, host `tick`, alive `counter`, and `raw` integers by
    field name.
    """

    message: Message
    place: NDArray[np.int64]
    tick: NDArray[np.int64]
    counter: NDArray[np.int64]
    raw: dict[str, NDArray[np.int64]]
    #: by what the antenna multiplies the step of a field, as its identity says
    multiples: dict[str, float]

    def physical(self, field_name: str) -> NDArray[np.float64]:
        """Values of a field in its unit, shape (n,)."""
        step = next(field.step for field in self.message.fields if field.name == field_name)
        return np.asarray(self.raw[field_name] * (step * self.multiples.get(field_name, 1.0)), np.float64)


def columns_of(frames: NDArray[np.void], message_name: str, protocol: Protocol = CURRENT) -> MessageColumns:
    """Decode the good frames of one message of a version of the wire: identifier and direction right, CRC right, every
    field within its bounds. A message that the version does not have has no rows.
    """
    message = protocol.by_name.get(message_name, CURRENT.by_name[message_name])
    multiples = {}
    if message.name in protocol.by_name and any(field.exponent for field in message.fields):
        units = columns_of(frames, "identity_unit", protocol)
        if len(units.place):
            multiples = {
                field.name: 2.0 ** int(units.raw[field.exponent][-1]) for field in message.fields if field.exponent
            }
    if message.name not in protocol.by_name:
        frames = frames[:0]
    rows = np.flatnonzero((frames["identifier"] == message.can_id) & (frames["direction"] == message.direction))
    words = frames["payload"][rows]
    raw = raw_fields(message, words)
    good = crc_holds(message, words, protocol)
    for field in message.fields:
        good &= (raw[field.name] >= field.raw_low) & (raw[field.name] <= field.raw_high)
    rows, words = rows[good], words[good]
    counter = (words >> np.uint64(COUNTER_START)).astype(np.int64) & 15
    return MessageColumns(
        message, rows, frames["tick"][rows], counter, {name: values[good] for name, values in raw.items()}, multiples
    )


def raw_fields(message: Message, words: NDArray[np.uint64]) -> dict[str, NDArray[np.int64]]:
    """Raw integers of every field of payload words, valid or not."""
    low = (words & np.uint64((1 << COUNTER_START) - 1)).astype(np.int64)
    return {
        field.name: np.asarray(extract(low, message.start(field.name), field.bits, int(field.signed)))  # type: ignore[arg-type]
        for field in message.fields
    }


def crc_holds(message: Message, words: NDArray[np.uint64], protocol: Protocol = CURRENT) -> NDArray[np.bool_]:
    """Whether each payload word carries the CRC that its content and message ask for."""
    sealed = (words & np.uint64((1 << CRC_START) - 1)).astype(np.int64)
    initial = protocol.crc_initial.get(message.name, 0)
    expected = crc12(sealed, initial, np.array(protocol.crc_table, np.int64))  # type: ignore[arg-type]
    return np.asarray((words >> np.uint64(CRC_START)).astype(np.int64) == expected)


def describe_frame(identifier: int) -> str:
    """Name of a frame for people: its message, or its identifier where there is no such message."""
    message = CURRENT.by_can_id.get(identifier)
    return message.name if message is not None else f"frame 0x{identifier:03X}"


def describe_difference(identifier: int, expected: int, found: int) -> tuple[str, str, str]:
    """Signal (`message.field`) in which two payload words of one identifier differ first, with both values in words."""
    message = CURRENT.by_can_id.get(identifier)
    if message is not None:
        words = np.array([expected, found], np.uint64)
        for field in message.fields:
            raw = raw_fields(message, words)[field.name]
            if raw[0] != raw[1]:
                unit = f" {field.unit}" if field.unit else ""
                values = [
                    f"{value * field.step:.9g}{unit}" if field.is_physical else f"{value}{unit}"
                    for value in raw.tolist()
                ]
                return f"{message.name}.{field.name}", values[0], values[1]
        part = "counter" if (expected ^ found) >> COUNTER_START & 15 else "crc"
        start = COUNTER_START if part == "counter" else CRC_START
        mask = 15 if part == "counter" else 0xFFF
        return f"{message.name}.{part}", str(expected >> start & mask), str(found >> start & mask)
    return describe_frame(identifier), f"{expected:016x}", f"{found:016x}"
