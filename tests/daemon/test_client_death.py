"""Whatever becomes of a client whose motion is under way, the axes come to rest: commands by signals by phases."""

from __future__ import annotations

import contextlib
import os
import pty
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from gimbal_hil.data.runs import open_run
from gimbal_hil.realtime.operator import OperatorClient
from tests.daemon.daemons import TICKING_PATIENCE_S, RunningDaemon

pytestmark = pytest.mark.realtime

Json = dict[str, Any]
#: the shipped lease and, behind it, the longest stop; the client dies between two looks
LEASE_TICKS, STOP_TICKS, LOOK_TICKS = 3000, 5000, 500
_SCRIPT = """
import sys, time
from pathlib import Path
from gimbal_hil.loop.host import AxisCommand, Mode, Segment, program_of
from gimbal_hil.realtime.operator import OperatorClient
with OperatorClient(Path(sys.argv[1])) as client:
    client.start(program_of([Segment(AxisCommand(Mode.RATE, parameters=(0.1,)), AxisCommand(Mode.RATE))]))
    time.sleep(600)
"""
_MAIN = "from gimbal_hil.surface.cli import main; main()"


def words_of(command: str, run: Path, out: Path) -> list[str]:
    """The command line of a client that moves the antenna."""
    if command == "script":
        return [sys.executable, "-c", _SCRIPT, str(run)]
    given = {
        "experiment": ["experiment", "sliding", "--run", str(run), "--out", str(out), "--short"],
        "point": ["point", "--target", "azel:30,40", "--duration", "600", "--run", str(run), "--out", str(out)],
        "improve": ["improve", "--run", str(run), "--out", str(out), "--short", "--workers", "1"],
        "set": ["set", "outer=0.1", "--mode", "rate", "--attended", "--run", str(run)],
    }
    return [sys.executable, "-c", _MAIN, *given[command]]


class Clients:
    """Starts clients on one daemon; `tick` and `state` are the daemon's own words."""

    def __init__(self, daemon: RunningDaemon, folder: Path) -> None:
        self.daemon, self._folder, self._count = daemon, folder, 0
        self._watch: OperatorClient = daemon.client()

    def status(self) -> Json:
        status: Json = self._watch.request("status")["status"]
        return status

    def until(self, state: str) -> int:
        end = time.monotonic() + TICKING_PATIENCE_S
        while (status := self.status())["host_state"] != state:
            assert time.monotonic() < end, status
            time.sleep(0.02)
        return int(status["tick"])

    @contextlib.contextmanager
    def client(self, command: str) -> Iterator[tuple[subprocess.Popen[bytes], int]]:
        """A client in a terminal of its own; its process and the terminal's other end."""
        self.until("idle")
        self._count += 1
        words = words_of(command, self.daemon.run, self._folder / f"out_{self._count}")
        keyboard, screen = pty.openpty()
        # a session and a terminal of its own, with the process id of the client itself; whoever runs the tests in the
        # background or under nohup would hand on that SIGINT and SIGHUP are to be ignored
        prefix = ["env", "--default-signal=INT,HUP,TERM", "setsid", "--ctty"]
        process = subprocess.Popen([*prefix, *words], stdin=screen, stdout=screen, stderr=screen)
        os.close(screen)
        try:
            yield process, keyboard
        finally:
            for number in (signal.SIGCONT, signal.SIGKILL):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(process.pid, number)
            process.wait()
            with contextlib.suppress(OSError):
                os.close(keyboard)

    def close(self) -> None:
        self._watch.close()


@pytest.fixture(scope="module")
def clients(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Clients]:
    folder = tmp_path_factory.mktemp("clients")
    with RunningDaemon(folder / "run") as daemon:
        found = Clients(daemon, folder)
        try:
            yield found
        finally:
            found.close()


def comes_to_rest(clients: Clients, command: str, death: str, after_s: float) -> None:
    """The daemon is at rest within lease and stop, counted in its own ticks, and its log says why."""
    with clients.client(command) as (process, keyboard):
        clients.until("active")
        time.sleep(after_s)
        before = int(clients.status()["tick"])
        if death == "terminal":
            os.close(keyboard)
        else:
            os.kill(process.pid, getattr(signal, death))
        at_rest = clients.until("idle")
    assert at_rest - before <= LEASE_TICKS + STOP_TICKS + LOOK_TICKS
    if death in ("SIGKILL", "SIGSTOP"):
        # whoever is asked to end may stop the axes by itself
        time.sleep(0.3)
        told = [e for e in open_run(clients.daemon.run).events if e.data.get("code") == "lease_ended"]
        last = told[-1]
        assert before <= last.tick <= at_rest
        wanted = "closed its connection" if death == "SIGKILL" else "said nothing for 3 s"
        assert last.data["reason"] == wanted


@pytest.mark.parametrize(("command", "death"), [("set", "SIGKILL"), ("script", "SIGSTOP"), ("set", "terminal")])
def test_the_antenna_comes_to_rest_when_its_client_dies(clients: Clients, command: str, death: str) -> None:
    comes_to_rest(clients, command, death, 0.2)


@pytest.mark.heavy
@pytest.mark.parametrize("after_s", [0.0, 1.0, 6.0])
@pytest.mark.parametrize("death", ["SIGINT", "SIGTERM", "SIGHUP", "SIGKILL", "SIGSTOP", "terminal"])
@pytest.mark.parametrize("command", ["experiment", "improve", "point", "set", "script"])
def test_the_antenna_comes_to_rest_in_every_phase(clients: Clients, command: str, death: str, after_s: float) -> None:
    comes_to_rest(clients, command, death, after_s)
