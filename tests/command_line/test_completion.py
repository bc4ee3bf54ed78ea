"""A shell can complete commands, options, sequences and names of models; the script for it comes from the library."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from gimbal_hil.surface.cli.app import overview
from gimbal_hil.surface.cli.commands import COMMANDS, GROUPS

PROGRAM = "from gimbal_hil.surface.cli import main; main()"


def completed(line: str) -> list[str]:
    """What bash is offered at the end of a line."""
    words = line.split(" ")
    environment = os.environ | {
        "_GIMBAL_HIL_COMPLETE": "complete_bash",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
    }
    done = subprocess.run([sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True)
    return done.stdout.split()


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("gimbal-hil exp", {"experiment", "export", "export-model"}),
        ("gimbal-hil experiment sur", {"survey", "survey_holdout"}),
        ("gimbal-hil experiment step --conf", {"--config"}),
        ("gimbal-hil discrepancy --model em", {"emps"}),
    ],
)
def test_bash_is_offered_what_may_follow(line: str, expected: set[str]) -> None:
    assert expected == {word for word in completed(line) if not word.startswith("friction")}


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_of_each_shell_is_shown(shell: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, "--show-completion", shell], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "_GIMBAL_HIL_COMPLETE" in done.stdout and "gimbal-hil" in done.stdout


def test_help_shows_every_command_once_in_its_group() -> None:
    shown = [name for names in GROUPS.values() for name in names]
    assert sorted(shown) == sorted(COMMANDS)
    lines = overview().splitlines()
    assert all(sum(line.startswith(f"  {name} ") for line in lines) == 1 for name in COMMANDS)
    assert all(f"{group}:" in lines for group in GROUPS)
