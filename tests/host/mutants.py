"""The host's guards with one piece changed at a time, made from their own source and interpreted: prints as JSON which
mutants no test noticed.

A mutant takes a condition away, turns a comparison round, drops one half of an `and` or `or`, forgets a sign, or
answers that all is well. In a first pass over the tests every change is only computed beside the original: a test in
which a change never makes a difference cannot notice it, and is not asked.
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

from tests.interpreted import refuse_compiled
from tests.ledger import Ledger, key_of

_PACKAGE = "gimbal_hil.loop.host"
#: in the order of import, so that each one takes the changed names of those before it
_NAMES = (
    *("event_ring", "identity", "repeating", "plausibility", "limits", "reactions", "reception", "drive", "following"),
    *("acting", "core"),
)
_MODULES = {name: importlib.import_module(f"{_PACKAGE}.{name}") for name in _NAMES}
_MODULES["refusing"] = importlib.import_module("gimbal_hil.realtime.daemon.refusing")
#: where the guards are
GUARDS = {
    "identity": ("receive_identity", "is_known", "is_refused", "_refusal", "_units_differ"),
    "plausibility": (
        *("watch_status", "watch_sensors", "implausible", "_acting_torque", "_weights", "_is_noisy"),
        *(
            "_parts_slowly",
            "_watch_noise",
            "_is_turned_round",
            "_watch_quiet",
            "_window",
            "_watch_place",
            "has_jumped",
            "accept_places",
            "_held",
        ),
    ),
    "repeating": ("watch_repeats", "_has_period", "_are_alike"),
    "reception": ("_periods_since",),
    "limits": (
        "braking",
        "fault_of",
        "stop_cause",
        "limit_ahead",
        "rates_towards_limits",
        "_rate_before",
        "report_beyond_limits",
        "_moving_rate",
        "_reached",
        "_counted",
        "_fault_of_axis",
    ),
    "reactions": ("stop_kind",),
    "drive": ("may_reset_fault", "_brake_of"),
    "refusing": ("why_not_adjusted",),
    "core": ("_take_requests", "_supervise", "_synchronise", "_leave_fault", "_check_limits", "_stop"),
}
TESTS = (
    *("test_plausibility", "test_either_way", "test_guards", "test_identity", "test_connecting"),
    *("test_places", "test_limits_of_an_axis", "test_supervisor", "test_following", "test_antenna_that_catches_up"),
    *("test_braking", "test_refusing", "test_one_sensor"),
)
_ROOMS = {"test_refusing": "daemon"}
_TURNED = {ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq}
#: what a guard answers when it trips
_CAUSES = (
    *("_PROTOCOL", "_NAME", "_SERIAL", "_TORQUE_RANGE", "_FROZEN", "_DRIFT", "_STUCK", "_RUNAWAY", "_OVERSPEED"),
    *("_DISAGREE", "_FOLLOWING", "_TRAVEL", "_WRAP", "_TEMPERATURE", "_RAMP", "_JUMP", "cause"),
)
#: mutants that change nothing that can be seen, and why
EQUIVALENT = {
    "identity.is_refused: G[IDENTITY] == IDENTITY_HEARD and G[REFUSAL] != _NONE -> G[REFUSAL] != _NONE": (
        "asked only where both frames were heard: before that the host waits, and a refusal is a fault at once"
    ),
    "plausibility._acting_torque: if limits == 0 -> never": "a short way: without a flag nothing is cut below either",
    "plausibility._weights: C[EXPECTS_WEIGHT] == 0.0 or"
    " (G[AXIS_G + MODE] == 0 and G[AXIS_G + AXIS_G_SIZE + MODE] == 0) ->"
    " G[AXIS_G + MODE] == 0 and G[AXIS_G + AXIS_G_SIZE + MODE] == 0": "moments that are not expected are zero",
    "plausibility._weights: C[EXPECTS_WEIGHT] == 0.0 or"
    " (G[AXIS_G + MODE] == 0 and G[AXIS_G + AXIS_G_SIZE + MODE] == 0) -> C[EXPECTS_WEIGHT] == 0.0": (
        "what an axis without torque gained is forgotten"
    ),
    "plausibility._weights: if C[EXPECTS_WEIGHT] == 0.0 or"
    " (G[AXIS_G + MODE] == 0 and G[AXIS_G + AXIS_G_SIZE + MODE] == 0) -> never": (
        "a short way: moments that are not expected are zero, and what an axis without torque gained is forgotten"
    ),
    "plausibility.implausible: grown and _is_turned_round(H, h) -> grown": (
        "what the torque turned round does not explain is quiet itself, so that nothing has grown beyond it"
    ),
    "plausibility._window: if ticks == 1 -> never": "a short way: for one tick the formula gives the same bits",
    "repeating.watch_repeats: G[g + SAID_COUNT] % _EVERY == 0 -> G[g + SAID_COUNT] % _EVERY != 0": (
        "a look at other samples, and at more of them, finds the same some samples sooner"
    ),
    "repeating._has_period: H[at + before] == H[at + newest] and _are_alike(H, at, count, period)"
    " -> _are_alike(H, at, count, period)": "a short way: the newest sample is one of those that must be alike",
    "core._take_requests: if requests == 0 -> never": "a short way: without a bit nothing below does anything",
}


@dataclass(frozen=True)
class Mutant:
    """One change in one function: `instead` of the node at `place`."""

    module: str
    function: str
    text: str
    place: int
    instead: Any
    key: str

    @property
    def name(self) -> str:
        """Which it is, as in EQUIVALENT."""
        return f"{self.module}.{self.function}: {self.text}"

    def tree(self) -> ast.Module:
        """Its module with the change made."""
        whole = ast.parse(_source(_MODULES[self.module]))
        for at, function in enumerate(whole.body):
            if isinstance(function, ast.FunctionDef) and function.name == self.function:
                whole.body[at] = _Replacing(self.place, copy.deepcopy(self.instead)).visit(function)
        return ast.fix_missing_locations(whole)


def _changes(node: ast.AST) -> Iterator[tuple[str, Any]]:
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

    def visit(self, node: ast.AST) -> Any:
        self._seen += 1
        return self._instead if self._seen == self._place else self.generic_visit(node)


def mutants() -> Iterator[Mutant]:
    """Every mutant of every guard."""
    for module, functions in GUARDS.items():
        for function in _functions(ast.parse(_source(_MODULES[module])), functions):
            for place, node in enumerate(_in_order(function)):
                for text, instead in _changes(node):
                    key = key_of(f"{module}.{function.name}: {text}", place, function)
                    yield Mutant(module, function.name, text, place, copy.deepcopy(instead), key)


def _functions(tree: ast.Module, names: tuple[str, ...]) -> list[ast.FunctionDef]:
    return [node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name in names]


class _Probing(ast.NodeTransformer):
    """Computes changes beside the original and tells `_differs` about them."""

    def __init__(self, changes: dict[ast.AST, list[tuple[int, Any]]]) -> None:
        self._changes = changes

    def visit(self, node: ast.AST) -> Any:
        changes = self._changes.get(node, [])
        probed: Any = self.generic_visit(node)
        for number, instead in changes:
            if isinstance(probed, ast.If):
                probed.test = _probe(number, probed.test, ast.Constant(False))
            elif isinstance(probed, ast.Return):
                probed.value = _probe(number, probed.value, ast.Constant(None))
            else:
                probed = _probe(number, probed, instead)
        return probed


def _probe(number: int, value: Any, instead: Any) -> ast.expr:
    nothing = ast.arguments(posonlyargs=[], args=[], kwonlyargs=[], kw_defaults=[], defaults=[])
    changed = ast.Lambda(nothing, copy.deepcopy(instead))
    return ast.Call(ast.Name("_differs", ast.Load()), [ast.Constant(number), value, changed], [])


def _noticing(tests: dict[str, Callable[[], None]], chosen: list[Mutant]) -> tuple[dict[str, float], list[set[str]]]:
    """What each test costs that passes, and for each mutant the tests in which it makes a difference."""
    seen: set[int] = set()

    def differs(number: int, value: Any, changed: Callable[[], Any]) -> Any:
        if number not in seen:
            try:
                same = bool(value == changed())
            except Exception:
                same = False
            if not same:
                seen.add(number)
        return value

    for name, module in _MODULES.items():
        tree = ast.parse(_source(module))
        changes: dict[ast.AST, list[tuple[int, Any]]] = {}
        for function in _functions(tree, GUARDS.get(name, ())):
            nodes = list(_in_order(function))
            for number, mutant in enumerate(chosen):
                if (mutant.module, mutant.function) == (name, function.name):
                    changes.setdefault(nodes[mutant.place], []).append((number, mutant.instead))
        vars(module)["_differs"] = differs
        _execute(module, ast.fix_missing_locations(_Probing(changes).visit(tree)))
    cost: dict[str, float] = {}
    noticing: list[set[str]] = [set() for _ in chosen]
    for name, test in tests.items():
        at = time.perf_counter()
        seen.clear()
        if _passes(test):
            cost[name] = time.perf_counter() - at
            for number in seen:
                noticing[number].add(name)
    return cost, noticing


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
        _execute(module, mutant.tree() if mutant is not None and mutant.module == name else _source(module))


def _execute(module: ModuleType, tree: Any) -> None:
    assert module.__file__ is not None
    exec(compile(tree, module.__file__, "exec"), module.__dict__)


def _tests() -> dict[str, Callable[[], None]]:
    """Every test with every of its parameters, by name."""
    found: dict[str, Callable[[], None]] = {}
    names = [name for name in TESTS if any(text in name for text in _words("MUTANTS_TESTS"))]
    for module in (importlib.import_module(f"tests.{_ROOMS.get(name, 'host')}.{name}") for name in names):
        for name, function in vars(module).items():
            if not name.startswith("test_") or not callable(function):
                continue
            marks = [mark for mark in getattr(function, "pytestmark", ()) if mark.name == "parametrize"]
            for values in itertools.product(*(mark.args[1] for mark in marks)):
                given: dict[str, Any] = {}
                for mark, value in zip(marks, values, strict=True):
                    keys = mark.args[0] if isinstance(mark.args[0], tuple | list) else mark.args[0].split(",")
                    given |= zip((key.strip() for key in keys), value if len(keys) > 1 else (value,), strict=True)
                found[f"{name}{list(given.values()) or ''}"] = functools.partial(function, **given)
    return found


def _words(variable: str) -> list[str]:
    """What one of these words is in is taken; everything where there are none."""
    return os.environ.get(variable, "").split(",")


def _passes(test: Callable[[], None]) -> bool:
    try:
        test()
    except Exception:
        return False
    return True


def main() -> None:
    """Mutants, those that live, and how long it took; `MUTANTS_EVERY=n` takes every n-th one, `MUTANTS_OF=text,text`
    those with one of these texts in their names, `MUTANTS_TESTS=text,text` likewise tests by their files (those that
    they leave alive are not told to live); the rest is `tests.ledger`'s.
    """
    # compiled code is not changed with its source: every mutant would live
    refuse_compiled("tests.host.mutants")
    began, tests, ledger = time.perf_counter(), _tests(), Ledger()
    every, of = int(os.environ.get("MUTANTS_EVERY", "1")), _words("MUTANTS_OF")
    named = [mutant for mutant in mutants() if mutant.name not in EQUIVALENT]
    chosen = [mutant for mutant in named if any(text in mutant.name for text in of)][::every]
    open_ones = [mutant for mutant in chosen if not ledger.knows(mutant.key)]

    def build(number: int | None) -> Callable[[str], bool]:
        _build(None if number is None else open_ones[number])
        return lambda name: _passes(tests[name])

    ledger.ask_hinted([one.key for one in open_ones], tests, build)
    open_ones = [mutant for mutant in open_ones if not ledger.knows(mutant.key)]
    print(f"{len(open_ones)} left after the hints", file=sys.stderr, flush=True)
    cost, noticing = _noticing(tests, open_ones) if open_ones else ({}, [])
    whole = "MUTANTS_TESTS" not in os.environ
    print(f"{len(tests)} tests once: {time.perf_counter() - began:.0f} s", file=sys.stderr, flush=True)
    ledger.ask([(one.key, found) for one, found in zip(open_ones, noticing, strict=True)], cost, build, whole)
    answer = ledger.answer([(mutant.key, mutant.name) for mutant in chosen])
    json.dump({**answer, "seconds": time.perf_counter() - began}, sys.stdout)


if __name__ == "__main__":
    main()
