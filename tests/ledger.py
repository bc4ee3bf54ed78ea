"""What became of each mutant, one a line in a file: a run that was cut off goes on where it was, and after a change
only the mutants of functions that it touched are asked again.
"""

from __future__ import annotations

import ast
import hashlib
import json
import math
import os
import signal
import sys
import time
from collections.abc import Callable, Collection, Sequence
from pathlib import Path

#: s of tests for one mutant before another is asked, in each round
_PATIENCE_S = (4.0, 12.0, 36.0, math.inf)
#: s after which a test counts as failed: some wait for a motion that a mutant never makes
_LONGEST_S = 120


class Ledger:
    """`MUTANTS_OUT` names the file, `MUTANTS_SECONDS` after how long no other mutant is begun. `MUTANTS_HINTS` names a
    file of other code: nothing in it counts, but what noticed a mutant there is asked about it first.
    """

    def __init__(self) -> None:
        out, hints = os.environ.get("MUTANTS_OUT"), os.environ.get("MUTANTS_HINTS")
        self._file = None if out is None else Path(out)
        self._end = time.monotonic() + float(os.environ.get("MUTANTS_SECONDS", "inf"))
        self._killers = _read(self._file)
        self._hints: dict[str, list[str]] = {}
        for key, killer in _read(None if hints is None else Path(hints)).items():
            if killer is not None:
                self._hints.setdefault(_without_hash(key), []).append(killer)

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

    def ask_hinted(
        self, mutants: Sequence[str], tests: Collection[str], build: Callable[[int | None], Callable[[str], bool]]
    ) -> None:
        """Ask each mutant (its key) only what noticed it in other code, if that passes without a mutant. `build` makes
        the code without a change where it is given no number.
        """
        wanted = {name for key in mutants for name in self._hints.get(_without_hash(key), ()) if name in tests}
        unchanged = build(None)
        good = {name for name in sorted(wanted) if not self.is_over and _in_time(unchanged, name)}
        for number, key in enumerate(mutants):
            names = [name for name in self._hints.get(_without_hash(key), ()) if name in good]
            if self.is_over or not names:
                continue
            passes = build(number)
            killer = next((name for name in dict.fromkeys(names) if not _in_time(passes, name)), None)
            if killer is not None:
                self.enter(key, killer)

    def killers(self) -> list[str]:
        """Every test that noticed one, the one that did so last first."""
        return list(dict.fromkeys(killer for killer in reversed(self._killers.values()) if killer is not None))

    def ask(
        self,
        mutants: Sequence[tuple[str, set[str]]],
        cost: dict[str, float],
        build: Callable[[int], Callable[[str], bool]],
        with_all_tests: bool = True,
    ) -> None:
        """Ask for each mutant (its key, the tests that can notice it) the tests until one fails: what found the one
        before first, then the quick ones. Those that may live are asked on in later rounds, each more patient than the
        one before; only those that all tests leave alive live. `build` makes a mutant by its number and answers what
        runs a test.
        """
        latest = [name for name in self.killers() if name in cost]
        asked: dict[int, set[str]] = {number: set() for number in range(len(mutants))}
        for patience_s in _PATIENCE_S:
            for number, (key, tests) in enumerate(mutants):
                if self.is_over:
                    return
                if key in self._killers and self._killers[key] is not None:
                    continue
                order = [name for name in latest if name in tests]
                order += sorted(tests - set(order), key=lambda name: cost[name])
                passes, killer, spent_s = build(number), None, 0.0
                for name in order:
                    if name in asked[number]:
                        continue
                    if spent_s > patience_s:
                        break
                    asked[number].add(name)
                    spent_s += cost[name]
                    if not _in_time(passes, name):
                        killer = name
                        break
                if killer is not None:
                    latest = [killer, *(name for name in latest if name != killer)]
                    self.enter(key, killer)
                elif with_all_tests and asked[number] == tests and patience_s == math.inf:
                    self.enter(key, None)
                    print(f"lives: {key}", file=sys.stderr, flush=True)

    def answer(self, named: Sequence[tuple[str, str]]) -> dict[str, object]:
        """How many of these mutants (their keys and names) were asked, and the names of those that live."""
        asked = [(key, name) for key, name in named if key in self._killers]
        survivors = [name for key, name in asked if self._killers[key] is None]
        return {"mutants": len(named), "asked": len(asked), "survivors": survivors}


def _read(file: Path | None) -> dict[str, str | None]:
    text = file.read_text() if file is not None and file.exists() else ""
    entries = [json.loads(line) for line in text.splitlines()]
    return {entry["key"]: entry["killer"] for entry in entries}


def _without_hash(key: str) -> str:
    """What a mutant is called, whatever else its function says and wherever in it that is."""
    return key.split(" ", 2)[2]


def _in_time(passes: Callable[[str], bool], name: str) -> bool:
    def too_long(*_: object) -> None:
        raise TimeoutError(f"{name} waits for what never comes")

    before = signal.signal(signal.SIGALRM, too_long)
    signal.alarm(_LONGEST_S)
    try:
        return passes(name)
    except TimeoutError:
        return False
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def key_of(name: str, place: int, function: ast.FunctionDef) -> str:
    """One mutant of a function as it is written now."""
    return f"{hashlib.sha256(ast.unparse(function).encode()).hexdigest()[:12]} {place} {name}"
