"""The drawn structure of `gimbal_hil` in figures: `python -m tests.structure [CHECKOUT]`, this one or any other."""

from __future__ import annotations

import ast
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from tests.test_house import FLOORS, ROOT

PACKAGE = "gimbal_hil"


@dataclass(frozen=True)
class Structure:
    """Folders with their files; imports between folders (from, to), through a face and of an inner module."""

    folders: tuple[str, ...]
    through_faces: tuple[tuple[str, str], ...]
    of_inner_modules: tuple[tuple[str, str, str], ...]

    @property
    def upward(self) -> tuple[tuple[str, str], ...]:
        """Arrows from a folder to one above it, in the order of FLOORS; folders that this order lacks are left out."""
        pairs = {*self.through_faces, *((start, end) for start, end, _ in self.of_inner_modules)}
        known = [pair for pair in pairs if all(one in FLOORS for one in pair)]
        return tuple(sorted((start, end) for start, end in known if FLOORS.index(end) > FLOORS.index(start)))


def structure_of(checkout: Path) -> Structure:
    """Counted over the syntax tree of every module: one for each `from ... import` that leaves its folder."""
    root = checkout / PACKAGE
    modules = sorted(root.rglob("*.py"))
    faces = {_dotted(path.parent, checkout) for path in modules if path.name == "__init__.py"}
    through: list[tuple[str, str]] = []
    inner: list[tuple[str, str, str]] = []
    for path in modules:
        here = _dotted(path.parent, checkout)
        for node in ast.walk(ast.parse(path.read_text())):
            if not (isinstance(node, ast.ImportFrom) and node.module and node.module.startswith(f"{PACKAGE}.")):
                continue
            folder, _, module = node.module.rpartition(".")
            if node.module in faces:
                if node.module != here:
                    through.append((_short(here), _short(node.module)))
            elif folder != here:
                inner.append((_short(here), _short(folder), module))
    return Structure(tuple(sorted(map(_short, faces))), tuple(through), tuple(inner))


def _dotted(folder: Path, checkout: Path) -> str:
    return ".".join(folder.relative_to(checkout).parts)


def _short(name: str) -> str:
    return name.removeprefix(PACKAGE).removeprefix(".")


def main(arguments: list[str]) -> int:
    """Print the figures of a checkout."""
    found = structure_of(Path(arguments[0]) if arguments else ROOT)
    if not found.folders:
        print(f"{arguments[0]}: no checkout with a folder {PACKAGE}", file=sys.stderr)
        return 2
    print(f"folders below {PACKAGE}: {len(found.folders) - 1}")
    print(f"imports between them through a face: {len(found.through_faces)}")
    modules = Counter(module for *_, module in found.of_inner_modules)
    print(f"of inner modules: {modules.total()}:", ", ".join(f"{name} {n}" for name, n in modules.most_common()))
    print(f"arrows up: {len(found.upward)}", *(f"\n  {start or PACKAGE} -> {end}" for start, end in found.upward))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
