"""`.ci/run` installs what the tests take from apt, and runs the README's test command."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
#: what the script itself needs; no compiler, no emulator and no browser
_TOOLS = ("bash", "cat", "chmod", "dirname", "env", "mkdir", "mktemp", "rm", "sed", "timeout")
_FOUND = ("cc", "arm-none-eabi-gcc", "cppcheck", "qemu-system-arm", "google-chrome")
_APT = "apt-get -qq -o Acquire::Retries=1 -o Acquire::http::Timeout=20"
_WANTED = "gcc gcc-arm-none-eabi libnewlib-arm-none-eabi cppcheck qemu-system-arm chromium"
pytestmark = pytest.mark.skipif(not (ROOT / ".ci" / "run").exists(), reason="needs the source checkout")


def _program(path: Path, text: str) -> None:
    path.write_text(f"#!/usr/bin/env bash\n{text}\n")
    path.chmod(0o755)


def _said(folder: Path, apt_get: str, *there: str) -> list[str]:
    """Lines of `.ci/run` on a machine of root's with these programs, which say what they are asked."""
    for tool in _TOOLS:
        found = shutil.which(tool)
        assert found is not None
        (folder / tool).symlink_to(found)
    _program(folder / "id", "echo 0")
    _program(folder / "apt-get", f'echo "apt-get $*"; {apt_get}')
    # the environment that it is asked to make has a pip and a python that do nothing else than this one
    made = 'if [ "$2" = venv ]; then mkdir -p "$3/bin"; for one in pip python; do cat "$0" > "$3/bin/$one"; '
    _program(folder / "python3", f'echo "${{0##*/}} $*"\n{made}chmod +x "$3/bin/$one"; done; fi')
    for name in there:
        _program(folder / name, "exit 1")
    done = subprocess.run(
        [ROOT / ".ci" / "run"], env={"PATH": str(folder)}, capture_output=True, text=True, check=False, cwd=folder
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_what_is_not_there_is_installed_before_the_test_command_runs(tmp_path: Path) -> None:
    said = _said(tmp_path, "exit 0")
    assert said[:3] == [
        f"{_APT} update",
        f"{_APT} install -y --no-install-recommends {_WANTED}",
        f"+ installed {_WANTED}",
    ]
    assert said[-1] == "python -m pytest -n 2 --dist loadfile -m not heavy"


def test_what_is_there_is_not_installed(tmp_path: Path) -> None:
    assert not [line for line in _said(tmp_path, "exit 1", *_FOUND) if "apt-get" in line]


def test_where_nothing_may_be_installed_the_tests_run_and_it_says_what_is_skipped(tmp_path: Path) -> None:
    said = _said(tmp_path, "exit 1", *_FOUND[:-1])
    assert said[:2] == [f"{_APT} update", "+ without chromium: their tests are skipped"]
    assert said[-1].startswith("python -m pytest")
