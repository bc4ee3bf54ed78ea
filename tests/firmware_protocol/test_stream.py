"""Serial framing: what goes in comes out, and nothing else ever does."""

from __future__ import annotations

import itertools
from binascii import crc_hqx

from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.messages import SetPoint
from firmware_protocol.schema import Direction
from firmware_protocol.stream import PACKET_FRAMES, PACKET_LIMIT, StreamParser, encode_packets
from tests.endpoints import Receiver, Sender

blocks = st.integers(1, 12).flatmap(lambda frames: st.binary(min_size=10 * frames, max_size=10 * frames))


def fed_in_pieces(parser: StreamParser, stream: bytes, cuts: list[int]) -> bytes:
    edges = [0, *sorted(cut % (len(stream) + 1) for cut in cuts), len(stream)]
    return b"".join(parser.feed(stream[start:end]) for start, end in itertools.pairwise(edges))


def test_the_crc_is_ccitt_false():
    assert crc_hqx(b"123456789", 0xFFFF) == 0x29B1


@given(st.binary(max_size=400))
def test_no_bytes_make_the_parser_raise(octets):
    assert isinstance(StreamParser().feed(octets + b"\0"), bytes)


@given(st.lists(blocks, max_size=8), st.lists(st.integers(0, 10**6), max_size=20))
def test_blocks_come_out_whole_however_the_stream_is_cut(sent, cuts):
    parser = StreamParser()
    stream = b"".join(map(encode_packets, sent))
    assert fed_in_pieces(parser, stream, cuts) == b"".join(sent)
    assert parser.counts.bad == 0


def test_a_long_block_goes_out_in_several_packets_within_the_limit():
    block = bytes(range(250)) * 40
    stream = encode_packets(block)
    assert all(len(packet) <= PACKET_LIMIT for packet in stream.split(b"\0"))
    assert len(block) > PACKET_FRAMES * 10
    assert StreamParser().feed(stream) == block


@given(
    st.lists(st.tuples(st.booleans(), blocks, st.binary(max_size=60)), max_size=10),
    st.lists(st.integers(0, 10**6), max_size=20),
)
@settings(max_examples=300)
def test_valid_packets_in_garbage_come_out_and_nothing_else_does(story, cuts):
    """Oracle: garbage that ends in a delimiter costs nothing; garbage right before a packet costs that packet, and only
    it.
    """
    stream, expected = b"", b""
    for delimited, block, garbage in story:
        stream += garbage + (b"\0" if delimited else b"") + encode_packets(block)
        if delimited or not garbage or garbage.endswith(b"\0"):
            expected += block
    assert fed_in_pieces(StreamParser(), stream, cuts) == expected


@given(st.lists(st.binary(max_size=700), max_size=30))
def test_any_bytes_never_raise_and_never_fill_memory(pieces):
    parser = StreamParser()
    for piece in pieces:
        parser.feed(piece)
        assert len(parser._partial) <= PACKET_LIMIT


def test_the_next_delimiter_after_a_flood_without_one_sets_it_right():
    parser, block = StreamParser(), bytes(10)
    for _ in range(50):
        assert parser.feed(b"\x07" * 1000) == b""
    assert parser.counts.too_long == 1
    assert parser.feed(b"\0" + encode_packets(block)) == block


@given(blocks, st.integers(0, 10**6), st.integers(1, 255))
@settings(max_examples=300)
def test_a_byte_changed_inside_a_packet_drops_that_packet_alone(block, where, change):
    parser, packet = StreamParser(), bytearray(encode_packets(block))
    packet[where % (len(packet) - 1)] ^= change
    parser.feed(bytes(packet))
    assert parser.counts.packets == 0
    assert parser.feed(encode_packets(block)) == block


@given(
    st.lists(st.tuples(st.integers(0, 10**9), st.integers(0, 7)), max_size=12),
    st.lists(st.integers(0, 10**6), max_size=8),
)
@settings(max_examples=300, deadline=None)
def test_bits_flipped_anywhere_in_the_stream_cost_frames_and_never_yield_a_value_that_was_not_sent(flips, cuts):
    sender, sent = Sender(), [SetPoint(0.125 * number, -0.25 * number, number, True, False) for number in range(30)]
    stream = bytearray(b"".join(encode_packets(sender.encode(message)) for message in sent))
    for place, bit in flips:
        stream[place % len(stream)] ^= 1 << bit
    received = Receiver(Direction.HOST_TO_DEVICE).receive(fed_in_pieces(StreamParser(), bytes(stream), cuts))
    assert all(sent[message.sequence] == message for message in received)
    # one flip spoils the packet that it is in, or two when it made or removed a delimiter
    assert len(received) >= len(sent) - 2 * len(flips)
