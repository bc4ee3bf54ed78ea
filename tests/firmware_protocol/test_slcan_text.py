"""Lines of slcan: every frame comes back from its line, and no line upsets whoever reads it."""

from __future__ import annotations

import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.codec import record
from firmware_protocol.links import CanFrame
from firmware_protocol.links.descriptor import DescriptorPort
from firmware_protocol.links.slcan_port import SlcanPort
from firmware_protocol.links.slcan_text import frame_of, line_of, lines_of, record_of

LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)


@st.composite
def frames(draw: st.DrawFn) -> CanFrame:
    extended, fd = draw(st.booleans()), draw(st.booleans())
    size = draw(st.sampled_from(LENGTHS if fd else LENGTHS[:9]))
    identifier = draw(st.integers(0, 2**29 - 1 if extended else 2**11 - 1))
    return CanFrame(identifier, draw(st.binary(min_size=size, max_size=size)), extended, fd)


@given(frames(), st.sampled_from([b"", b"00FF", b"beef"]))
def test_a_frame_comes_back_from_its_line_with_or_without_a_time_stamp(frame, stamp):
    line = line_of(frame).removesuffix(b"\r")
    assert frame_of(line + stamp) == frame
    assert frame_of(line[:1] + line[1:].lower()) == frame


@given(st.binary(max_size=200))
def test_no_line_raises(line):
    frame_of(line)
    record_of(line)


@given(frames(), st.integers(1, 20))
def test_a_line_that_lost_its_end_is_no_frame_of_another_length(frame, lost):
    line = line_of(frame).removesuffix(b"\r")
    cut = frame_of(line[:-lost])
    # a cut that leaves a whole frame: none, because the length is said at the head
    assert cut is None


@pytest.mark.parametrize(
    "line",
    [b"t1238zz", b"t8001AA", b"T200000001AA", b"t1239" + 18 * b"A", b"r1230", b"\xff", b"t123", b"t_121AA"],
)
def test_what_is_no_data_frame_is_none(line):
    assert frame_of(line) is None


@pytest.mark.parametrize("frame", [CanFrame(1, bytes(9)), CanFrame(1, bytes(12)), CanFrame(1, bytes(63), fd=True)])
def test_a_length_that_no_frame_has_is_refused(frame):
    with pytest.raises(ValueError, match=r"tuple\.index|expected 8 at most"):
        line_of(frame)


@given(st.lists(st.sampled_from([b"z\r", b"Z\r", b"\r", b"\a", b"t1\xff\r"]), max_size=6), st.integers(1, 40))
def test_acknowledgements_and_bells_hide_no_frame_wherever_the_stream_is_cut(noise, size):
    ours, theirs = os.pipe()
    sink, port = os.open(os.devnull, os.O_WRONLY), SlcanPort(DescriptorPort(ours, lambda: os.close(ours)))
    block = record(0x123, bytes(range(8)))
    stream, found = b"".join(noise) + lines_of(block), []
    for at in range(0, len(stream), size):
        os.write(theirs, stream[at : at + size])
        found += port.receive()
    assert [record_of(line) for line in found if record_of(line)] == [block]
    assert len(found) == 1 + noise.count(b"t1\xff\r")
    assert port.refused == noise.count(b"\a")
    port.close()
    os.close(theirs)
    os.close(sink)
