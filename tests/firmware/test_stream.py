"""The C stream and the Python one find the same frames in the same bytes, and the codec of the header is that of
Python.
"""

from __future__ import annotations

import ctypes

from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.schema import RECORD_SIZE
from firmware_protocol.stream import PACKET_FRAMES, StreamParser, encode_packets
from sim_backend.firmware import BenchLibrary, HostBench, LibraryAntenna
from tests.device.bench import bench_model, control
from tests.endpoints import Sender

RECORDS = st.lists(st.binary(min_size=RECORD_SIZE, max_size=RECORD_SIZE), min_size=1, max_size=PACKET_FRAMES)


class Line:
    """The C stream, byte by byte, with every record that it takes."""

    def __init__(self, library: BenchLibrary) -> None:
        self.stream, self.packet = HostBench().stream, HostBench().packet
        loaded = library._library
        self._feed, self._add, self._end = (
            loaded.gimbal_stream_feed,
            loaded.gimbal_packet_add,
            loaded.gimbal_packet_end,
        )
        self._taken: list[bytes] = []
        kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_uint16, ctypes.POINTER(ctypes.c_uint8))
        self._take = kind(
            lambda _, identifier, payload: self._taken.append(identifier.to_bytes(2, "little") + bytes(payload[:8]))
        )

    def feed(self, octets: bytes) -> bytes:
        self._taken.clear()
        for octet in octets:
            self._feed(ctypes.byref(self.stream), ctypes.c_uint8(octet), self._take, None)
        return b"".join(self._taken)

    def encode(self, block: bytes) -> bytes:
        for at in range(0, len(block), RECORD_SIZE):
            identifier, payload = int.from_bytes(block[at : at + 2], "little"), block[at + 2 : at + 10]
            assert self._add(ctypes.byref(self.packet), ctypes.c_uint16(identifier), payload) & 1
        size = self._end(ctypes.byref(self.packet))
        return bytes(memoryview(self.packet.packet)[:size])

    @property
    def counts(self) -> tuple[int, ...]:
        s = self.stream
        return s.packets, s.bad_coding, s.bad_crc, s.bad_length, s.too_long


def counts_of(parser: StreamParser) -> tuple[int, ...]:
    c = parser.counts
    return c.packets, c.bad_coding, c.bad_crc, c.bad_length, c.too_long


@given(records=RECORDS)
def test_packets_are_the_same_bytes(library: BenchLibrary, records: list[bytes]) -> None:
    block = b"".join(records)
    line = Line(library)
    assert line.encode(block) == encode_packets(block)
    assert line.feed(line.encode(block)) == block and line.counts == (1, 0, 0, 0, 0)


def test_blocks_whose_runs_are_as_long_as_a_group_are_the_same_bytes(library: BenchLibrary) -> None:
    line = Line(library)
    for frames in range(1, PACKET_FRAMES + 1):
        for place in range(0, frames * RECORD_SIZE, 7):
            block = bytearray(b"\x55" * (frames * RECORD_SIZE))
            block[place] = 0
            assert line.encode(bytes(block)) == encode_packets(bytes(block))


def test_a_packet_takes_as_many_records_as_the_wire_allows(library: BenchLibrary) -> None:
    line, payload = Line(library), bytes(8)
    taken = [bool(line._add(ctypes.byref(line.packet), ctypes.c_uint16(1), payload) & 1) for _ in range(60)]
    assert taken == [True] * PACKET_FRAMES + [False] * (60 - PACKET_FRAMES)


@settings(max_examples=200)
@given(
    pieces=st.lists(
        st.one_of(
            st.binary(max_size=40),
            st.integers(1, 600).map(lambda n: b"\x11" * n),
            RECORDS.map(lambda records: encode_packets(b"".join(records))),
            st.tuples(RECORDS, st.integers(0, 10_000), st.integers(1, 255)).map(
                lambda t: _damaged(encode_packets(b"".join(t[0])), t[1], t[2])
            ),
            st.just(b"\0"),
        ),
        max_size=12,
    )
)
def test_any_bytes_are_read_alike(library: BenchLibrary, pieces: list[bytes]) -> None:
    line, parser = Line(library), StreamParser()
    for piece in pieces:
        # byte by byte, as a port hands them over: the Python parser counts a packet that is too long at its end else
        expected = b"".join(parser.feed(piece[at : at + 1]) for at in range(len(piece)))
        assert line.feed(piece) == expected
    assert line.counts == counts_of(parser)


def test_a_device_speaks_over_a_line_as_in_blocks(library: BenchLibrary) -> None:
    """The same session, once in blocks and once in packets with noise between them."""
    plain, lined = (LibraryAntenna(library, bench_model(), seed=1) for _ in range(2))
    sender, parser = Sender(), StreamParser()
    for k in range(200):
        block = sender.encode(control(identify=k % 20 == 0))
        lined.bench.supply = plain.bench.supply = 1400
        octets = b"\x07\x01\0" * (k % 3) + encode_packets(block)
        size = library.line_tick(lined.bench, octets, len(octets))
        assert parser.feed(bytes(memoryview(lined.bench.packet.packet)[:size])) == plain.tick(block)


def _damaged(packet: bytes, place: int, change: int) -> bytes:
    octets = bytearray(packet)
    octets[place % len(octets)] ^= change
    return bytes(octets)
