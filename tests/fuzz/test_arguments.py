"""Arguments that no command can work with, and a system that refuses: one line and an exit code, never a traceback."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

LONG = "x" * 300
COMMAND = [sys.executable, "-c", "from gimbal_hil.surface.cli import main; main()"]


def run(*words: str, open_files: int | None = None, output: int = subprocess.PIPE) -> tuple[int, str]:
    """Exit code and standard error of a command."""

    def few_files() -> None:
        if open_files is not None:
            resource.setrlimit(resource.RLIMIT_NOFILE, (open_files, open_files))

    done = subprocess.run(
        [*COMMAND, *words], stdout=output, stderr=subprocess.PIPE, text=True, timeout=300, preexec_fn=few_files
    )
    return done.returncode, done.stderr


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("daemon", "--spin-us", "inf"), "--spin-us"),
        (("daemon", "--duration", "inf"), "--duration"),
        (("daemon", "--duration", "1e300"), "--duration"),
        (("plant", "--duration", "nan"), "--duration"),
        (("replay", f"/tmp/{LONG}"), "name too long; expected a name of at most 255 characters"),
        (("export", f"/tmp/{LONG}", "--format", "csv", "--out", "/tmp/x.csv"), "name too long"),
        (("daemon", "--config", f"/tmp/{LONG}"), "name too long"),
        (("daemon", "--config", "/dev/zero"), "is a device, not a file"),
        (("daemon", "--config", "/dev/null"), "is a device, not a file"),
        (("daemon", "--send", '{"command": "status", "self": 1}', "--run", "/nowhere"), "no such file"),
        (("daemon", "--send", '{"command": 1e400}', "--run", "/nowhere"), "--send"),
    ],
)
def test_a_senseless_argument_is_refused_in_one_line(words: tuple[str, ...], says: str) -> None:
    code, errors = run(*words)
    assert code == 2 and says in errors
    assert len(errors.strip().splitlines()) == 1 and "Traceback" not in errors


def test_a_full_output_is_said_and_a_reader_that_has_gone_is_not_an_error() -> None:
    full = os.open("/dev/full", os.O_WRONLY)
    code, errors = run("effects", output=full)
    assert code == 2 and errors.startswith("error: No space left on device")
    for words in (["--help"], ["effects"]):
        reader, writer = os.pipe()
        os.close(reader)
        assert run(*words, output=writer) == (0, "")
        os.close(writer)
    os.close(full)


def test_a_system_with_few_open_files_is_answered_for(tmp_path: Path) -> None:
    table = tmp_path / "log.csv"
    table.write_text("time_s,outer.torque\n")
    code, errors = run("effects", open_files=5)
    assert code in (0, 2) and "Traceback" not in errors
    code, errors = run("daemon", "--lockstep", "--duration", "0.01", "--out", str(tmp_path / "run"), open_files=9)
    assert code != 0 and "Traceback" not in errors and errors.strip()
