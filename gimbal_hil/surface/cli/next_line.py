"""The line `next:` with which every command ends: a whole command line."""

from __future__ import annotations

import shlex
from pathlib import Path


def print_next(line: str) -> None:
    """Say what to run next."""
    print(f"next: {line}")


def command_line(*words: object, **options: object) -> str:
    """A command line that a shell takes: words, then options that are neither None nor empty; several values repeat,
    and True is an option without a value.
    """
    found = [str(word) for word in words]
    for name, value in options.items():
        values = value if isinstance(value, list | tuple) else [] if value in (None, "", False) else [value]
        for one in values:
            found += [f"--{name.replace('_', '-')}", *([] if one is True else [str(one)])]
    return shlex.join(["gimbal-hil", *found])


def free_path(path: Path) -> Path:
    """This path, or the next number of it that is not there yet: no command writes over what stands there."""
    tried, number = path, 1
    while tried.exists():
        number += 1
        tried = path.with_name(f"{path.stem}_{number}{path.suffix}")
    return tried
