"""The host's guards with one piece changed at a time, made from their own source and interpreted: prints as JSON which
mutants no test noticed. Run by test_mutants.py.

A mutant takes a condition away, turns a comparison round, drops one half of an `and` or `or`, forgets a sign, or
answers that all is well.
"""

from __future__ import annotations

import ast
import copy
import functools
import importlib
import itertools
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

_PACKAGE = "gimbal_hil.host"
#: in the order of import, so that each one takes the changed names of those before it
_NAMES = ("event_ring", "identity", "plausibility", "limits", "reactions", "reception", "drive", "following", "acting")
_MODULES = {name: importlib.import_module(f"{_PACKAGE}.{name}") for name in (*_NAMES, "core")}
#: where the guards are
GUARDS = {
    "identity": ("receive_identity", "is_known", "is_refused", "_refusal", "_units_differ"),
    "plausibility": ("watch_status", "watch_sensors", "implausible", "_acting_torque", "_weights", "_is_noisy"),
    "limits": (
        "fault_of",
        "stop_cause",
        "report_beyond_limits",
        "_moving_rate",
        "_reached",
        "_counted",
        "_fault_of_axis",
    ),
    "reactions": ("stop_kind",),
    "drive": ("may_reset_fault",),
    "core": ("_take_requests", "_supervise", "_synchronise", "_leave_fault", "_check_limits", "_stop"),
}
TESTS = ("test_plausibility", "test_guards", "test_identity", "test_connecting")
_TURNED = {ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq}
#: what a guard answers when it trips
_CAUSES = (
    *("_PROTOCOL", "_NAME", "_SERIAL", "_TORQUE_RANGE", "_FROZEN", "_DRIFT", "_STUCK", "_RUNAWAY", "_OVERSPEED"),
    *("_DISAGREE", "_FOLLOWING", "_TRAVEL", "_WRAP", "_TEMPERATURE", "_RAMP", "cause"),
)
#: mutants that change nothing that can be seen, and why
EQUIVALENT: dict[str, str] = {}


@dataclass(frozen=True)
class Mutant:
    """One change in one function."""

    module: str
    function: str
    text: str
    tree: ast.Module

    @property
    def name(self) -> str:
        """Which it is, as in EQUIVALENT."""
        return f"{self.module}.{self.function}: {self.text}"


def _changes(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """What may stand in place of a node."""
    if isinstance(node, ast.If | ast.IfExp):
        without = copy.copy(node)
        without.test = ast.Constant(False)
        yield f"if {ast.unparse(node.test)} -> never", without
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in _TURNED:
        turned = ast.Compare(node.left, [_TURNED[type(node.ops[0])]()], node.comparators)
        yield f"{ast.unparse(node)} -> {ast.unparse(turned)}", turned
    if isinstance(node, ast.BoolOp):
        for left_out in range(len(node.values)):
            rest = [value for place, value in enumerate(node.values) if place != left_out]
            less = rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)
            yield f"{ast.unparse(node)} -> {ast.unparse(less)}", less
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "abs":
        yield f"{ast.unparse(node)} -> {ast.unparse(node.args[0])}", node.args[0]
    if isinstance(node, ast.Return) and isinstance(node.value, ast.Name) and node.value.id in _CAUSES:
        yield f"{ast.unparse(node)} -> return NONE", ast.Return(ast.Constant(0))


class _Replacing(ast.NodeTransformer):
    def __init__(self, place: int, instead: ast.AST) -> None:
        self._place, self._instead, self._seen = place, instead, -1

    def visit(self, node: ast.AST) -> ast.AST:
        self._seen += 1
        return self._instead if self._seen == self._place else self.generic_visit(node)


def mutants() -> Iterator[Mutant]:
    """Every mutant of every guard."""
    for module, functions in GUARDS.items():
        tree = ast.parse(_source(_MODULES[module]))
        for at, function in enumerate(tree.body):
            if not isinstance(function, ast.FunctionDef) or function.name not in functions:
                continue
            for place, node in enumerate(_in_order(function)):
                for text, instead in _changes(node):
                    whole = copy.deepcopy(tree)
                    whole.body[at] = _Replacing(place, copy.deepcopy(instead)).visit(copy.deepcopy(function))
                    yield Mutant(module, function.name, text, ast.fix_missing_locations(whole))


def _in_order(node: ast.AST) -> Iterator[ast.AST]:
    """Nodes in the order in which a NodeTransformer comes by."""
    yield node
    for child in ast.iter_child_nodes(node):
        yield from _in_order(child)


@functools.cache
def _source(module: ModuleType) -> str:
    assert module.__file__ is not None
    return Path(module.__file__).read_text()


def _build(mutant: Mutant | None) -> None:
    """Load the host anew, with one of its modules changed."""
    for name, module in _MODULES.items():
        assert module.__file__ is not None
        tree: Any = mutant.tree if mutant is not None and mutant.module == name else _source(module)
        exec(compile(tree, module.__file__, "exec"), module.__dict__)


def _tests() -> dict[str, Callable[[], None]]:
    """Every test with every of its parameters, by name."""
    found: dict[str, Callable[[], None]] = {}
    for module in (importlib.import_module(f"tests.host.{name}") for name in TESTS):
        for name, function in vars(module).items():
            if not name.startswith("test_") or not callable(function):
                continue
            marks = [mark for mark in getattr(function, "pytestmark", ()) if mark.name == "parametrize"]
            for values in itertools.product(*(mark.args[1] for mark in marks)):
                given: dict[str, Any] = {}
                for mark, value in zip(marks, values, strict=True):
                    keys = mark.args[0] if isinstance(mark.args[0], tuple | list) else mark.args[0].split(",")
                    given |= zip((key.strip() for key in keys), value if len(keys) > 1 else (value,), strict=True)
                found[f"{name}{list(given.values()) or ''}"] = lambda run=function, given=given: run(**given)
    return found


def _passes(test: Callable[[], None]) -> bool:
    try:
        test()
    except Exception:
        return False
    return True


def main() -> None:
    """Mutants, those that live, and how long it took; `MUTANTS_EVERY=n` takes every n-th one."""
    began, tests = time.perf_counter(), _tests()
    _build(None)
    cost: dict[str, float] = {}
    for name, test in tests.items():
        at = time.perf_counter()
        if _passes(test):
            cost[name] = time.perf_counter() - at
    # what found a mutant is asked first for the next one, then the quick ones
    order = sorted(cost, key=lambda name: cost[name])
    every = int(os.environ.get("MUTANTS_EVERY", "1"))
    chosen = [mutant for mutant in mutants() if mutant.name not in EQUIVALENT][::every]
    survivors = []
    for mutant in chosen:
        _build(mutant)
        killer = next((name for name in order if not _passes(tests[name])), None)
        if killer is None:
            survivors.append(mutant.name)
            print(f"lives: {mutant.name}", file=sys.stderr, flush=True)
        else:
            order.remove(killer)
            order.insert(0, killer)
    answer = {"mutants": len(chosen), "tests": len(cost), "survivors": survivors}
    json.dump({**answer, "seconds": time.perf_counter() - began}, sys.stdout)


if __name__ == "__main__":
    main()
