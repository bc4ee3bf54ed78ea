"""What the shipped command answers on a data folder: in this process, or with a plugged-in effect in one of its own."""

from __future__ import annotations

import contextlib
import io
import json
import os
import resource
import signal
import subprocess
import sys
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any

VERDICT_FILE = "verdict.json"
_COMMAND = "from gimbal_hil.surface.cli import main; main()"


class TooSlow(Exception):
    """The command did not answer within the limit."""


@contextlib.contextmanager
def _within(seconds: int) -> Iterator[None]:
    """Raises TooSlow in the main thread when the processor time is over: a busy machine is no fault of the
    command's.
    """

    def over(*_: object) -> None:
        raise TooSlow

    before = signal.signal(signal.SIGPROF, over)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def answer_of(data: Path, out: Path, limit_s: int, guest: Path | None) -> tuple[dict[str, Any], dict[str, float]]:
    """What the command leaves, and its seconds on the wall clock and of one processor. It is told the data folder and
    nothing else.

    A crash or a time-out is an answer as well. `guest` is a folder with an installed effect.
    """
    words = [
        "discrepancy",
        "--model",
        str(data / "model.yaml"),
        "--out",
        str(out),
        "--workers",
        "1",
        "--json",
        "--force",
    ]
    words += [
        "--measured",
        *map(str, sorted(data.glob("measured_*"))),
        "--holdout",
        *map(str, sorted(data.glob("holdout_*"))),
    ]
    wall, cpu = time.perf_counter(), _processor_s()
    code, said = _here(words, limit_s) if guest is None else _beside(words, limit_s, guest)
    seconds = {"wall": round(time.perf_counter() - wall, 1), "cpu": round(_processor_s() - cpu, 1)}
    if code == 0 and (out / VERDICT_FILE).exists():
        return dict(json.loads((out / VERDICT_FILE).read_text(encoding="utf-8"))), seconds
    verdict = {0: "crashed", 1: "crashed", None: "too_slow"}.get(code, "unusable_data")
    nothing = {"effects": [], "alternatives": [], "next_experiment": None, "not_testable": [], "gap": None}
    return {"verdict": verdict, "text": said, **nothing}, seconds


def _processor_s() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def _here(words: list[str], limit_s: int) -> tuple[int | None, str]:
    """Exit code (1 for a crash, None when it was too slow) and what was said about it."""
    from gimbal_hil.surface.cli import main

    said = io.StringIO()
    try:
        with _within(limit_s), contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            main(words)
    except SystemExit as done:
        return done.code if isinstance(done.code, int) else 0, said.getvalue().strip()
    except TooSlow:
        return None, f"no answer in {limit_s} s of one processor"
    except Exception:
        return 1, traceback.format_exc()
    return 1, "the command came back without an exit code"


def _beside(words: list[str], limit_s: int, guest: Path) -> tuple[int | None, str]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(guest), os.environ.get("PYTHONPATH", "")])}
    limited = f"import resource; resource.setrlimit(resource.RLIMIT_CPU, ({limit_s}, {limit_s})); {_COMMAND}"
    done = subprocess.run([sys.executable, "-c", limited, *words], env=environment, capture_output=True, text=True)
    if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        return None, f"no answer in {limit_s} s of one processor"
    return done.returncode, done.stderr.strip()
