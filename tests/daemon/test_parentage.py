"""What a program starts for itself ends with it, though it was killed and could say nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from gimbal_hil.data.runs import open_run
from gimbal_hil.realtime.operator.client import OperatorClient

pytestmark = pytest.mark.realtime

PATIENCE_S = 300.0
DAEMON = """
import os, subprocess, sys, time
main = "from gimbal_hil.surface.cli import main; main()"
words = [sys.executable, "-c", main, "daemon", "--out", {run!r}, "--json", "--end-with", str(os.getpid())]
daemon = subprocess.Popen(words, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
print(daemon.pid, flush=True)
time.sleep(600)
"""
WORKERS = """
import time
from gimbal_hil.knowledge.executor import open_executor
import os
with open_executor(2) as executor:
    print(*{{executor.submit(os.getpid).result() for _ in range(20)}}, flush=True)
    time.sleep(600)
"""


def started(program: str) -> tuple[subprocess.Popen[str], list[int]]:
    """A program, and the process ids that it prints."""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout
    return process, [int(word) for word in process.stdout.readline().split()]


def until(condition: Callable[[], bool], what: str) -> None:
    """Wait for `condition()`."""
    end = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(what)
        time.sleep(0.05)


def gone(pid: int) -> bool:
    """Whether a process has ended (one that nobody has waited for is a zombie)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return True


linux = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="the kernel's word that a parent is gone is Linux's"
)


@linux
def test_a_daemon_ends_with_the_killed_program_that_started_it_and_its_log_says_so(tmp_path: Path) -> None:
    run = tmp_path / "run"
    program, (daemon,) = started(DAEMON.format(run=str(run)))
    until(lambda: (run / "operator.json").exists(), "the daemon did not open its door")
    with OperatorClient(run, timeout_s=PATIENCE_S) as client:
        until(lambda: client.request("status")["status"]["tick"] > 0, "the daemon does not tick")
    program.send_signal(signal.SIGKILL)
    program.communicate()
    until(lambda: gone(daemon), "the daemon goes on")
    until(lambda: not (run / "operator.json").exists(), "the service goes on")
    end = open_run(run).record.end
    assert end is not None and end.exit_code == 130 and "SIGTERM" in end.reason


@linux
def test_workers_end_with_the_killed_program_that_they_worked_for() -> None:
    program, workers = started(WORKERS.format())
    assert workers and os.getpid() not in workers
    program.send_signal(signal.SIGKILL)
    program.communicate()
    until(lambda: all(gone(pid) for pid in workers), "a worker goes on")


def test_the_blind_bench_ends_with_the_command_that_became_it(tmp_path: Path) -> None:
    program = "from gimbal_hil.surface.cli import main; main()"
    words = ["bench", "blind", "--out", str(tmp_path), "--seed", "1", "--first", "1", "--workers", "1"]
    process = subprocess.Popen([sys.executable, "-c", program, *words], stdout=subprocess.DEVNULL)
    until((tmp_path / "bench.json").exists, "the bench did not begin")
    process.kill()
    process.wait()
    assert not [one for one in Path("/proc").glob("[0-9]*/cmdline") if str(tmp_path) in words_of(one)]


def words_of(command_line: Path) -> str:
    """How a process was started; nothing of one that ended meanwhile."""
    try:
        return command_line.read_text(errors="replace")
    except OSError:
        return ""
