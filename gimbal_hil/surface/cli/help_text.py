"""What `--help` of a command prints, with words in place of names of Python's types."""

from __future__ import annotations

import re
from typing import Any

_WORDS = {"path": "PATH", "Path": "PATH", "str": "TEXT", "int": "NUMBER", "float": "NUMBER"}
_TYPE = re.compile(r"<(?:list\[)?(\w+?)(?: range)?\]?>")


def help_text(command: Any, name: str) -> str:
    """The help of a command of Typer's; nothing is run."""
    context = command.make_context(f"gimbal-hil {name}", [], resilient_parsing=True)
    return "\n".join(map(_plain, str(context.get_help()).splitlines()))


def _plain(line: str) -> str:
    """A line with every type as what one writes there; an argument has its own name for that. Columns stay."""
    is_option = line.lstrip().startswith("-")

    def word(found: re.Match[str]) -> str:
        known = _WORDS.get(found[1])
        return found[0] if known is None else (known if is_option else "").ljust(len(found[0]))

    return _TYPE.sub(word, line).rstrip()
