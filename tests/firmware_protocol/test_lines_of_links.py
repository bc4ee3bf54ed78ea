"""What comes over a line: whole blocks at once, garbage and foreign frames counted, the next frame through."""

from __future__ import annotations

import fcntl
import os
import sys
import termios
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.links import (
    LinkState,
    SlcanDevice,
    pty_link,
)
from firmware_protocol.messages import FeedbackOuter
from firmware_protocol.schema import Direction
from tests.endpoints import Receiver, Sender
from tests.link_ends import opened, received, set_points

pytestmark = pytest.mark.realtime


def wait_until_all_is_there(descriptor: int) -> None:
    """Until octets are there and no more come: a terminal may hand on in pieces what was written at once."""
    there, before, deadline = 0, -1, time.monotonic() + 10.0
    while (there == 0 or there != before) and time.monotonic() < deadline:
        time.sleep(0.05)
        before, there = there, int.from_bytes(fcntl.ioctl(descriptor, termios.FIONREAD, bytes(4)), sys.byteorder)
    assert there > 0


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

    channel = "test foreign frames"
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
