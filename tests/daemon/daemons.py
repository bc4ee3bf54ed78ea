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

from gimbal_hil.operator.client import OperatorClient

Json = dict[str, Any]
#: long enough for a cold compile on a busy machine; nothing asserts how long a thing took
PATIENCE_S = 300.0


class RunningDaemon:
    """`gimbal-hil daemon ...` until the block ends; `wait` gives its JSON answer and exit code."""

    def __init__(self, run: Path, *words: str) -> None:
        self.run = run
        self.process = subprocess.Popen(
            [
                sys.executable,
                "-c",
                "from gimbal_hil.cli import main; main()",
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
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            status: Json = client.request("status")["status"]
            if status["host_state"] in states:
                return status
            time.sleep(0.01)
        raise AssertionError(f"never in {states}, last {status['host_state']}")

    def service_pid(self) -> int:
        """Process id of its service process."""
        for path in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = path.read_bytes().split(b"\0")
                parent = int((path.parent / "stat").read_text().rsplit(")", 1)[1].split()[1])
            except OSError:
                continue
            if parent == self.process.pid and b"gimbal_hil.service" in words:
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
