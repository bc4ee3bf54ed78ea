"""The guards of the adapters, and the lease of a client, with one piece changed at a time: prints which mutants no test
noticed.

The changes are those of `tests.host.mutants`. `python -m tests.adapters.mutants`; `MUTANTS_OF=obedience,_taken` takes
those with one of these texts in their names, `MUTANTS_EVERY=n` every n-th one; the rest is `tests.ledger`'s. In a first
pass every test tells which of the changed places it comes by; only those tests are asked of a mutant.
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
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import hypothesis
import pytest
from hypothesis import Phase

from tests.host.mutants import _changes, _in_order, _Replacing, _words
from tests.ledger import Ledger, key_of

_ADAPTERS, _DAEMON = "firmware_protocol.adapters", "gimbal_hil.realtime.daemon"
_PACKAGES = {"lease": _DAEMON}
#: module -> (class or none, functions)
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
    "answering": (("Answering", ("is_of_this_tick",)),),
    "moteus": (("MoteusDrive", ("take",)), ("", ("replies", "_fault_of"))),
    "odrive": (("OdriveDrive", ("take", "_judge", "enable")),),
    "cia402": (("Cia402Drive", ("command", "starve", "leave", "reset", "take", "_told", "_answered", "_sync")),),
    "lease": (("Lease", ("pass_tick",)),),
}
TESTS = (
    *("adapters/test_mapped.py", "adapters/test_drives.py", "adapters/test_stops_by_cause.py"),
    *("adapters/test_obedience.py", "adapters/test_drives_in_the_loop.py", "adapters/test_answering.py"),
    *("adapters/test_gateway.py", "adapters/test_what_drives_say.py", "adapters/test_doctor_of_drives.py"),
    "daemon/test_leases.py",
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
    key: str

    @property
    def name(self) -> str:
        return f"{self.module}.{self.function}: {self.text}"


def _functions(tree: ast.Module, owner: str) -> list[ast.FunctionDef]:
    body = tree.body
    if owner:
        body = next(node.body for node in tree.body if isinstance(node, ast.ClassDef) and node.name == owner)
    return [node for node in body if isinstance(node, ast.FunctionDef)]


def _module(name: str) -> ModuleType:
    return importlib.import_module(f"{_PACKAGES.get(name, _ADAPTERS)}.{name}")


def _tree(name: str) -> ast.Module:
    return ast.parse(Path(str(_module(name).__file__)).read_text())


def mutants() -> Iterator[Mutant]:
    """Every mutant of every guard."""
    for module, parts in GUARDS.items():
        for owner, names in parts:
            for function in (one for one in _functions(_tree(module), owner) if one.name in names):
                for place, node in enumerate(_in_order(function)):
                    for text, instead in _changes(node):
                        key = key_of(f"{module}.{function.name}: {text}", place, function)
                        yield Mutant(module, owner, function.name, text, place, copy.deepcopy(instead), key)


@contextlib.contextmanager
def _rewritten(module_name: str, owner: str, name: str, rewriting: ast.NodeTransformer) -> Iterator[None]:
    """Whoever calls the function gets the changed one: its code is put in the place of the original's."""
    module = _module(module_name)
    function = next(one for one in _functions(_tree(module_name), owner) if one.name == name)
    body = ast.Module([rewriting.visit(function)], [])
    space = dict(vars(module))
    exec(compile(ast.fix_missing_locations(body), str(module.__file__), "exec"), space)
    holder = getattr(module, owner) if owner else module
    original = getattr(holder, name)
    assert isinstance(original, FunctionType)
    before, original.__code__ = original.__code__, space[name].__code__
    try:
        yield
    finally:
        original.__code__ = before


def changed(mutant: Mutant) -> contextlib.AbstractContextManager[None]:
    """With the change made."""
    rewriting = _Replacing(mutant.place, copy.deepcopy(mutant.instead))
    return _rewritten(mutant.module, mutant.owner, mutant.function, rewriting)


class _Telling(ast.NodeTransformer):
    """Tells `_reached` of each place that is computed, by its number in the order of the nodes."""

    def __init__(self, numbers: dict[int, list[int]]) -> None:
        self._numbers, self._seen = numbers, -1

    def visit(self, node: ast.AST) -> Any:
        self._seen += 1
        numbers = self._numbers.get(self._seen, [])
        told: Any = self.generic_visit(node)
        if not numbers:
            return told
        if isinstance(told, ast.If | ast.IfExp):
            told.test = _told(numbers, told.test)
        elif isinstance(told, ast.Return):
            told.value = _told(numbers, told.value)
        else:
            told = _told(numbers, told)
        return told


def _told(numbers: list[int], value: Any) -> ast.expr:
    return ast.Call(ast.Name("_reached", ast.Load()), [ast.Constant(tuple(numbers)), value], [])


class _Asking:
    """A plug-in of pytest that collects the tests once and runs some of them again and again, each time with another
    mutant in their way.
    """

    def __init__(self, chosen: Sequence[Mutant], ledger: Ledger) -> None:
        self._chosen, self._ledger = chosen, ledger
        self._items: dict[str, pytest.Item] = {}
        self._cost: dict[str, float] = {}
        self._failed = False
        self._reached: set[int] = set()

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """In place of every test once."""
        self._items = {item.nodeid: item for item in session.items}

        def build(number: int | None) -> Callable[[str], bool]:
            def passes(name: str) -> bool:
                with contextlib.nullcontext() if number is None else changed(self._chosen[number]):
                    return self._passes(name)

            return passes

        self._ledger.ask_hinted([mutant.key for mutant in self._chosen], self._items, build)
        self._chosen = [mutant for mutant in self._chosen if not self._ledger.knows(mutant.key)]
        tests = self._reaching()
        open_ones = [(mutant.key, reaching) for mutant, reaching in zip(self._chosen, tests, strict=True)]
        self._ledger.ask(open_ones, dict(self._cost), build, "MUTANTS_TESTS" not in os.environ)
        return True

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._cost[report.nodeid] = self._cost.get(report.nodeid, 0.0) + report.duration
        self._failed = self._failed or report.failed

    def _passes(self, name: str) -> bool:
        self._failed = False
        item = self._items[name]
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
        return not self._failed

    def _reaching(self) -> list[set[str]]:
        """For each mutant the tests that come by its place."""
        places: dict[tuple[str, str, str], dict[int, list[int]]] = {}
        for number, mutant in enumerate(self._chosen):
            of = places.setdefault((mutant.module, mutant.owner, mutant.function), {})
            of.setdefault(mutant.place, []).append(number)
        reached: dict[str, set[int]] = {}
        with contextlib.ExitStack() as stack:
            for (module, owner, function), numbers in places.items():
                vars(_module(module))["_reached"] = self._reach
                stack.enter_context(_rewritten(module, owner, function, _Telling(numbers)))
            for name in self._items:
                self._reached = reached[name] = set()
                assert self._passes(name), f"{name} fails without a mutant"
        return [{name for name, numbers in reached.items() if number in numbers} for number in range(len(self._chosen))]

    def _reach(self, numbers: tuple[int, ...], value: Any) -> Any:
        self._reached.update(numbers)
        return value


def main() -> None:
    """Mutants, how many were asked, those that live."""
    ledger = Ledger()
    every, of = int(os.environ.get("MUTANTS_EVERY", "1")), _words("MUTANTS_OF")
    chosen = [mutant for mutant in mutants() if any(text in mutant.name for text in of)][::every]
    open_ones = [mutant for mutant in chosen if not ledger.knows(mutant.key)]
    # a story that fails is enough: it need not be a short one
    hypothesis.settings.register_profile("mutants", phases=(Phase.explicit, Phase.generate), database=None)
    hypothesis.settings.load_profile("mutants")
    root = Path(__file__).parents[1]
    names = [name for name in TESTS if any(text in name for text in _words("MUTANTS_TESTS"))]
    words = ["-q", "-p", "no:cacheprovider", "-m", "not heavy", *(str(root / name) for name in names)]
    if open_ones:
        with contextlib.redirect_stdout(io.StringIO()):
            pytest.main(words, [_Asking(open_ones, ledger)])
    json.dump(ledger.answer([(mutant.key, mutant.name) for mutant in chosen]), sys.stdout)


if __name__ == "__main__":
    main()
