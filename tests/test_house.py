"""The rules of the house, held by tests: import direction, small modules, nothing unfinished, lint, types, packaging."""

from __future__ import annotations

import ast
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("firmware_protocol", "sim_backend", "gimbal_hil")
#: what each room must not know
ABOVE = {"firmware_protocol": {"sim_backend", "gimbal_hil"}, "sim_backend": {"gimbal_hil"}, "gimbal_hil": set()}
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
    assert listed == there | {"gimbal_hil.config", "gimbal_hil.config.models", "gimbal_hil.config.plans"}


@in_a_checkout
@pytest.mark.skipif(shutil.which("ruff") is None and not (Path(sys.executable).parent / "ruff").exists(), reason="ruff is not installed")
def test_ruff_has_nothing_to_say() -> None:
    done = subprocess.run([sys.executable, "-m", "ruff", "check", *ROOMS, "tests"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:]


@in_a_checkout
def test_mypy_is_content_with_the_three_rooms() -> None:
    pytest.importorskip("mypy")
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:]
