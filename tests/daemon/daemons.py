"""Starting daemons for tests: the command as a user runs it, in a process of its own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import yaml

from gimbal_hil.loop.settings import shipped_settings_path
from gimbal_hil.realtime.operator.client import OperatorClient

Json = dict[str, Any]
#: long enough for a cold compile on a busy machine; nothing asserts how long a thing took
PATIENCE_S = 300.0
#: once the ticks run nothing is compiled any more
TICKING_PATIENCE_S = 60.0
#: a shared machine stalls for tens of milliseconds; how long a stall may be is the owner's choice
STALLS_ALLOWED: Json = {
    "lost_ticks": 100,
    "set_point_lag_ticks": 200,
    "deadman": {"window_ticks": 250, "reaction": "decelerate_and_hold"},
}


def patient_configuration(folder: Path, link: Json | None = None, **supervisor: object) -> Path:
    """The shipped configuration in `folder`, for tests in real time: host and antenna wait longer for each other than
    they should on an antenna. Without `link` the antenna is in the daemon's own process.
    """
    document = yaml.safe_load(shipped_settings_path().read_text())
    document["supervisor"] |= {**STALLS_ALLOWED, **supervisor}
    if link is not None:
        document["link"] = link
    path = folder / "daemon.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


class RunningDaemon:
    """`gimbal-hil daemon ...` until the block ends; `wait` gives its JSON answer and exit code.

    Without `--config` it is patient with the machine.
    """

    def __init__(self, run: Path, *words: str) -> None:
        self.run = run
        if "--config" not in words:
            words = (*words, "--config", str(patient_configuration(run.parent)))
        self.process = subprocess.Popen(
            [
                sys.executable,
                "-c",
                "from gimbal_hil.surface.cli import main; main()",
                "daemon",
                "--out",
                str(run),
                "--json",
                *words,
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def client(self) -> OperatorClient:
        """Connect as soon as the door is there."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            if self.process.poll() is not None:
                raise AssertionError(f"the daemon ended: {self.process.communicate()}")
            if (self.run / "operator.json").exists():
                return OperatorClient(self.run, timeout_s=30.0)
            time.sleep(0.02)
        raise AssertionError("the daemon did not open its door")

    def until_state(self, client: OperatorClient, *states: str) -> Json:
        """Wait for the host to be in one of the states; answers the status."""
        began, ticking = time.monotonic(), False
        while time.monotonic() - began < (TICKING_PATIENCE_S if ticking else PATIENCE_S):
            status: Json = client.request("status")["status"]
            if status["host_state"] in states:
                return status
            if status["tick"] > 0 and not ticking:
                began, ticking = time.monotonic(), True
            time.sleep(0.01)
        raise AssertionError(f"never in {states}, last {status['host_state']} ({status['cause']})")

    def service_pid(self) -> int:
        """Process id of its service process."""
        for path in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = path.read_bytes().split(b"\0")
                parent = int((path.parent / "stat").read_text().rsplit(")", 1)[1].split()[1])
            except OSError:
                continue
            if parent == self.process.pid and b"gimbal_hil.realtime.service" in words:
                return int(path.parent.name)
        raise AssertionError("no service process")

    def wait(self) -> tuple[int, Json, str]:
        """Exit code, JSON answer (empty when there was none) and what was printed for people."""
        out, err = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, json.loads(out) if out.strip() else {}, err

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.process.poll() is None:
            os.kill(self.process.pid, signal.SIGKILL)
            self.process.communicate()
