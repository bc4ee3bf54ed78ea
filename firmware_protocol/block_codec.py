"""Blocks of frames to mail and back, compiled: what runs inside the tick.

The arithmetic is that of `words` and `receiver`, compiled here; the pure Python `codec` runs the same source. All
arrays are C-contiguous: blocks uint8, everything else int64.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import compiled, entry_point
from firmware_protocol.field_words import pack, unpack
from firmware_protocol.layout import CAN_ID, CRC_TABLE, DIRECTION, INDEX_BY_CAN_ID, INITIAL, MESSAGE_ROWS, PERIOD, SLOT
from firmware_protocol.leaves import (
    Integers,
    Octets,
    crc12,
    judge_counter,
    judge_status,
    leaf,
    memory_ticks,
    more_trouble,
    quantise,
    read_fields,
    read_pair,
)
from firmware_protocol.receiver import (
    COLUMNS,
    CRC_ERRORS,
    DUPLICATE,
    DUPLICATES,
    GOOD,
    LAST_COUNTER,
    LOST_FRAMES,
    OUT_OF_RANGE,
    STATUS,
    STATUS_LOST,
    STRAY_DIRECTION,
    STRAY_IDENTIFIERS,
    STRAY_TRUNCATED,
    TICKS_SINCE_GOOD,
    TROUBLE,
    UNKNOWN_COUNTER,
)
from firmware_protocol.schema import MAIL_SIZE, MESSAGES, RECORD_SIZE

MESSAGE_COUNT = len(MESSAGES)

_CRC = np.array(CRC_TABLE, dtype=np.int16)
_MESSAGES = np.array(MESSAGE_ROWS, dtype=np.int64)
#: a message index looked up here is no literal any more, so that the encoder is not compiled anew for each message
_SAME = np.arange(len(MESSAGES), dtype=np.int64)
_INDEX = np.array(INDEX_BY_CAN_ID, dtype=np.int8)


__all__ = [
    "MESSAGE_COUNT",
    "age_receivers",
    "clear_fresh",
    "decode_block",
    "encode_mail",
    "encode_messages",
    "new_counters",
    "new_mail",
    "new_receivers",
    "quantise",
    "receive_block",
    "reset_receivers",
]


def new_mail() -> Integers:
    """An empty mail, int64 shape (MAIL_SIZE,)."""
    return np.zeros(MAIL_SIZE, dtype=np.int64)


def new_counters() -> Integers:
    """Alive counters of a sender, int64 shape (MESSAGE_COUNT,)."""
    return np.zeros(MESSAGE_COUNT, dtype=np.int64)


def new_receivers() -> Integers:
    """Receivers that have heard nothing yet, int64 shape (MESSAGE_COUNT + 1, COLUMNS); columns in `receiver`."""
    receivers = np.zeros((MESSAGE_COUNT + 1, COLUMNS), dtype=np.int64)
    receivers[:MESSAGE_COUNT, LAST_COUNTER] = UNKNOWN_COUNTER
    return receivers


@compiled
def clear_fresh(mail: Integers, direction: int) -> None:
    """Begin a tick: no message of this direction is fresh."""
    for message in range(MESSAGE_COUNT):
        if _MESSAGES[message, DIRECTION] == direction:
            mail[_MESSAGES[message, SLOT]] = 0


@leaf
def encode_mail(mail: Integers, message: int, counters: Integers, out: Octets, position: int) -> int:
    """Write one message of the mail as a record of ten bytes at `position`; answers the position behind it.

    Raw integers beyond a field's bounds are held at the bound. The message's alive counter goes on by one. `out` must
    have room.
    """
    return _encode(mail, _SAME[message], counters, out, position)


@leaf
def _encode(mail: Integers, message: int, counters: Integers, out: Octets, position: int) -> int:
    fields = pack(message, mail)
    counter = counters[message] & 15
    counters[message] = (counter + 1) & 15
    tail = counter | (crc12(fields | (counter << 48), _MESSAGES[message, INITIAL], _CRC) << 4)
    can_id = _MESSAGES[message, CAN_ID]
    out[position] = can_id & 0xFF
    out[position + 1] = can_id >> 8
    for place in range(6):
        out[position + 2 + place] = (fields >> (8 * place)) & 0xFF
    out[position + 8] = tail & 0xFF
    out[position + 9] = tail >> 8
    return position + RECORD_SIZE


@leaf
def _reject(receivers: Integers, message: int, column: int) -> int:
    receivers[message, column] += 1
    receivers[message, TROUBLE] = more_trouble(receivers[message, TROUBLE], 1)
    return 0


@leaf
def _accept(block: Octets, at: int, message: int, mail: Integers, receivers: Integers) -> int:
    """Check one record's payload and let it into the mail; 1 when good."""
    fields = read_fields(block, at)
    tail = read_pair(block, at + 6)
    counter = tail & 15
    if crc12(fields | (counter << 48), _MESSAGES[message, INITIAL], _CRC) != tail >> 4:
        return _reject(receivers, message, CRC_ERRORS)
    lost = judge_counter(receivers[message, LAST_COUNTER], counter)
    if lost == DUPLICATE:
        receivers[message, DUPLICATES] += 1
        return 0
    if not unpack(message, fields, mail):
        return _reject(receivers, message, OUT_OF_RANGE)
    mail[_MESSAGES[message, SLOT]] += 1
    receivers[message, LAST_COUNTER] = counter
    receivers[message, GOOD] += 1
    receivers[message, LOST_FRAMES] += lost
    receivers[message, TICKS_SINCE_GOOD] = 0
    trouble = more_trouble(receivers[message, TROUBLE], lost)
    trouble = trouble - 1 if trouble > 0 else 0
    receivers[message, TROUBLE] = trouble
    receivers[message, STATUS] = judge_status(_MESSAGES[message, PERIOD], 0, trouble, 1)
    return 1


@compiled
def decode_block(block: Octets, n_bytes: int, mail: Integers, receivers: Integers, direction: int) -> int:
    """Let every good frame of the first `n_bytes` of a block into the mail; answers how many were good.

    A frame counts when its identifier is known and of this `direction`, CRC and fields are right and its counter is
    new. All others are counted in `receivers` and change nothing. When a message comes more than once the last one
    stays, `fresh` tells how many.
    """
    good = 0
    whole = n_bytes - n_bytes % RECORD_SIZE
    for at in range(0, whole, RECORD_SIZE):
        can_id = read_pair(block, at)
        message = _INDEX[can_id] if can_id < 2048 else -1
        if message < 0:
            receivers[MESSAGE_COUNT, STRAY_IDENTIFIERS] += 1
        elif _MESSAGES[message, DIRECTION] != direction:
            receivers[MESSAGE_COUNT, STRAY_DIRECTION] += 1
        else:
            good += _accept(block, at + 2, message, mail, receivers)
    if whole != n_bytes:
        receivers[MESSAGE_COUNT, STRAY_TRUNCATED] += 1
    return good


@compiled
def age_receivers(receivers: Integers, direction: int) -> None:
    """Let one tick pass for the messages of one direction: call once per tick, before `decode_block`."""
    for message in range(MESSAGE_COUNT):
        if _MESSAGES[message, DIRECTION] != direction:
            continue
        period = _MESSAGES[message, PERIOD]
        silence = receivers[message, TICKS_SINCE_GOOD] + 1
        receivers[message, TICKS_SINCE_GOOD] = silence
        if silence > memory_ticks(period):
            receivers[message, LAST_COUNTER] = UNKNOWN_COUNTER
        heard = 1 if receivers[message, GOOD] > 0 else 0
        receivers[message, STATUS] = judge_status(period, silence, receivers[message, TROUBLE], heard)


@compiled
def reset_receivers(receivers: Integers) -> None:
    """Begin anew after a reconnection: every message lost until heard again, any counter welcome; the counts stay."""
    for message in range(MESSAGE_COUNT):
        receivers[message, LAST_COUNTER] = UNKNOWN_COUNTER
        receivers[message, TICKS_SINCE_GOOD] = memory_ticks(_MESSAGES[message, PERIOD]) + 1
        receivers[message, STATUS] = STATUS_LOST


@entry_point
def encode_messages(mail: Integers, messages: Integers, counters: Integers, out: Octets) -> int:
    """Encode the listed message indices one after the other into `out`; answers the number of bytes."""
    position = 0
    for place in range(messages.size):
        position = encode_mail(mail, messages[place], counters, out, position)
    return position


@entry_point
def receive_block(block: Octets, n_bytes: int, mail: Integers, receivers: Integers, direction: int) -> int:
    """One tick of a receiver, called from Python: age, forget what was fresh, decode; answers the number of good
    frames.
    """
    age_receivers(receivers, direction)
    clear_fresh(mail, direction)
    return int(decode_block(block, n_bytes, mail, receivers, direction))
