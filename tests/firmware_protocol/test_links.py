"""Every link carries blocks both ways, tells of a lost peer by its state, and never waits on a peer that does not
read.
"""

from __future__ import annotations

import errno
import fcntl
import itertools
import os
import socket
import sys
import termios
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from firmware_protocol.enumerations import BrakeCommand, DriveRequest, StopReaction
from firmware_protocol.errors import BadInputError, LinkError
from firmware_protocol.links import (
    CanLink,
    CobsFraming,
    Link,
    LinkConfig,
    LinkState,
    SlcanDevice,
    StreamLink,
    UnixLink,
    UnixListener,
    memory_pair,
    pty_link,
    require_link_carries,
)
from firmware_protocol.links.descriptor import DescriptorPort
from firmware_protocol.messages import DriveControl, FeedbackOuter, SetPoint
from firmware_protocol.opening import open_link
from firmware_protocol.schema import Direction
from tests.endpoints import Receiver, Sender

pytestmark = pytest.mark.realtime

CONFIG = TypeAdapter(LinkConfig)
CHANNELS = itertools.count()
Pair = tuple[Link, Link]


def opened(**config: object) -> Link:
    return open_link(CONFIG.validate_python(config))


def memory_links(_: Path, __: ExitStack) -> Pair:
    return memory_pair()


def serial_links(_: Path, __: ExitStack) -> Pair:
    device, path = pty_link()
    return opened(kind="serial", port=path), device


def slcan_links(_: Path, __: ExitStack) -> Pair:
    device, path = pty_link(SlcanDevice())
    host = opened(kind="can", interface="slcan", channel=path)
    device.receive()
    return host, device


def virtual_can_links(_: Path, __: ExitStack) -> Pair:
    channel = f"test {next(CHANNELS)}"
    return opened(kind="can", interface="virtual", channel=channel), opened(
        kind="can", interface="virtual", channel=channel
    )


def unix_links(folder: Path, _: ExitStack) -> Pair:
    device = opened(kind="unix", path=folder / "antenna", listen=True)
    host = opened(kind="unix", path=folder / "antenna")
    device.receive()
    return host, device


def tcp_links(_: Path, stack: ExitStack) -> Pair:
    listener = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
    host = opened(kind="serial", port=f"socket://127.0.0.1:{listener.getsockname()[1]}")
    peer, _address = listener.accept()
    listener.close()
    return host, StreamLink("device", lambda: DescriptorPort(peer.fileno(), peer.close), CobsFraming())


MAKERS = [memory_links, serial_links, slcan_links, virtual_can_links, unix_links, tcp_links]


@pytest.fixture(params=MAKERS, ids=lambda maker: maker.__name__)
def pair(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Pair]:
    maker: Callable[[Path, ExitStack], Pair] = request.param
    with ExitStack() as stack:
        near, far = maker(tmp_path, stack)
        yield near, far
        near.close()
        far.close()


def set_points(count: int) -> bytes:
    return Sender().encode(
        *[SetPoint(0.001 * number, -0.002 * number, number % 1024, True, False) for number in range(count)]
    )


def received(link: Link, size: int) -> bytes:
    block = b""
    for _ in range(100):
        block += link.receive()
        if len(block) >= size:
            break
        link.wait(20_000_000)
    return block


def test_blocks_pass_both_ways_unchanged(pair):
    host, device = pair
    down, up = set_points(5), Sender().encode(FeedbackOuter(1.0, -2.0), FeedbackOuter(1.1, -2.1))
    host.send(down)
    assert received(device, len(down)) == down
    device.send(up)
    assert received(host, len(up)) == up
    assert (host.statistics.frames_sent, host.statistics.frames_received) == (5, 2)
    assert (device.statistics.frames_sent, device.statistics.frames_received) == (2, 5)
    assert host.state is device.state is LinkState.OPEN


def test_receiving_from_a_silent_peer_gives_nothing_at_once_and_waiting_ends(pair):
    host, _ = pair
    assert host.receive() == b""
    assert host.wait(1_000_000) is False
    assert host.receive() == b""


def test_waiting_ends_early_when_something_has_come_and_loses_nothing(pair):
    host, device = pair
    block = set_points(1)
    host.send(block)
    assert device.wait(2_000_000_000) is True
    assert received(device, len(block)) == block


def test_a_peer_that_never_reads_costs_counted_frames_and_no_waiting(pair):
    host, device = pair
    if isinstance(host, CanLink) and "virtual" in host.name:
        pytest.skip("python-can's virtual bus has no bound")
    block = set_points(40)
    counts, sent = host.statistics, 0
    while counts.frames_dropped == 0 and sent < 20_000:
        host.send(block)
        sent += 1
    assert counts.frames_sent + counts.frames_dropped == sent * 40
    assert counts.frames_dropped > 0
    assert host.state is LinkState.OPEN
    while device.receive():
        pass
    for _ in range(3):  # what was in the backlog goes first
        host.send(b"" if isinstance(host, UnixLink) else set_points(1))
        device.wait(10_000_000)
        device.receive()
    request = (
        DriveRequest.SHUTDOWN,
        False,
        False,
        False,
        StopReaction.COAST,
        BrakeCommand.AUTOMATIC,
        BrakeCommand.AUTOMATIC,
        False,
    )
    fresh = Sender().encode(DriveControl(*request))
    host.send(fresh)
    assert received(device, len(fresh)).endswith(fresh)


def test_a_peer_that_goes_away_is_a_state_and_an_event_not_an_exception(pair):
    host, device = pair
    if isinstance(host, CanLink) and "virtual" in host.name:
        pytest.skip("a bus does not know its nodes")
    device.close()
    for _ in range(20):
        host.send(set_points(1))
        host.receive()
        if host.state is not LinkState.OPEN:
            break
        time.sleep(0.01)
    assert host.state is LinkState.LOST
    assert host.loss is not None and host.loss.link == host.name and host.loss.reason
    assert host.statistics.losses == 1
    host.send(set_points(2))
    assert host.receive() == b"" and host.wait(1000) is False
    assert host.reopen() is False and host.state is LinkState.LOST
    assert host.statistics.frames_dropped >= 2


def test_closing_twice_is_harmless_and_a_closed_link_is_silent(pair):
    host, _ = pair
    host.close()
    host.close()
    host.send(set_points(1))
    assert host.receive() == b"" and host.state is LinkState.CLOSED


def test_the_codec_reads_through_every_link(pair):
    host, device = pair
    receiver = Receiver(Direction.HOST_TO_DEVICE)
    sent = [SetPoint(0.125, -0.25, number, True, True) for number in range(20)]
    sender = Sender()
    for message in sent:
        host.send(sender.encode(message))
    assert receiver.receive(received(device, 200)) == sent


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ({"kind": "serial", "port": "/dev/no such port"}, "link.port: /dev/no such port: no such port; expected"),
        ({"kind": "serial", "port": "socket://127.0.0.1:9"}, "nobody listens there"),
        ({"kind": "serial", "port": "socket://nowhere"}, "host or port number missing"),
        ({"kind": "unix", "path": "no such socket"}, "no such socket"),
        ({"kind": "can", "interface": "slcan", "channel": "/dev/no such port"}, "can slcan /dev/no such port"),
        ({"kind": "can", "interface": "no such interface", "channel": "x"}, "expected an interface"),
        ({"kind": "can", "interface": "socketcan", "channel": "no_such_can"}, "can socketcan no_such_can"),
    ],
)
def test_a_port_that_is_not_there_is_one_clear_line(config, words):
    with pytest.raises(LinkError, match="link") as caught:
        opened(**config)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_a_busy_port_says_so():
    device, path = pty_link()
    first = opened(kind="serial", port=path)
    with pytest.raises(LinkError, match="busy"):
        opened(kind="serial", port=path)
    first.close()
    device.close()


def test_a_socket_path_that_is_served_is_busy_and_a_stale_one_is_taken_over(tmp_path):
    path = tmp_path / "antenna"
    first = UnixLink(path, listen=True)
    with pytest.raises(LinkError, match="busy"):
        UnixLink(path, listen=True)
    first.close()
    left_behind = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    left_behind.bind(str(path))
    left_behind.close()
    second = UnixLink(path, listen=True)
    assert second.state is LinkState.WAITING
    assert path.stat().st_mode & 0o077 == 0
    second.close()
    assert not path.exists()


@pytest.mark.parametrize(("where", "name"), [(socket, "socket"), (Path, "chmod"), (socket.socket, "listen")])
def test_a_listener_that_cannot_be_made_leaves_nothing_behind(tmp_path, monkeypatch, where, name):
    def refused(*_: object, **__: object) -> None:
        raise OSError(errno.EMFILE, "refused")

    path = tmp_path / "antenna"
    with monkeypatch.context() as broken:
        broken.setattr(where, name, refused)
        with pytest.raises(OSError, match="refused"):
            UnixListener(path)
    assert list(tmp_path.iterdir()) == []
    UnixListener(path).close()


def test_a_unix_listener_serves_the_next_host_when_one_has_gone(tmp_path):
    device = UnixLink(tmp_path / "antenna", listen=True)
    for _ in range(3):
        host = UnixLink(tmp_path / "antenna")
        host.send(set_points(1))
        assert received(device, 10) == set_points(1)
        host.close()
        device.receive()
        assert device.state is LinkState.WAITING and device.loss is not None
    assert device.statistics.losses == 3
    device.close()


def test_a_serial_link_comes_back_when_the_antenna_is_started_again_under_the_same_name(tmp_path):
    name = tmp_path / "antenna"
    device, _ = pty_link(symlink=name)
    host = opened(kind="serial", port=str(name))
    device.close()
    assert not name.exists()
    host.receive()
    assert host.state is LinkState.LOST and host.reopen() is False
    device, _ = pty_link(symlink=name)
    assert host.reopen() is True
    host.send(set_points(3))
    assert received(device, 30) == set_points(3)
    assert host.statistics.reopened == 1
    host.close()
    device.close()


def test_an_slcan_link_comes_back_when_the_adapter_is_plugged_in_again(tmp_path):
    name = tmp_path / "adapter"
    device, _ = pty_link(SlcanDevice(), symlink=name)
    host = opened(kind="can", interface="slcan", channel=str(name))
    device.receive()
    device.close()
    host.receive()
    assert host.state is LinkState.LOST
    device, _ = pty_link(SlcanDevice(), symlink=name)
    assert host.reopen() is True
    device.receive()
    device.send(set_points(2))
    assert received(host, 20) == set_points(2)
    host.close()
    device.close()


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="counts descriptors in /proc")
@pytest.mark.parametrize("kind", ["serial", "slcan", "unix"])
def test_many_reconnections_leave_no_descriptor_open(kind, tmp_path):
    name = tmp_path / "antenna"

    def antenna() -> Link:
        if kind == "unix":
            return UnixLink(name, listen=True)
        return pty_link(SlcanDevice() if kind == "slcan" else None, symlink=name)[0]

    config = {
        "serial": {"kind": "serial", "port": str(name)},
        "slcan": {"kind": "can", "interface": "slcan", "channel": str(name)},
        "unix": {"kind": "unix", "path": name},
    }
    device = antenna()
    host = opened(**config[kind])
    open_before = len(os.listdir("/proc/self/fd"))
    for _ in range(10):
        device.receive()
        device.close()
        host.receive()
        assert host.state is LinkState.LOST and host.reopen() is False
        device = antenna()
        assert host.reopen() is True
    assert len(os.listdir("/proc/self/fd")) <= open_before + 1
    host.close()
    device.close()


def test_a_symlink_never_replaces_a_file(tmp_path):
    name = tmp_path / "notes"
    name.write_text("mine")
    with pytest.raises(LinkError, match="symbolic link"):
        pty_link(symlink=name)
    assert name.read_text() == "mine"


def test_garbage_on_an_slcan_line_is_counted_and_the_next_frame_comes_through():
    device, path = pty_link(SlcanDevice())
    host = opened(kind="can", interface="slcan", channel=path)
    device.receive()
    os.write(device.fileno(), b"t02\xff8\r\x00\x01t\rt0208ZZ\rT000\rt020A00\r" + b"t" * 500 + b"\r\a")
    device.send(set_points(1))
    assert received(host, 10).endswith(set_points(1))
    assert host.statistics.malformed > 0 and host.state is LinkState.OPEN
    host.close()
    device.close()


def wait_until_all_is_there(descriptor: int) -> None:
    """Until octets are there and no more come: a terminal may hand on in pieces what was written at once."""
    there, before, deadline = 0, -1, time.monotonic() + 10.0
    while (there == 0 or there != before) and time.monotonic() < deadline:
        time.sleep(0.05)
        before, there = there, int.from_bytes(fcntl.ioctl(descriptor, termios.FIONREAD, bytes(4)), sys.byteorder)
    assert there > 0


@pytest.mark.parametrize("kind", ["serial", "slcan"])
def test_a_block_is_written_at_once_and_read_at_once(kind, monkeypatch):
    device, path = pty_link(SlcanDevice() if kind == "slcan" else None)
    host = opened(kind="serial", port=path) if kind == "serial" else opened(kind="can", interface="slcan", channel=path)
    device.receive()
    device.send(set_points(5))
    wait_until_all_is_there(host.fileno())
    calls = []
    for name in ("read", "write"):
        ask = getattr(os, name)
        monkeypatch.setattr(os, name, lambda *given, name=name, ask=ask: calls.append(name) or ask(*given))
    host.send(set_points(2))
    assert calls == ["write"]
    assert host.receive() == set_points(5)
    assert calls == ["write", "read"]
    host.close()
    device.close()


@pytest.mark.parametrize("kind", ["serial", "slcan"])
def test_any_bytes_on_a_line_never_raise_and_the_next_frame_comes_through(kind):
    device, path = pty_link(SlcanDevice() if kind == "slcan" else None)
    host = opened(kind="serial", port=path) if kind == "serial" else opened(kind="can", interface="slcan", channel=path)
    device.receive()
    receiver, sender = Receiver(Direction.DEVICE_TO_HOST), Sender()
    end_of_garbage = b"\r" if kind == "slcan" else b"\0"

    @given(st.lists(st.binary(max_size=200), max_size=5))
    @settings(max_examples=60, deadline=None)
    def fuzz(pieces: list[bytes]) -> None:
        for piece in pieces:
            os.write(device.fileno(), piece)
            receiver.receive(host.receive())
        os.write(device.fileno(), end_of_garbage)
        message = FeedbackOuter(0.0, 0.0)
        device.send(sender.encode(message))
        assert message in receiver.receive(received(host, 10))
        assert host.state is LinkState.OPEN

    fuzz()
    host.close()
    device.close()


def test_foreign_frames_on_a_can_bus_are_counted_and_left_out():
    import can

    channel = f"test {next(CHANNELS)}"
    host = opened(kind="can", interface="virtual", channel=channel)
    with can.Bus(interface="virtual", channel=channel) as other:
        other.send(can.Message(arbitration_id=0x20, data=bytes(7), is_extended_id=False))
        other.send(can.Message(arbitration_id=0x20, data=bytes(8), is_extended_id=True))
        other.send(can.Message(arbitration_id=0x20, dlc=8, is_remote_frame=True, is_extended_id=False))
        other.send(can.Message(arbitration_id=0x20, data=bytes(8), is_fd=True, is_extended_id=False))
        other.send(can.Message(arbitration_id=0x7FF, data=bytes(range(8)), is_extended_id=False))
    assert host.receive() == b"\xff\x07" + bytes(range(8))
    assert host.statistics.malformed == 4
    host.close()


def test_configuration_names_the_key_that_is_wrong():
    with pytest.raises(ValidationError, match="baud"):
        CONFIG.validate_python({"kind": "serial", "port": "x", "baud": 9600})
    with pytest.raises(ValidationError, match="kind"):
        CONFIG.validate_python({"kind": "carrier pigeon"})


def test_a_rate_that_the_line_cannot_carry_is_refused_with_the_highest_that_it_can():
    slow_bus = CONFIG.validate_python({"kind": "can", "interface": "virtual", "channel": "x", "bitrate": 500_000})
    with pytest.raises(BadInputError, match="at most 502 Hz"):
        require_link_carries(slow_bus, 1000.0, "daemon.yaml: rate_hz")
    slow_line = CONFIG.validate_python({"kind": "serial", "port": "x", "baudrate": 115_200})
    with pytest.raises(BadInputError, match="at most"):
        require_link_carries(slow_line, 1000.0, "daemon.yaml: rate_hz")
    require_link_carries(CONFIG.validate_python({"kind": "memory"}), 1e6, "daemon.yaml: rate_hz")
