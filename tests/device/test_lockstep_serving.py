"""Lockstep over a link: an antenna whose time waits for its host, with the bits of one in the host's own process."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from firmware_protocol.errors import LinkError
from firmware_protocol.links import AntennaInStep, CobsFraming, Link, StreamLink, UnixLink, memory_pair, pty_link
from firmware_protocol.links.descriptor import DescriptorPort
from firmware_protocol.links.serial_port import open_serial
from firmware_protocol.lockstep import BEGIN, EdgeParser, edge, next_edge
from firmware_protocol.schema import EDGE_BITS, RECORD_SIZE
from gimbal_hil.loop.host import Segment, program_of
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.lockstep import FramePath
from sim_backend.device import Device
from sim_backend.model import shipped_model
from sim_backend.server import DeviceServer, LockstepServer
from tests.host.test_lockstep import SEGMENTS

pytestmark = pytest.mark.realtime
SETTINGS, MODEL = shipped_settings(), shipped_model()


def ends(kind: str, folder: Path) -> tuple[Link, Link]:
    """The antenna's and the host's end of a link."""
    if kind == "unix":
        antenna = UnixLink(folder / "antenna", listen=True)
        return antenna, UnixLink(folder / "antenna")
    if kind == "memory":
        return memory_pair()
    terminal_end, path = pty_link(CobsFraming())

    def port() -> DescriptorPort:
        return open_serial(path, 921_600)

    return terminal_end, StreamLink("serial", port, CobsFraming())


@contextmanager
def served(device: Device, link: Link) -> Iterator[LockstepServer]:
    server = LockstepServer(device, link)
    thread = threading.Thread(target=server.serve, daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.stop()
        thread.join(10.0)
        assert not thread.is_alive()
        link.close()


@pytest.mark.parametrize("kind", ["unix", "pty"])
@settings(max_examples=5, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(segments=st.lists(SEGMENTS, min_size=1, max_size=4), seed=st.integers(0, 2**31 - 1))
def test_any_program_leaves_the_bits_of_an_antenna_in_the_same_process(
    kind: str, segments: list[Segment], seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    far, near = ends(kind, tmp_path_factory.mktemp("link"))
    with served(Device(MODEL, seed=seed), far) as server:
        remote = FramePath(SETTINGS, MODEL).with_remote(AntennaInStep(near))
        own = FramePath(SETTINGS, MODEL, seed)
        for path in (remote, own):
            path.connect()
        one, other = (path.run(program_of(segments), most_ticks=1500) for path in (remote, own))
        assert one.log.tobytes() == other.log.tobytes() and one.events == other.events
        assert server.device.X.tobytes() == own.device.X.tobytes()
        assert server.statistics.ticks_by_set_point == own.tick
        near.close()


@pytest.mark.parametrize("kind", ["unix", "pty"])
def test_time_stands_still_without_a_host_and_goes_on_with_the_next(kind: str, tmp_path: Path) -> None:
    far, near = ends(kind, tmp_path)
    device, twin = Device(MODEL, seed=3), Device(MODEL, seed=3)
    with served(device, far):
        first = AntennaInStep(near)
        assert [first.tick() for _ in range(5)] == [twin.tick() for _ in range(5)]
        time.sleep(0.2)
        assert device.ticks == 5
        # one that died within a tick, and what it left on the line
        near.send(edge(17) + edge(6))
        second = AntennaInStep(near)
        twin.tick()
        assert [second.tick() for _ in range(5)] == [twin.tick() for _ in range(5)]
        near.close()


def test_an_antenna_with_a_clock_of_its_own_is_told_from_one_in_lockstep() -> None:
    far, near = memory_pair()
    server = DeviceServer(Device(MODEL), far)
    thread = threading.Thread(target=server.serve, daemon=True)
    thread.start()
    with pytest.raises(LinkError, match="speaks without being asked"):
        AntennaInStep(near)
    server.stop()
    thread.join(10.0)


def test_an_answer_that_does_not_come_is_told_within_the_patience_and_at_once_after_a_hurry(tmp_path: Path) -> None:
    far, near = ends("unix", tmp_path)
    with pytest.raises(LinkError, match="no answer in lockstep"):
        AntennaInStep(near, patience_s=0.2)
    with served(Device(MODEL), far) as server:
        antenna = AntennaInStep(near, patience_s=0.2)
        server.stop()
        time.sleep(0.2)
        with pytest.raises(LinkError, match="no answer to tick 1 for"):
            antenna.tick()
    far, near = ends("memory", tmp_path)
    with served(Device(MODEL), far) as server:
        antenna = AntennaInStep(near, patience_s=0.0)
        server.stop()
        time.sleep(0.2)
        antenna.hurry()
        with pytest.raises(LinkError, match="no answer to tick 1 for 1 s"):
            antenna.tick()


RECORDS = st.binary(min_size=0, max_size=40).map(lambda octets: octets[: len(octets) - len(octets) % RECORD_SIZE])


@given(st.lists(RECORDS, min_size=1, max_size=6), st.integers(1, 2**EDGE_BITS - 1), st.integers(1, 30))
def test_blocks_come_out_as_they_went_in_however_they_are_cut(blocks: list[bytes], first: int, size: int) -> None:
    number, sent = first, b""
    for block in blocks:
        sent += block + edge(number)
        number = next_edge(number)
    parser, got, number = EdgeParser(), [], first
    for at in range(0, len(sent), size * RECORD_SIZE):
        parser.feed(sent[at : at + size * RECORD_SIZE])
        while (block := parser.before(number)) is not None:
            got.append(block)
            number = next_edge(number)
    assert got == blocks and parser.kept == 0


def test_the_number_of_an_edge_never_becomes_that_which_begins() -> None:
    assert next_edge(BEGIN) == 1 and next_edge(2**EDGE_BITS - 1) == 1
    # bytes that look like an edge across two records are none
    parser = EdgeParser()
    parser.feed(b"\0" * 5 + edge(1) + b"\0" * 5)
    assert parser.before(1) is None
