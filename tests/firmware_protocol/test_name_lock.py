"""A name under which an antenna is served stays its own while it is served, and is free afterwards."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from firmware_protocol.errors import LinkError
from firmware_protocol.links import UnixLink, pty_link

pytestmark = pytest.mark.realtime


def test_a_second_terminal_does_not_take_the_name_of_a_live_one(tmp_path: Path) -> None:
    name = tmp_path / "antenna"
    first, path = pty_link(symlink=name)
    with pytest.raises(LinkError, match=f"process {os.getpid()} serves under this name"):
        pty_link(symlink=name)
    assert os.readlink(name) == path
    first.close()
    assert not name.exists() and list(tmp_path.iterdir()) == []
    second, other = pty_link(symlink=name)
    assert os.readlink(name) == other
    second.close()


def test_a_second_listener_does_not_take_the_socket_of_a_live_one(tmp_path: Path) -> None:
    path = tmp_path / "antenna"
    first = UnixLink(path, listen=True)
    with pytest.raises(LinkError, match="busy"):
        UnixLink(path, listen=True)
    host = UnixLink(path)
    host.close()
    first.close()
    assert list(tmp_path.iterdir()) == []
    UnixLink(path, listen=True).close()


def test_the_name_of_a_killed_process_is_free(tmp_path: Path) -> None:
    name = tmp_path / "antenna"
    script = (
        "import sys, time; from pathlib import Path; from firmware_protocol.links import pty_link\n"
        "link, _ = pty_link(symlink=Path(sys.argv[1])); print('ready', flush=True); time.sleep(60)"
    )
    root = Path(__file__).parents[2]
    holder = subprocess.Popen([sys.executable, "-c", script, str(name)], cwd=root, stdout=subprocess.PIPE)
    assert holder.stdout is not None and holder.stdout.readline() == b"ready\n"
    with pytest.raises(LinkError, match=f"process {holder.pid}"):
        pty_link(symlink=name)
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    holder.stdout.close()
    link, path = pty_link(symlink=name)
    assert os.readlink(name) == path
    link.close()


def test_a_folder_that_is_not_there_is_refused_in_words(tmp_path: Path) -> None:
    with pytest.raises(LinkError, match="expected a path in a folder"):
        pty_link(symlink=tmp_path / "none" / "antenna")
