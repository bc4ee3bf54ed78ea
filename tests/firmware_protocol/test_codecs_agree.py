"""The two codecs read the schema independently of one another: table-driven Python, and emitted straight-line compiled
code.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol import block_codec, codec, receiver, words
from firmware_protocol.schema import CRC_POLYNOMIAL, INDEX, MESSAGES, RECORD_SIZE, Direction, Message, offset
from tests.endpoints import Receiver

EACH_MESSAGE = pytest.mark.parametrize("message", MESSAGES, ids=lambda message: message.name)


def raw_strategy(message: Message) -> st.SearchStrategy[tuple[int, ...]]:
    return st.tuples(*(st.integers(field.raw_low, field.raw_high) for field in message.fields))


def any_message() -> st.SearchStrategy[tuple[Message, tuple[int, ...]]]:
    return st.sampled_from(MESSAGES).flatmap(lambda message: st.tuples(st.just(message), raw_strategy(message)))


def compiled_record(message: Message, raw: tuple[int, ...], counter: int) -> bytes:
    mail, counters, out = block_codec.new_mail(), block_codec.new_counters(), np.zeros(RECORD_SIZE, dtype=np.uint8)
    slot, index = offset(message.name), INDEX[message.name]
    mail[slot + 1 : slot + 1 + len(raw)] = raw
    counters[index] = counter
    size = block_codec.encode_messages(mail, np.array([index]), counters, out)
    assert size == RECORD_SIZE and counters[index] == (counter + 1) % 16
    return out.tobytes()


def octets(block: bytes) -> np.ndarray:
    return np.array(list(block), dtype=np.uint8)


def decode(block: bytes, direction: Direction) -> tuple[int, np.ndarray, np.ndarray]:
    mail, receivers = block_codec.new_mail(), block_codec.new_receivers()
    good = block_codec.receive_block(octets(block), len(block), mail, receivers, int(direction))
    return good, mail, receivers


@given(any_message(), st.integers(0, 15))
@settings(max_examples=400, deadline=None)
def test_every_message_and_value_comes_back_as_it_was_and_both_codecs_write_the_same_bits(sent, counter):
    message, raw = sent
    record = codec.record(message.can_id, codec.pack_raw(message, raw, counter))
    assert compiled_record(message, raw, counter) == record
    assert codec.unpack_raw(message, record[2:]) == raw
    assert codec.alive_counter(record[2:]) == counter
    good, mail, _ = decode(record, message.direction)
    slot = offset(message.name)
    assert good == 1 and mail[slot] == 1
    assert tuple(mail[slot + 1 : slot + 1 + len(raw)]) == raw
    assert np.count_nonzero(mail) <= 1 + len(raw)


@given(st.binary(min_size=8, max_size=8))
@settings(max_examples=50, deadline=None)
def test_interpreted_code_reads_an_array_of_bytes_as_it_reads_bytes(payload):
    block = octets(payload)
    assert words.read_fields(block, 0) == int.from_bytes(payload[:6], "little")
    assert words.read_pair(block, 6) == int.from_bytes(payload[6:], "little")


@EACH_MESSAGE
def test_the_bounds_of_every_field_survive_the_wire(message):
    lows, highs = tuple(field.raw_low for field in message.fields), tuple(field.raw_high for field in message.fields)
    for place in range(len(message.fields)):
        for edge in (lows[place], highs[place]):
            for rest in (lows, highs):
                raw = rest[:place] + (edge,) + rest[place + 1 :]
                record = compiled_record(message, raw, 3)
                assert codec.unpack_raw(message, record[2:]) == raw
                assert codec.record(message.can_id, codec.pack_raw(message, raw, 3)) == record


@given(any_message())
@settings(max_examples=200, deadline=None)
def test_typed_messages_keep_their_raw_integers(sent):
    message, raw = sent
    typed = codec.from_raw(message, raw)
    assert codec.raw_values(typed) == raw
    assert codec.unpack(message.can_id, codec.pack(typed, 7)) == typed


@EACH_MESSAGE
@given(data=st.data())
@settings(max_examples=30, deadline=None)
def test_a_number_beyond_its_field_is_held_at_the_bound_and_never_wraps(message, data):
    wild = data.draw(st.tuples(*(st.integers(-(2**62), 2**62) for _ in message.fields)))
    held = tuple(
        min(max(number, field.raw_low), field.raw_high) for number, field in zip(wild, message.fields, strict=True)
    )
    record = compiled_record(message, wild, 0)
    assert codec.unpack_raw(message, record[2:]) == held
    assert codec.pack_raw(message, wild, 0) == record[2:]


@given(
    st.floats(allow_nan=True, allow_infinity=True),
    st.sampled_from([field for message in MESSAGES for field in message.fields]),
)
@settings(deadline=None)
def test_quantising_is_the_same_compiled_and_plain_for_every_float(value, field):
    plain = block_codec.quantise.py_func(value, field.step, field.raw_low, field.raw_high)
    assert block_codec.quantise(value, field.step, field.raw_low, field.raw_high) == plain
    if math.isnan(value):
        assert plain == min(max(0, field.raw_low), field.raw_high)
    elif field.raw_low <= value / field.step <= field.raw_high:
        assert abs(plain - value / field.step) <= 0.5


def _flip(record: bytes, pattern: int) -> bytes:
    return (int.from_bytes(record, "little") ^ pattern).to_bytes(len(record), "little")


def mutated_block() -> st.SearchStrategy[bytes]:
    """Good records, records with flipped bits, and raw garbage, cut anywhere."""
    message = any_message().map(lambda sent: (sent[0], codec.pack_raw(sent[0], sent[1], sum(sent[1]))))
    good = message.map(lambda sent: codec.record(sent[0].can_id, sent[1]))
    flipped = st.tuples(good, st.integers(1, 2**80 - 1)).map(lambda pair: _flip(*pair))
    return st.lists(st.one_of(good, flipped, st.binary(max_size=15)), max_size=12).map(b"".join)


@given(st.lists(mutated_block(), min_size=1, max_size=5), st.sampled_from(Direction))
@settings(max_examples=300, deadline=None)
def test_any_bytes_get_the_same_verdicts_from_both_receivers_and_raise_in_neither(blocks, direction):
    mail, receivers = block_codec.new_mail(), block_codec.new_receivers()
    plain = Receiver(direction)
    for block in blocks:
        plain.age()
        good = block_codec.receive_block(octets(block), len(block), mail, receivers, int(direction))
        assert good == len(plain.receive(block))
    strays = receivers[block_codec.MESSAGE_COUNT]
    assert strays[receiver.STRAY_IDENTIFIERS] == plain.strays.get(codec.Rejection.UNKNOWN_IDENTIFIER, 0)
    assert strays[receiver.STRAY_DIRECTION] == plain.strays.get(codec.Rejection.WRONG_DIRECTION, 0)
    assert strays[receiver.STRAY_TRUNCATED] == plain.strays.get(codec.Rejection.TRUNCATED, 0)
    for reception in plain.receptions.values():
        message, row = reception.definition, receivers[INDEX[reception.definition.name]]
        assert row[receiver.GOOD] == reception.good
        assert row[receiver.LOST_FRAMES] == reception.lost
        assert row[receiver.LAST_COUNTER] == reception.last_counter
        assert row[receiver.TROUBLE] == reception.trouble
        assert row[receiver.STATUS] == reception.status
        assert row[receiver.CRC_ERRORS] == reception.rejected.get(codec.Rejection.BAD_CRC, 0)
        assert row[receiver.OUT_OF_RANGE] == reception.rejected.get(codec.Rejection.OUT_OF_RANGE, 0)
        assert row[receiver.DUPLICATES] == reception.rejected.get(codec.Rejection.DUPLICATE, 0)
        if reception.latest is not None:
            slot = offset(message.name) + 1
            assert tuple(mail[slot : slot + len(message.fields)]) == codec.raw_values(reception.latest)


def test_a_good_frame_of_the_other_direction_changes_nothing():
    set_point = next(message for message in MESSAGES if message.name == "set_point")
    record = compiled_record(set_point, (1, 2, 3, 1, 1), 0)
    good, mail, receivers = decode(record, Direction.DEVICE_TO_HOST)
    assert good == 0 and not mail.any()
    assert receivers[block_codec.MESSAGE_COUNT, receiver.STRAY_DIRECTION] == 1


def test_an_enumeration_value_without_a_name_is_refused_although_its_crc_is_right():
    status = next(message for message in MESSAGES if message.name == "drive_status")
    word = 9  # state 9 of 8
    payload = _seal(status, word)
    assert codec.unpack(status.can_id, payload) is codec.Rejection.OUT_OF_RANGE
    good, mail, receivers = decode(codec.record(status.can_id, payload), Direction.DEVICE_TO_HOST)
    assert good == 0 and not mail.any()
    assert receivers[INDEX["drive_status"], receiver.OUT_OF_RANGE] == 1


def _seal(message: Message, word: int) -> bytes:
    crc = 0
    for octet in [message.data_id, 0, *word.to_bytes(6, "little")]:
        crc ^= octet << 4
        for _ in range(8):
            crc = ((crc << 1) ^ (CRC_POLYNOMIAL if crc & 0x800 else 0)) & 0xFFF
    return (word | crc << 52).to_bytes(8, "little")
