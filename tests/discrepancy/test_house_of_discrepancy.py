"""Nothing that searches, identifies or improves may see the antenna that made the data, or the bench's truth."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import gimbal_hil

ROOMS = ("discrepancy", "estimation", "identification", "improvement")
#: what holds an antenna's true numbers: plants and their configuration, and the bench
_PLANTS = ("tests", "sim_backend.plant", "sim_backend.device", "sim_backend.server")
#: the only modules that set antennas in motion: the one that is improved, and a rehearsal on the model itself
_ANTENNAS = {"site.py", "rehearsal.py"}
_OF_ANTENNAS = {"EmbeddedAntenna", "embedded_model_of"}
#: parts of a run's header that say nothing of its antenna's numbers
_PLAIN = {"axes", "period_ns", "title", "seed", "lockstep"}

MODULES = sorted(
    path for room in ROOMS for path in (Path(gimbal_hil.__file__).parent / "knowledge" / room).glob("**/*.py")
)


def seen_truths(source: str, drives_antennas: bool) -> Iterator[str]:
    """Every place at which a module could read a true number."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom | ast.Import):
            names = [alias.name for alias in node.names]
            modules = names if isinstance(node, ast.Import) else [node.module or ""]
            if any(m == plant or m.startswith(plant + ".") for m in modules for plant in _PLANTS):
                yield f"line {node.lineno}: imports {modules}"
            if not drives_antennas and _OF_ANTENNAS & set(names):
                yield f"line {node.lineno}: imports {names}"
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Attribute | ast.Name):
            owner = node.value.attr if isinstance(node.value, ast.Attribute) else node.value.id
            if owner == "header" and node.attr not in _PLAIN:
                yield f"line {node.lineno}: reads {node.attr} of a run's header"
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and "truth" in node.value.split("."):
            yield f"line {node.lineno}: names {node.value}"


@pytest.mark.parametrize("path", MODULES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_no_module_can_read_a_true_number(path: Path) -> None:
    assert not list(seen_truths(path.read_text(encoding="utf-8"), path.name in _ANTENNAS))


@pytest.mark.parametrize(
    "source",
    [
        "from sim_backend.plant import Plant",
        "import tests.blind.draw",
        "from gimbal_hil.knowledge.experiments import embedded_model_of",
        "model = run.record.header.model",
        "header = run.record.header\nx = header.configuration",
        "open('truth.json')",
    ],
)
def test_each_way_to_the_truth_is_noticed(source: str) -> None:
    assert list(seen_truths(source, drives_antennas=False))


def test_the_method_is_read_in_one_short_module() -> None:
    workflow = Path(gimbal_hil.__file__).parent / "knowledge" / "discrepancy" / "run.py"
    assert len(workflow.read_text(encoding="utf-8").splitlines()) < 200
