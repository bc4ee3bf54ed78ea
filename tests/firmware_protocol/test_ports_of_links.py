"""Ports that are missing, busy, gone and back again; what a configuration of a link refuses."""

from __future__ import annotations

import errno
import os
import socket
from pathlib import Path

import pytest
from pydantic import ValidationError

from firmware_protocol.errors import BadInputError, LinkError
from firmware_protocol.links import (
    Link,
    LinkState,
    SlcanDevice,
    UnixLink,
    UnixListener,
    pty_link,
    require_link_carries,
)
from tests.link_ends import CONFIG, opened, received, set_points

pytestmark = pytest.mark.realtime


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
