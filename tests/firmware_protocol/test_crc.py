"""The CRC is the published one and finds what it promises to find."""

from __future__ import annotations

import itertools

from firmware_protocol import codec
from firmware_protocol.layout import CRC_INITIAL, CRC_TABLE
from firmware_protocol.schema import CRC_CHECK, CRC_POLYNOMIAL, MESSAGES
from firmware_protocol.words import crc12, crc_table


def bitwise_crc(octets: bytes) -> int:
    """The CRC one bit at a time, as a textbook has it."""
    crc = 0
    for octet in octets:
        crc ^= octet << 4
        for _ in range(8):
            crc = ((crc << 1) ^ (CRC_POLYNOMIAL if crc & 0x800 else 0)) & 0xFFF
    return crc


def test_the_check_value_is_that_of_the_polynomial():
    table, crc = crc_table(CRC_POLYNOMIAL, 12, 9), 0
    for place, octet in enumerate(b"123456789"):
        crc ^= table[256 * place + octet]
    assert crc == bitwise_crc(b"123456789") == CRC_CHECK


def test_the_table_form_equals_the_bitwise_form_over_data_id_and_payload():
    for message, initial in zip(MESSAGES, CRC_INITIAL, strict=True):
        for word in (0, 1, 0x123456789ABC, (1 << 52) - 1):
            octets = word.to_bytes(7, "little")
            assert crc12(word, initial, CRC_TABLE) == bitwise_crc(bytes([message.data_id]) + octets[6:] + octets[:6])


def test_every_error_of_up_to_four_bits_and_every_burst_of_twelve_in_the_fields_is_found():
    # the CRC is linear: an error pattern passes exactly when the CRC of its sealed part equals its CRC part
    single = [1 << bit for bit in range(64)]
    syndromes = [crc12(bit & ((1 << 52) - 1), 0, CRC_TABLE) ^ (bit >> 52) for bit in single]
    assert all(syndromes) and len(set(syndromes)) == 64
    pairs = [a ^ b for a, b in itertools.combinations(syndromes, 2)]
    # no three bits make nothing, and no two pairs of bits the same: Hamming distance five
    assert not set(pairs) & set(syndromes) and len(set(pairs)) == len(pairs)
    # bursts as the bus has them: byte after byte, most significant bit first
    bursts = (burst << start for start in range(37) for burst in range(1, 1 << 12, 2))
    assert all(crc12(int.from_bytes(burst.to_bytes(6, "big"), "little"), 0, CRC_TABLE) for burst in bursts)


def test_a_frame_under_another_messages_identifier_never_passes():
    for sender, receiver in itertools.permutations(MESSAGES, 2):
        payload = codec.pack_raw(sender, [0] * len(sender.fields), 5)
        assert codec.unpack(receiver.can_id, payload) is codec.Rejection.BAD_CRC


def test_the_dead_patterns_of_a_broken_bus_are_refused():
    for message in MESSAGES:
        for octet in (0x00, 0xFF, 0x55, 0xAA):
            assert isinstance(codec.unpack(message.can_id, bytes([octet]) * 8), codec.Rejection)
