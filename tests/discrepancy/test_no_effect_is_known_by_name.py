"""The method knows no effect by name: what is special about one stands in the effect's own file."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import gimbal_hil
from sim_backend.effects import CATALOGUE

ROOMS = tuple(Path(gimbal_hil.__file__).parent / "knowledge" / room for room in ("discrepancy", "improvement"))
MODULES = sorted(path for room in ROOMS for path in room.rglob("*.py"))
#: words of the field that are also names: "an inertia of" is prose, "inertia" on its own or among names is the effect
NAMES = frozenset(CATALOGUE)
ONLY_NAMES = frozenset(name for name in CATALOGUE if "_" in name)


def named(text: str) -> set[str]:
    """Effects that a string names; dotted paths of the model's numbers are no names."""
    words = re.findall(r"[\w.]+", text)
    prefixed = {name for name in ONLY_NAMES if len(words) == 1 and words[0].endswith("_") and name.startswith(words[0])}
    alone = set(words) & NAMES if words and set(words) <= NAMES else set()
    return (set(words) & ONLY_NAMES) | alone | prefixed


def strings(tree: ast.Module) -> list[tuple[int, str]]:
    """Every string of a module that is no docstring, parts of f-strings included."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    docs = {id(node.body[0].value) for node in ast.walk(tree)
            if isinstance(node, documented) and node.body and isinstance(node.body[0], ast.Expr)}  # fmt: skip
    constants = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str))
    return [(node.lineno, str(node.value)) for node in constants if id(node) not in docs]


@pytest.mark.parametrize("path", MODULES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_no_module_of_the_method_names_an_effect(path: Path) -> None:
    found = [
        (line, sorted(named(text)))
        for line, text in strings(ast.parse(path.read_text(encoding="utf-8")))
        if named(text)
    ]
    assert not found, f"{path.name}: (line, effects) {found}; what is special about an effect belongs into its own file"


@pytest.mark.parametrize(
    ("code", "effects"),
    [
        ('if effect == "backlash": pass', {"backlash"}),
        ('_CLASSES = ("viscous back_emf", "text")', {"viscous", "back_emf"}),
        ('x = f"{axis} cable_spring"', {"cable_spring"}),
        ('x = f"cogging{n}"', {"cogging"}),
        ('effect.startswith("gyro_")', {"gyro_bias", "gyro_misalignment", "gyro_scale"}),
        ('model.number(axis, "friction.viscous")', set()),
        ('"""What backlash does."""\nx = "speak of an inertia of"', set()),
    ],
)
def test_names_are_seen_where_they_decide_and_not_in_prose_or_paths(code: str, effects: set[str]) -> None:
    assert {name for _, text in strings(ast.parse(code)) for name in named(text)} == effects
