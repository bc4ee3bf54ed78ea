"""Every command on every page is one that the program understands; those in blocks that need no hardware run."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import typer.main

from gimbal_hil.cli.app import COMMANDS, _repeated, function_of
from gimbal_hil.cli.completion import whole_app

ROOT = Path(__file__).resolve().parent.parent.parent
#: records tell of their day, the changelog of what was
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "how-to").glob("*.md")])
PROGRAM = str(Path(sys.executable).with_name("gimbal-hil"))
#: what a page writes for a number of the reader's
_NUMBERS = {"N": "3", "S": "60", "HZ": "500", "PORT": "0"}
_FENCED = re.compile(r"```(?:sh|yaml)\n(.*?)```", re.S)
_IN_A_LINE = re.compile(r"`(gimbal-hil [^`]+)`")


def commands_in(text: str) -> Iterator[str]:
    """Command lines of blocks (fenced or indented) and of code within sentences, without comments."""
    lines = [line for block in _FENCED.findall(text) for line in _in_one_line(block).splitlines()]
    outside = re.sub(r"```.*?```", "", text, flags=re.S)
    lines += re.findall(r"^    (gimbal-hil .*)$", _in_one_line(outside), re.M)
    lines += [" ".join(found.split()) for found in _IN_A_LINE.findall(outside)]
    for line in lines:
        for part in re.split(r"&&|;", re.sub(r"\s+#.*", "", line)):
            _, found, rest = part.partition("gimbal-hil ")
            if found and (rest.split() or [""])[0] in COMMANDS and " pip " not in part:
                yield f"gimbal-hil {rest.strip()}"


def _in_one_line(text: str) -> str:
    """Commands that go on in the next line, after a backslash or with an option, in one."""
    return re.sub(r"\n +(?=--)", " ", text.replace("\\\n", " "))


def words_of(line: str) -> list[str]:
    """The words of a command line; of what is optional on a page everything, of alternatives the first."""
    line = re.sub(r"\|[^\]|]*(?=[\]|])", "", line).replace("[", " ").replace("]", " ").replace("...", " ")
    return [_NUMBERS.get(word, word) for word in shlex.split(line)[1:]]


def blocks_only(text: str) -> str:
    """The text without what stands in code within its sentences."""
    return _IN_A_LINE.sub("", text)


UNDERSTOOD = sorted({(page.name, line) for page in PAGES for line in commands_in(page.read_text(encoding="utf-8"))})


@cache
def the_program() -> Any:
    """All commands, with their options."""
    return typer.main.get_command(whole_app())


@pytest.mark.parametrize(("page", "line"), UNDERSTOOD, ids=[f"{page}-{line}"[:90] for page, line in UNDERSTOOD])
def test_a_command_on_a_page_is_one_that_the_program_understands(page: str, line: str) -> None:
    name, *words = words_of(line)
    command = the_program().commands[name]
    if not words or words[-1] in ("--emit", "--link"):
        return  # the name of a command or of an option, in a sentence
    command.make_context(name, _repeated(words, getattr(function_of(name)[0], "MANY_VALUED", ())))


def test_every_page_with_commands_was_found() -> None:
    assert len(UNDERSTOOD) > 100 and {"pointing.md", "arena.md", "README.md"} <= {page for page, _ in UNDERSTOOD}


#: what cannot run in a test, and why
NOT_HERE = {
    r"can0|serial:|/dev/|unix:PATH|socketcan": "hardware",
    r"link qemu": "an emulator, tests/firmware",
    r"--link unix|realtime|soak": "minutes to hours of real time, tests/bench",
    r"^(set|adjust|stop|quick-stop|shut-down|reset)|--run\b": "a running daemon, tests/operator_commands",
    r"^(plant|watch)|^daemon(?!.*--duration)": "runs until it is stopped, tests/daemon",
    r"^service install": "needs root, tests/deployment",
    r"bench (pointing|blind|faults|speed|search|--repeats)|^bench$": "minutes, tests of each bench",
    r"^(improve|tune|demo|warm|conformance|identify|discrepancy|doctor)": "minutes, tests of each command",
    r"experiment (thesis|base_motion|sliding|presliding|survey)": "minutes, tests/experiments",
    r"^check (a\.csv|antenna)|\b(NAME|FILE|RUN|DIR|MODEL|LOG|CONFIG)\b": "the reader's own files",
    r"FILE\.csv|runs/first|runs/golden|RUN/scope": "the reader's own runs",
    r"tle:": "needs skyfield, tests/pointing",
    r"--moving|--duration 600": "an hour of flight, tests/pointing",
    r"^init": "asks, or is made before, tests/starting",
}
#: made before the commands of any page
BEFORE = (
    "init mine --yes",
    "experiment step --short --axis outer --out runs/step",
    "experiment step --short --axis outer --seed 2 --out B",
    "experiment step --short --axis outer --seed 3 --out A",
    "init . --yes --axes outer,inner",
)


def program(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([PROGRAM, *words_of(f"x {line}")], cwd=folder, capture_output=True, text=True, timeout=600)


def reason(line: str) -> str | None:
    return next((why for pattern, why in NOT_HERE.items() if re.search(pattern, line)), None)


@pytest.mark.heavy
def test_commands_of_the_pages_run(tmp_path: Path) -> None:
    """Those in blocks, one after the other in one folder, where an antenna of one's own and three runs are."""
    lines = dict.fromkeys(
        line.removeprefix("gimbal-hil ")
        for page in PAGES
        for line in commands_in(blocks_only(page.read_text(encoding="utf-8")))
    )
    tried = [line for line in lines if reason(line) is None]
    assert len(tried) > 10
    (tmp_path / "config").symlink_to(ROOT / "config")
    failed = []
    for line in (*BEFORE, *tried):
        done = program(line, tmp_path)
        if done.returncode != 0:
            failed.append(f"{line}: {done.returncode} {done.stderr.strip()[-300:]}")
    assert not failed, "\n".join(failed)
