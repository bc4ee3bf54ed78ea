"""Every link carries blocks both ways, tells of a lost peer by its state, and never waits on a peer that does not
read.
"""

from __future__ import annotations

import itertools
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from firmware_protocol.enumerations import BrakeCommand, DriveRequest, StopReaction
from firmware_protocol.links import (
    CanLink,
    CobsFraming,
    Link,
    LinkState,
    SlcanDevice,
    StreamLink,
    UnixLink,
    memory_pair,
    pty_link,
)
from firmware_protocol.links.descriptor import DescriptorPort
from firmware_protocol.messages import DriveControl, FeedbackOuter, SetPoint
from firmware_protocol.schema import Direction
from tests.endpoints import Receiver, Sender
from tests.link_ends import opened, received, set_points

pytestmark = pytest.mark.realtime

CHANNELS = itertools.count()
Pair = tuple[Link, Link]


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
