"""Number tables derived from the schema, as plain tuples: what both codecs need to take a frame apart."""

from __future__ import annotations

from firmware_protocol.schema import CRC_BITS, CRC_POLYNOMIAL, EDGE_CAN_ID, MESSAGES, Field, Message, offset
from firmware_protocol.words import crc_table

_DATA_ID_AND_PLACES = crc_table(CRC_POLYNOMIAL, CRC_BITS, 8)

#: contribution of each byte at each of the seven places of a sealed word, for `words.crc12`; the CRC takes the counter
#: in before the fields, so that what it protects are 52 bits in a row
CRC_TABLE: tuple[int, ...] = _DATA_ID_AND_PLACES[512:] + _DATA_ID_AND_PLACES[256:512]

#: where a CRC starts that has already taken a message's data id in
CRC_INITIAL: tuple[int, ...] = tuple(_DATA_ID_AND_PLACES[message.data_id] for message in MESSAGES)

#: the same for the edge of lockstep
EDGE_INITIAL = _DATA_ID_AND_PLACES[EDGE_CAN_ID >> 4]

#: columns of a row of FIELD_ROWS
START, BITS, SIGNED, LOW, HIGH = range(5)

#: columns of a row of MESSAGE_ROWS
CAN_ID, DIRECTION, PERIOD, INITIAL, SLOT, FIRST_FIELD, FIELD_COUNT = range(7)


def _field_row(message: Message, field: Field) -> tuple[int, ...]:
    return (message.start(field.name), field.bits, int(field.signed), field.raw_low, field.raw_high)


def _message_rows() -> tuple[tuple[int, ...], ...]:
    rows, first = [], 0
    for index, message in enumerate(MESSAGES):
        count = len(message.fields)
        rows.append(
            (
                message.can_id,
                int(message.direction),
                message.period_ticks,
                CRC_INITIAL[index],
                offset(message.name),
                first,
                count,
            )
        )
        first += count
    return tuple(rows)


#: one row per field of all messages in schema order
FIELD_ROWS: tuple[tuple[int, ...], ...] = tuple(
    _field_row(message, field) for message in MESSAGES for field in message.fields
)

#: one row per message in schema order
MESSAGE_ROWS: tuple[tuple[int, ...], ...] = _message_rows()

#: message index by 11-bit identifier, -1 where no message has it
INDEX_BY_CAN_ID: tuple[int, ...] = tuple(
    next((index for index, message in enumerate(MESSAGES) if message.can_id == can_id), -1) for can_id in range(2048)
)

#: rows of FIELD_ROWS that belong to each message
ROWS_BY_NAME: dict[str, tuple[tuple[int, ...], ...]] = {
    message.name: FIELD_ROWS[row[FIRST_FIELD] : row[FIRST_FIELD] + row[FIELD_COUNT]]
    for message, row in zip(MESSAGES, MESSAGE_ROWS, strict=True)
}

#: CRC start by message name
INITIAL_BY_NAME: dict[str, int] = {
    message.name: initial for message, initial in zip(MESSAGES, CRC_INITIAL, strict=True)
}
