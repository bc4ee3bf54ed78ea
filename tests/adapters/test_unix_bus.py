"""The socket of simulated drives: one process serves it, and one that finds it taken is told so at once."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from firmware_protocol.adapters import CanFrame, UnixCanBus
from firmware_protocol.errors import LinkError
from firmware_protocol.links import LinkConfig
from firmware_protocol.opening import open_link

FRAME = CanFrame(0x123, b"\x01\x02")


def test_frames_go_both_ways_and_the_path_is_taken_away(tmp_path: Path) -> None:
    path = tmp_path / "drives"
    drives = UnixCanBus(path, listen=True)
    host = UnixCanBus(path)
    assert drives.receive() == []
    assert drives.send(FRAME) and host.receive() == [FRAME]
    assert host.send(FRAME) and drives.receive() == [FRAME]
    host.close()
    assert drives.receive() == [] and not drives.send(FRAME)
    drives.close()
    assert list(tmp_path.iterdir()) == []


def test_a_host_for_which_there_is_no_room_is_refused_and_does_not_wait(tmp_path: Path) -> None:
    path = tmp_path / "drives"
    with contextlib.ExitStack() as stack:
        stack.callback(UnixCanBus(path, listen=True).close)
        with pytest.raises(LinkError, match=r"link.channel: .* busy: another process is connected"):
            for _ in range(10):
                stack.callback(UnixCanBus(path).close)


@pytest.mark.parametrize("kind", ["adapter", "unix"])
def test_a_second_host_is_told_who_has_the_socket_instead_of_waiting_unheard(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "drives"
    adapter = {"kind": "adapter", "drive": "moteus", "interface": "unix", "channel": str(path), "rate_hz": 100.0}
    drives = [{"id": 1, "torque_nm": 1.0}, {"id": 2, "torque_nm": 1.0}]
    link = {"adapter": adapter | {"drives": drives, "name": "here"}, "unix": {"kind": "unix", "path": str(path)}}[kind]
    config = TypeAdapter[LinkConfig](LinkConfig).validate_python(link)
    with contextlib.closing(UnixCanBus(path, listen=True)):
        with (
            contextlib.closing(open_link(config)),
            pytest.raises(LinkError, match=f"busy: process {os.getpid()} .* has"),
        ):
            open_link(config)
        open_link(config).close()


def test_second_drives_do_not_take_the_socket_of_live_ones(tmp_path: Path) -> None:
    path = tmp_path / "drives"
    first = UnixCanBus(path, listen=True)
    with pytest.raises(LinkError, match=f"busy: process {os.getpid()} serves under this name"):
        UnixCanBus(path, listen=True)
    host = UnixCanBus(path)
    first.receive()
    assert first.send(FRAME) and host.receive() == [FRAME]
    host.close()
    first.close()


def test_a_path_without_drives_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LinkError, match="no such socket; expected a socket of simulated drives"):
        UnixCanBus(tmp_path / "drives")
