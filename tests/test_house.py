"""The rules of the house, held by tests: import direction, small modules, nothing unfinished, lint, types,
packaging.
"""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
import tomllib
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("firmware_protocol", "sim_backend", "gimbal_hil")
#: what each room must not know
ABOVE = {"firmware_protocol": {"sim_backend", "gimbal_hil"}, "sim_backend": {"gimbal_hil"}, "gimbal_hil": set()}
#: folders of gimbal_hil from the ground up: each may import those before it, none after it; docs/architecture.md draws
#: the same
FLOORS = (
    "executor",
    "control",
    "host",
    "settings",
    "runs",
    "timing",
    "telemetry",
    "plots",
    "report",
    "operator",
    "dashboard",
    "service",
    "daemon",
    "signals",
    "preflight",
    "lockstep",
    "estimation",
    "identification",
    "experiments",
    "experiments.sequences",
    "checking",
    "starting",
    "thesis",
    "discrepancy",
    "improvement",
    "demo",
    "bench",
    "bench.faults",
    "cli",
)
MODULES = sorted(path for room in ROOMS for path in (ROOT / room).rglob("*.py"))
in_a_checkout = pytest.mark.skipif(not (ROOT / "pyproject.toml").exists(), reason="needs the source checkout")


def imported(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names.add(node.module)
    return names


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_imports_go_down_only(path: Path) -> None:
    room = path.relative_to(ROOT).parts[0]
    upward = {name for name in imported(path) if name.split(".")[0] in ABOVE[room] | {"tests"}}
    assert not upward, f"{name_of(path)} imports {upward}"


def folder_of(path: Path) -> str:
    """Dotted name of the folder that a file lies in."""
    return ".".join(path.relative_to(ROOT).parts[:-1])


FACES = {folder_of(path): path for path in MODULES if path.name == "__init__.py"}
INNER = {f"{folder_of(path)}.{path.stem}" for path in MODULES if path.name != "__init__.py"}


@cache
def handed_out(folder: str) -> frozenset[str]:
    """Names in the `__all__` of a folder's face."""
    for node in ast.parse(FACES[folder].read_text()).body:
        if isinstance(node, ast.Assign) and any(
            isinstance(target, ast.Name) and target.id == "__all__" for target in node.targets
        ):
            return frozenset(ast.literal_eval(node.value))
    return frozenset()


def reached(path: Path) -> set[tuple[str, str]]:
    """(folder, name) of what a file takes from other folders: a name of the face, or an inner module where it is
    imported from one.
    """
    found: set[tuple[str, str]] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            if node.module in FACES:
                found |= {
                    (node.module, alias.name) for alias in node.names if f"{node.module}.{alias.name}" not in FACES
                }
            elif node.module in INNER:
                found.add(tuple(node.module.rsplit(".", 1)))  # type: ignore[arg-type]
        elif isinstance(node, ast.Import):
            found |= {tuple(alias.name.rsplit(".", 1)) for alias in node.names if alias.name in INNER}  # type: ignore[misc]
    return {(folder, name) for folder, name in found if folder != folder_of(path)}


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_a_folder_is_entered_through_its_face(path: Path) -> None:
    inside = {f"{folder}.{name}" for folder, name in reached(path) if name not in handed_out(folder)}
    assert not inside, f"{name_of(path)} imports {sorted(inside)}, which the face of the folder does not hand out"


@pytest.mark.parametrize(
    "path", [path for path in MODULES if path.relative_to(ROOT).parts[0] == "gimbal_hil"], ids=name_of
)
def test_no_arrow_between_folders_leads_up(path: Path) -> None:
    floor = folder_of(path).removeprefix("gimbal_hil").removeprefix(".")
    used = {folder.removeprefix("gimbal_hil.") for folder, _ in reached(path) if folder.startswith("gimbal_hil.")}
    above = {other for other in used if not floor or FLOORS.index(other) > FLOORS.index(floor)}
    assert not above, f"{name_of(path)} imports {sorted(above)}, which lies above it"


@pytest.mark.parametrize("folder", sorted(FACES))
def test_a_face_hands_out_only_what_there_is(folder: str) -> None:
    module = importlib.import_module(folder)
    missing = {name for name in handed_out(folder) if not hasattr(module, name) and f"{folder}.{name}" not in INNER}
    assert not missing, f"{folder}.__all__ has {sorted(missing)}"
    if folder.startswith("gimbal_hil"):
        # offsets into an array are read best with the module that lists them; everything else is handed out by name
        modules = {name for name in handed_out(folder) if isinstance(getattr(module, name, None), ModuleType)}
        assert modules <= {"layout"}, f"{folder} hands out the modules {sorted(modules)} in place of their names"


@in_a_checkout
def test_the_page_on_the_architecture_draws_the_floors_in_their_order() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text()
    drawn = re.findall(r"^\| `gimbal_hil/([\w/]+)` \|", page, re.MULTILINE)
    assert [name.replace("/", ".") for name in drawn] == [floor for floor in FLOORS if f"gimbal_hil.{floor}" in FACES][
        ::-1
    ]


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_a_module_does_one_thing_in_about_four_hundred_lines(path: Path) -> None:
    assert path.read_text().count("\n") <= 420
    assert path.stem not in {"utils", "util", "helpers", "helper", "common", "misc", "manager", "managers"}


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_no_wall_clock_outside_the_clock_and_nothing_unfinished(path: Path) -> None:
    text = path.read_text()
    assert not any(word in text for word in ("TO" + "DO", "FIX" + "ME", "NotImplemented" + "Error")), name_of(path)
    if path.name not in {"clock.py"}:
        assert "time.time()" not in text


def test_help_needs_nothing_heavy() -> None:
    heavy = ("numpy", "numba", "scipy", "plotly", "pyarrow", "pydantic", "typer", "can", "serial")
    code = (
        "import sys; sys.argv = ['gimbal-hil', '--help']\n"
        "from gimbal_hil.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        f"print([m for m in {heavy!r} if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"
    assert "discrepancy" in done.stdout


@in_a_checkout
def test_every_package_is_in_the_distribution() -> None:
    listed = set(tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"])
    there = {".".join(path.parent.relative_to(ROOT).parts) for path in MODULES}
    assert listed == there | {f"gimbal_hil.config{below}" for below in ("", ".models", ".plans", ".schemas")}


@in_a_checkout
@pytest.mark.skipif(find_spec("ruff") is None, reason="ruff is not installed")
def test_ruff_has_nothing_to_say() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "ruff", "check", *ROOMS, "tests"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout[-4000:]


@in_a_checkout
def test_mypy_is_content_with_the_three_rooms() -> None:
    pytest.importorskip("mypy")
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:]
