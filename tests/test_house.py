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
from collections.abc import Callable, Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import pytest
import yaml

from firmware_protocol.interpreter import apart_from_the_users_folder
from gimbal_hil.moved import DISTRICT_OF

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("firmware_protocol", "sim_backend", "gimbal_hil")
#: what each room must not know
ABOVE = {"firmware_protocol": {"sim_backend", "gimbal_hil"}, "sim_backend": {"gimbal_hil"}, "gimbal_hil": set()}
#: districts of gimbal_hil from the ground up, and in each its rooms from the ground up: a room may import those before
#: it, none after it; docs/explanation/architecture.md draws the same
DISTRICTS = {
    "loop": ("control", "host", "settings", "timing"),
    "pages": ("plots", "antenna", "report"),
    "data": ("runs", "tables", "containers", "signals", "arms", "exports", "catalogue", "preflight"),
    "realtime": (
        "lockstep",
        "telemetry",
        "operator",
        "foxglove",
        "mavlink",
        "observing",
        "dashboard",
        "service",
        "daemon",
    ),
    "knowledge": (
        "executor",
        "estimation",
        "identification",
        "experiments",
        "experiments.sequences",
        "model_exports",
        "drive_tables",
        "tuning",
        "discrepancy.twin",
        "discrepancy.noise",
        "discrepancy.hypotheses",
        "discrepancy.inquiry",
        "discrepancy.search",
        "discrepancy.laws",
        "discrepancy.judgement",
        "discrepancy.verdict",
        "discrepancy",
        "change",
        "improvement",
    ),
    "proof": ("campaign", "thesis", "bench", "bench.faults", "conformance"),
    "pointing": ("arena", "following", "certifying"),
    "surface": ("checking", "starting", "demo", "library", "testing", "deployment", "warming", "cli"),
}
FLOORS = tuple(
    floor for district, rooms in DISTRICTS.items() for floor in (*(f"{district}.{room}" for room in rooms), district)
)
MODULES = sorted(path for room in ROOMS for path in (ROOT / room).rglob("*.py"))
in_a_checkout = pytest.mark.skipif(not (ROOT / "pyproject.toml").exists(), reason="needs the source checkout")


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def offences(rule: Callable[[Path], Iterable[object]], paths: Iterable[Path] = MODULES) -> dict[str, list[object]]:
    """What a rule finds in each module, by name; modules that keep it are left out. One test a rule: a test for each
    module took longer to begin than to run.
    """
    found = {name_of(path): sorted(rule(path), key=str) for path in paths}
    return {name: said for name, said in found.items() if said}


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """Every node of a module's source."""
    return tuple(ast.walk(ast.parse(path.read_text())))


def imported(path: Path) -> set[str]:
    names: set[str] = set()
    for node in nodes(path):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names.add(node.module)
    return names


def test_imports_go_down_only() -> None:
    def upward(path: Path) -> set[str]:
        above = ABOVE[path.relative_to(ROOT).parts[0]] | {"tests"}
        return {name for name in imported(path) if name.split(".")[0] in above}

    assert not offences(upward)


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
    for node in nodes(path):
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


def test_a_folder_is_entered_through_its_face() -> None:
    """Nothing is imported that the face of its folder does not hand out."""

    def inside(path: Path) -> set[str]:
        return {f"{folder}.{name}" for folder, name in reached(path) if name not in handed_out(folder)}

    assert not offences(inside)


def test_no_arrow_between_folders_leads_up() -> None:
    def above(path: Path) -> set[str]:
        floor = folder_of(path).removeprefix("gimbal_hil").removeprefix(".")
        used = {folder.removeprefix("gimbal_hil.") for folder, _ in reached(path) if folder.startswith("gimbal_hil.")}
        if not floor:
            # the package's own face hands out the library, loaded when it is asked for
            return used - {"surface.library"}
        return {one for one in used if FLOORS.index(one) > FLOORS.index(floor)}

    assert not offences(above, [path for path in MODULES if path.relative_to(ROOT).parts[0] == "gimbal_hil"])


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
    page = (ROOT / "docs" / "explanation" / "architecture.md").read_text()
    drawn = re.findall(r"^\| `gimbal_hil/([\w/]+)` \|", page, re.MULTILINE)
    rooms = [floor for floor in FLOORS if f"gimbal_hil.{floor}" in FACES and floor not in DISTRICTS]
    assert [name.replace("/", ".") for name in drawn] == rooms[::-1]
    assert re.findall(r"^\| \*\*`gimbal_hil/(\w+)/`\*\* \|", page, re.MULTILINE) == list(DISTRICTS)[::-1]


@pytest.mark.parametrize("district", DISTRICTS)
def test_the_face_of_a_district_says_what_lives_in_each_of_its_rooms(district: str) -> None:
    said = importlib.import_module(f"gimbal_hil.{district}").__doc__ or ""
    faces = [path for path in MODULES if path.name == "__init__.py"]
    rooms = {path.parent.name for path in faces if path.parts[-4:-2] == ("gimbal_hil", district)}
    assert (
        rooms
        and rooms
        == set(re.findall(r"^(\w+) {2,}\w", said, re.MULTILINE))
        | set(re.findall(r"^(\w{9,}) {1,}\w.*$", said, re.MULTILINE)) & rooms
    )
    assert said.count("\n") <= 14


@pytest.mark.parametrize("old", sorted(DISTRICT_OF))
def test_a_name_from_before_the_districts_is_the_same_module(old: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"gimbal_hil.{old} is gimbal_hil.{DISTRICT_OF[old]}.{old} now"):
        sys.modules.pop(f"gimbal_hil.{old}", None)
        module = importlib.import_module(f"gimbal_hil.{old}")
    assert module is importlib.import_module(f"gimbal_hil.{DISTRICT_OF[old]}.{old}")
    assert module.__spec__ is not None and module.__spec__.name == f"gimbal_hil.{DISTRICT_OF[old]}.{old}"


def test_no_module_says_a_name_from_before_the_districts() -> None:
    old = re.compile(rf"\bgimbal_hil\.({'|'.join(DISTRICT_OF)})\b")
    said = [name_of(path) for path in MODULES if path.name != "moved.py" and old.search(path.read_text())]
    assert not said


def test_public_names_of_pointing_stay_at_their_old_place() -> None:
    from gimbal_hil import pointing
    from gimbal_hil.pointing import following

    assert all(getattr(pointing, name) is getattr(following, name) for name in following.__all__)
    # the folder that gives them may be what is imported first
    alone = [sys.executable, "-c", "from gimbal_hil.pointing import following"]
    assert subprocess.run(alone, check=False, timeout=120).returncode == 0


@in_a_checkout
def test_every_page_of_the_docs_is_in_their_index() -> None:
    index = (ROOT / "docs" / "README.md").read_text()
    kinds = ("tutorials", "how-to", "explanation", "reference", "measurements")
    pages = {f"{kind}/{path.name}" for kind in kinds for path in (ROOT / "docs" / kind).glob("*.md")}
    shown = set(re.findall(r"\]\((\w[\w/-]*\.md)\)", index))
    assert shown <= pages | {"decisions/README.md"} and {page for page in pages if "how-to/" not in page} <= shown
    assert [path.name for path in (ROOT / "docs").glob("*.md")] == ["README.md"]


def test_a_module_does_one_thing_in_about_four_hundred_lines() -> None:
    vague = {"utils", "util", "helpers", "helper", "common", "misc", "manager", "managers"}
    assert not offences(lambda path: {lines for lines in [path.read_text().count("\n")] if lines > 420})
    assert not offences(lambda path: vague & {path.stem})


#: emitted from the schema of the wire, one branch a field
EMITTED = {"firmware_protocol/field_words.py"}


def test_a_function_is_read_on_one_screen() -> None:
    def long(path: Path) -> set[str]:
        functions = (node for node in nodes(path) if isinstance(node, ast.FunctionDef))
        return {node.name for node in functions if (node.end_lineno or 0) - node.lineno >= 80}

    assert not offences(long, [path for path in MODULES if name_of(path) not in EMITTED])


def test_a_class_name_means_one_thing() -> None:
    places: dict[str, list[str]] = {}
    for path in MODULES:
        for node in nodes(path):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places.setdefault(node.name, []).append(name_of(path))
    assert not {name: found for name, found in places.items() if len(found) > 1}


def test_no_wall_clock_outside_the_clock_and_nothing_unfinished() -> None:
    unfinished = "TO" + "DO", "FIX" + "ME", "NotImplemented" + "Error"

    def said(path: Path) -> list[str]:
        words = unfinished if path.name == "clock.py" else (*unfinished, "time.time()")
        return [word for word in words if word in path.read_text()]

    assert not offences(said)


def test_help_needs_nothing_heavy() -> None:
    heavy = ("numpy", "numba", "scipy", "plotly", "pyarrow", "pydantic", "typer", "can", "serial")
    code = (
        "import sys; sys.argv = ['gimbal-hil', '--help']\n"
        "from gimbal_hil.surface.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        f"print([m for m in {heavy!r} if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"
    assert "discrepancy" in done.stdout


def test_what_is_started_does_not_read_modules_of_the_folder_where_the_user_stands() -> None:
    # the bench of the start is a bare interpreter; the blind bench is in the checkout; a service is a program's path
    own_way = {
        "gimbal_hil/proof/bench/speed.py",
        "gimbal_hil/proof/bench/blind.py",
        "gimbal_hil/surface/cli/service.py",
    }
    starting = [path for path in MODULES if "sys.executable" in path.read_text() and name_of(path) not in own_way]
    assert len(starting) == 7
    assert [name_of(path) for path in starting if not _starts_apart(ast.parse(path.read_text()))] == []


def _starts_apart(module: ast.Module) -> bool:
    blocks = [node for node in ast.walk(module) if isinstance(node, ast.With)]
    apart = [block for block in blocks if "apart_from_the_users_folder()" in map(ast.unparse, block.items)]
    inside = {node for block in apart for node in ast.walk(block)}
    calls = (node for node in ast.walk(module) if isinstance(node, ast.Call))
    starts = {call for call in calls if ast.unparse(call.func) in ("subprocess.Popen", "subprocess.run")}
    return bool(starts) and starts <= inside


def test_a_module_of_the_users_folder_takes_no_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "signal.py").write_text("raise SystemExit('the wrong one')")
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)

    def said() -> bytes:
        words = [sys.executable, "-m", "gimbal_hil.realtime.service"]
        return subprocess.run(words, cwd=tmp_path, input=b"", capture_output=True).stderr

    with apart_from_the_users_folder():
        assert b"the wrong one" not in said()
    # it is what keeps the module out, and what a user's own script starts afterwards is as before
    assert b"the wrong one" in said()


@in_a_checkout
def test_every_package_is_in_the_distribution() -> None:
    listed = set(tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"])
    there = {".".join(path.parent.relative_to(ROOT).parts) for path in MODULES}
    assert listed == there | {
        f"gimbal_hil.config{below}" for below in ("", ".models", ".plans", ".scenarios", ".schemas")
    }


@in_a_checkout
@pytest.mark.parametrize(
    ("message", "refused"),
    [
        ("a" * 71, False),
        ("a" * 72, True),
        ("Short\n\n" + "a long line of the body " * 10, False),
        ("b" * 71 + "\n# " + "-" * 90, False),
    ],
)
def test_a_subject_of_72_characters_or_more_is_refused_by_the_hook(message: str, refused: bool) -> None:
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"][0]["hooks"]
    hook = next(hook for hook in hooks if hook.get("stages") == ["commit-msg"])
    assert hook["language"] == "pygrep" and hook["args"] == ["--multiline"]
    # as pre-commit searches with --multiline: the whole file at once
    assert bool(re.search(hook["entry"].encode(), message.encode(), re.MULTILINE | re.DOTALL)) is refused


@in_a_checkout
@pytest.mark.skipif(find_spec("ruff") is None, reason="ruff is not installed")
def test_ruff_has_nothing_to_say() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "ruff", "check", *ROOMS, "tests"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout[-4000:]


@in_a_checkout
def test_mypy_is_content_with_the_three_rooms() -> None:
    pytest.importorskip("mypy", reason="mypy is not installed (the extra lint has it)")
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:]
