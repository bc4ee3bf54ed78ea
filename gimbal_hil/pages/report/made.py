"""How a page came about: when, by which version, by which command."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from firmware_protocol.version import __version__
from gimbal_hil.loop.timing import wall_clock_utc

COMMAND = "gimbal-hil"


@dataclass(frozen=True)
class Made:
    """`at_utc` in ISO 8601, to the second; `command` as a shell takes it."""

    at_utc: str
    version: str
    command: str


def made_here() -> Made:
    """By the command that this process is, now."""
    return Made(f"{wall_clock_utc()[:19]}Z", __version__, command_of(sys.argv))


def command_of(arguments: Sequence[str]) -> str:
    """The line that starts a process with these arguments again: this project's command, or somebody's script."""
    if not arguments or not arguments[0] or arguments[0].startswith("-"):
        return "python"
    program = Path(arguments[0])
    if program.name == "__main__.py" or program.stem == COMMAND:
        first = [COMMAND if program.stem == COMMAND or program.parent.name == "gimbal_hil" else program.parent.name]
    else:
        first = ["python", arguments[0]] if program.suffix == ".py" else [program.name]
    return shlex.join([*first, *arguments[1:]])
