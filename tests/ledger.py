"""What became of each mutant, one a line in a file: a run that was cut off goes on where it was, and after a change
only the mutants of functions that it touched are asked again.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import time
from collections.abc import Sequence
from pathlib import Path


class Ledger:
    """`MUTANTS_OUT` names the file, `MUTANTS_SECONDS` after how long no other mutant is begun."""

    def __init__(self) -> None:
        out = os.environ.get("MUTANTS_OUT")
        self._file = None if out is None else Path(out)
        self._end = time.monotonic() + float(os.environ.get("MUTANTS_SECONDS", "inf"))
        text = self._file.read_text() if self._file is not None and self._file.exists() else ""
        self._killers: dict[str, str | None] = {}
        for line in text.splitlines():
            entry = json.loads(line)
            self._killers[entry["key"]] = entry["killer"]

    @property
    def is_over(self) -> bool:
        """Whether the time is up."""
        return time.monotonic() > self._end

    def knows(self, key: str) -> bool:
        """Whether a test has noticed this mutant; one that lived is asked again, for tests come."""
        return self._killers.get(key) is not None

    def enter(self, key: str, killer: str | None) -> None:
        """The test that noticed it, or that none did."""
        self._killers[key] = killer
        if self._file is not None:
            with self._file.open("a") as out:
                out.write(json.dumps({"key": key, "killer": killer}) + "\n")

    def killers(self) -> list[str]:
        """Every test that noticed one, the one that did so last first."""
        return list(dict.fromkeys(killer for killer in reversed(self._killers.values()) if killer is not None))

    def answer(self, named: Sequence[tuple[str, str]]) -> dict[str, object]:
        """How many of these mutants (their keys and names) were asked, and the names of those that live."""
        asked = [(key, name) for key, name in named if key in self._killers]
        survivors = [name for key, name in asked if self._killers[key] is None]
        return {"mutants": len(named), "asked": len(asked), "survivors": survivors}


def key_of(name: str, place: int, function: ast.FunctionDef) -> str:
    """One mutant of a function as it is written now."""
    return f"{hashlib.sha256(ast.unparse(function).encode()).hexdigest()[:12]} {place} {name}"
