"""Identification never reads what a run says about the antenna that made it."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import gimbal_hil.knowledge.identification

MODULES = sorted(Path(gimbal_hil.knowledge.identification.__file__).parent.rglob("*.py"))
#: the only things of a run that a measurement consists of, and what they are to be read by: version of the wire, names
#: of the axes
SEEN = {"ticks", "frames", "events", "notes", "folder", "protocol", "record.header.axes"}
#: files and modules that could bring it in by another way
FORBIDDEN_IMPORTS = (
    "gimbal_hil.loop.settings",
    "gimbal_hil.data.runs.header",
    "sim_backend.device",
    "sim_backend.plant",
    "sim_backend.server",
)


def runs_in(function: ast.FunctionDef) -> set[str]:
    """Names in a function that hold a run: arguments of type Run, and what `open_run` answers."""
    names = {a.arg for a in function.args.args if isinstance(a.annotation, ast.Name) and a.annotation.id == "Run"}
    for node in ast.walk(function):
        if (
            isinstance(node, ast.Assign)
            and isinstance(node.value, ast.Call)
            and getattr(node.value.func, "id", "") == "open_run"
        ):
            names |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    return names


def read_of(function: ast.FunctionDef) -> set[str]:
    """What a function reads of its runs, as far as the dots go (`record.header.axes`)."""
    runs, inner, found = runs_in(function), set(), []
    for node in ast.walk(function):
        if isinstance(node, ast.Attribute) and node not in inner:
            parts, at = [], node
            while isinstance(at, ast.Attribute):
                inner.add(at)
                parts.append(at.attr)
                at = at.value
            if isinstance(at, ast.Name) and at.id in runs:
                found.append(".".join(reversed(parts)))
    return {next((seen for seen in SEEN if one == seen or one.startswith(f"{seen}.")), one) for one in found}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.name)
def test_of_a_run_only_frames_ticks_and_events_are_read(path: Path) -> None:
    for function in ast.walk(ast.parse(path.read_text())):
        if isinstance(function, ast.FunctionDef):
            hidden = read_of(function) - SEEN
            assert not hidden, f"{path.name}: {function.name} reads {sorted(hidden)} of a run"


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.name)
def test_nothing_is_imported_that_knows_the_antenna(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            assert not (node.module or "").startswith(FORBIDDEN_IMPORTS), f"{path.name} imports {node.module}"
            names = {alias.name for alias in node.names}
            assert not names & {"load_model", "shipped_model", "read_header"}, f"{path.name} opens models by itself"


def test_the_guard_sees_a_run_that_is_read_where_it_should_not_be() -> None:
    guilty = ast.parse(
        "def peek(run: Run) -> float:\n    return run.record.model.number('outer', 'friction.viscous')\n"
    ).body[0]
    assert isinstance(guilty, ast.FunctionDef) and read_of(guilty) == {"record.model.number"}
