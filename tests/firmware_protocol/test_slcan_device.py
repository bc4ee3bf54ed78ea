"""The adapter's side of slcan: hosts are answered as the protocol says, and no line upsets it."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.codec import record
from firmware_protocol.links import SlcanDevice


def opened() -> SlcanDevice:
    device = SlcanDevice()
    assert device.feed(b"S8\rO\r") == b"" and device.answer() == b"\r\r"
    return device


def test_frames_pass_only_while_the_channel_is_open():
    device, block = SlcanDevice(), record(0x123, bytes(range(8)))
    assert device.encode(block) == b""
    assert device.feed(b"t12380001020304050607\r") == b"" and device.answer() == b"\a"
    device = opened()
    assert device.encode(block) == b"t12380001020304050607\r"
    assert device.feed(b"t12380001020304050607\r") == block and device.answer() == b"z\r"
    device.feed(b"C\r")
    assert device.encode(block) == b""


@given(st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(min_size=8, max_size=8)), max_size=6), st.integers(1, 30))
def test_what_it_writes_it_reads(frames, size):
    block = b"".join(record(*frame) for frame in frames)
    text = opened().encode(block)
    reader = opened()
    assert b"".join(reader.feed(text[at : at + size]) for at in range(0, len(text), size)) == block


def test_questions_are_answered_and_unknown_commands_refused():
    device = opened()
    device.feed(b"V\rN\rF\rO\r?\r")
    assert device.answer() == b"V1013\rNGHIL\rF00\r\a\a"


@given(st.lists(st.binary(max_size=80), max_size=20))
def test_any_bytes_never_raise_and_give_whole_records_or_nothing(pieces):
    device = opened()
    for piece in pieces:
        assert len(device.feed(piece)) % 10 == 0
    device.answer()
    device.reset()
    assert device.encode(bytes(10)) == b""


def test_frames_of_another_kind_are_refused():
    device = opened()
    short, extended, remote = b"t1234000102", b"T0000012380001020304050607", b"r1238"
    no_length, half_byte, negative, odd = (
        b"t12G8" + b"00" * 8,
        b"t12380001020304050",
        b"t-128" + b"00" * 8,
        b"t1_28" + b"00" * 8,
    )
    lines = [short, extended, remote, no_length, half_byte, negative, odd]
    assert device.feed(b"\r".join(lines) + b"\r") == b""
    assert device.answer() == b"\a" * 7
    assert device.malformed == 5
