"""The guards of the adapters with one piece changed at a time: prints which mutants no test noticed.

The changes are those of `tests.host.mutants`. `python -m tests.adapters.mutants`; `MUTANTS_OF=obedience,_taken` takes
those with one of these texts in their names, `MUTANTS_EVERY=n` every n-th one.
"""

from __future__ import annotations

import ast
import contextlib
import copy
import importlib
import io
import json
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import pytest

from tests.host.mutants import _changes, _in_order, _Replacing

_PACKAGE = "firmware_protocol.adapters"
#: module -> (class or none, functions), and the tests that are asked in this order
GUARDS: dict[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    "obedience": (
        ("Obedience", ("give", "stop", "let_go", "frames", "gave_up", "is_done", "without_torque", "_heeds")),
        ("Obedience", ("_is_told_again", "is_silent", "complaint")),
        ("", ("does",)),
    ),
    "gateway": (
        ("Gateway", ("feedback", "_samples", "_advance", "_follow", "_in_fault", "_react", "_remember", "_fail")),
        ("Gateway", ("_request", "_arrive", "_found_fault", "_fresh")),
        ("", ("_asked",)),
    ),
    "mapped": (("MappedDrive", ("_taken", "_word", "_judge", "_values", "_grow_older", "take")),),
    "drive": (("", ("stopped_blindly", "starved", "farewell", "shaft_torque")),),
}
TESTS = (
    "test_mapped.py",
    "test_drives.py",
    "test_stops_by_cause.py",
    "test_obedience.py",
    "test_drives_in_the_loop.py",
)


@dataclass(frozen=True)
class Mutant:
    """One change in one function of a module."""

    module: str
    owner: str
    function: str
    text: str
    place: int
    instead: Any

    @property
    def name(self) -> str:
        return f"{self.module}.{self.function}: {self.text}"


def _functions(tree: ast.Module, owner: str) -> list[ast.FunctionDef]:
    body = tree.body
    if owner:
        body = next(node.body for node in tree.body if isinstance(node, ast.ClassDef) and node.name == owner)
    return [node for node in body if isinstance(node, ast.FunctionDef)]


def _module(name: str) -> ModuleType:
    return importlib.import_module(f"{_PACKAGE}.{name}")


def _tree(name: str) -> ast.Module:
    return ast.parse(Path(str(_module(name).__file__)).read_text())


def mutants() -> Iterator[Mutant]:
    """Every mutant of every guard."""
    for module, parts in GUARDS.items():
        for owner, names in parts:
            for function in (one for one in _functions(_tree(module), owner) if one.name in names):
                for place, node in enumerate(_in_order(function)):
                    for text, instead in _changes(node):
                        yield Mutant(module, owner, function.name, text, place, copy.deepcopy(instead))


@contextlib.contextmanager
def changed(mutant: Mutant) -> Iterator[None]:
    """Whoever calls the function gets the changed one: its code is put in the place of the original's."""
    module = _module(mutant.module)
    function = next(one for one in _functions(_tree(mutant.module), mutant.owner) if one.name == mutant.function)
    function = _Replacing(mutant.place, copy.deepcopy(mutant.instead)).visit(function)
    space = dict(vars(module))
    body = ast.Module([function], [])
    exec(compile(ast.fix_missing_locations(body), str(module.__file__), "exec"), space)
    holder = getattr(module, mutant.owner) if mutant.owner else module
    original = getattr(holder, mutant.function)
    assert isinstance(original, FunctionType)
    before, original.__code__ = original.__code__, space[mutant.function].__code__
    try:
        yield
    finally:
        original.__code__ = before


def _is_noticed(words: list[str]) -> bool:
    with contextlib.redirect_stdout(io.StringIO()):
        return pytest.main(["-x", "-q", "-p", "no:cacheprovider", "-m", "not heavy", *words]) != 0


def main() -> None:
    began = time.monotonic()
    every, of = int(os.environ.get("MUTANTS_EVERY", "1")), os.environ.get("MUTANTS_OF", "").split(",")
    seconds = float(os.environ.get("MUTANTS_SECONDS", "inf"))
    first = int(os.environ.get("MUTANTS_FROM", "0"))
    chosen = [mutant for mutant in mutants() if any(text in mutant.name for text in of)][first::every]
    words = [str(Path(__file__).parent / name) for name in TESTS]
    assert not _is_noticed(words[:1]), "the tests fail without a mutant"
    survivors, asked = [], 0
    for mutant in chosen:
        if time.monotonic() - began > seconds:
            break
        asked += 1
        with changed(mutant):
            noticing = next((word for word in words if _is_noticed([word])), None)
            if noticing is None:
                survivors.append(mutant.name)
                print(f"lives: {mutant.name}", file=sys.stderr, flush=True)
            else:
                # neighbours are noticed by the same tests
                words.sort(key=lambda word: word != noticing)
    json.dump({"mutants": len(chosen), "asked": asked, "from": first, "survivors": survivors}, sys.stdout)


if __name__ == "__main__":
    main()
