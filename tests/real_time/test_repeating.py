"""The repetition of tests in real time: only beside a stall, not for ever, and not in secret."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.real_time.repeating import TRIES

MARKED = re.compile(r"^pytestmark = \[?pytest\.mark\.realtime\b", re.MULTILINE)
#: it fails as often as it is told to; where it is told so, it keeps the watchers from waking up meanwhile
FAILS_AT_FIRST = """
import pathlib, signal, time
import pytest
from tests.real_time.repeating import the_watch

@pytest.mark.realtime
def test_it(tmp_path):
    assert not list(tmp_path.iterdir())
    (tmp_path / "used").touch()
    for watcher in the_watch().watchers if {stalled} else ():
        watcher.send_signal(signal.SIGSTOP)
        time.sleep(0.1)
        watcher.send_signal(signal.SIGCONT)
    tried = pathlib.Path("tried")
    count = int(tried.read_text()) + 1 if tried.exists() else 1
    tried.write_text(str(count))
    assert count > {failures}
"""


def run_of(folder: Path, failures: int, stalled: bool) -> tuple[int, int, str]:
    """Exit code, how often the test ran, what pytest printed."""
    (folder / "test_it.py").write_text(FAILS_AT_FIRST.format(failures=failures, stalled=stalled))
    (folder / "pytest.ini").write_text("[pytest]\nmarkers = realtime\n")
    root = str(Path(__file__).parents[2])
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "tests.real_time.repeating", "-p", "no:cacheprovider", "-rA"],
        cwd=folder,
        env={"PYTHONPATH": root, "PATH": ""},
        capture_output=True,
        text=True,
    )
    return done.returncode, int((folder / "tried").read_text()), done.stdout + done.stderr


def test_a_failure_beside_a_stall_is_tried_again_and_told(tmp_path: Path) -> None:
    code, tried, printed = run_of(tmp_path, failures=1, stalled=True)
    assert (code, tried) == (0, 2), printed
    assert printed.count("REPEATED") == 1 and "the machine stood still for " in printed


def test_a_test_that_always_fails_has_failed(tmp_path: Path) -> None:
    code, tried, printed = run_of(tmp_path, failures=99, stalled=True)
    assert (code, tried) == (1, TRIES), printed


@pytest.mark.realtime
def test_a_failure_without_a_stall_stands(tmp_path: Path) -> None:
    """Where the machine really stalls in this half second, this test is itself one in real time."""
    code, tried, printed = run_of(tmp_path, failures=1, stalled=False)
    assert (code, tried) == (1, 1), printed


def test_every_module_that_waits_on_the_clock_is_marked() -> None:
    tests = Path(__file__).parents[1]
    texts = {path: path.read_text() for path in tests.rglob("test_*.py") if path != Path(__file__)}
    waiting = {path for path, text in texts.items() if "time.sleep(" in text or "RunningDaemon(" in text}
    assert waiting
    assert not [path for path in waiting if not MARKED.search(texts[path])]
