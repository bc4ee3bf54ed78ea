"""Which compiled functions differ from commit to commit: `python -m tests.benchmarks.compiled_functions COMMIT ...`.

Compared are syntax trees without docstrings and decorators, wherever a function stands. A move between files, a rename
of a file or another face therefore changes none. Values of constants that they name are not compared.
"""

from __future__ import annotations

import ast
import itertools
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
#: where the compiled path has its functions
FOLDERS = (
    "sim_backend",
    "firmware_protocol",
    "gimbal_hil/loop/host",
    "gimbal_hil/realtime/lockstep",
    "gimbal_hil/loop/control",
)
_COMPILED = {"compiled", "part", "entry_point", "assembled_entry_point"}


def _git(*words: str) -> str:
    return subprocess.run(["git", "-C", str(ROOT), *words], check=True, capture_output=True, text=True).stdout


def compiled_functions(commit: str) -> set[tuple[str, str]]:
    """(name, syntax tree) of every compiled function of a commit."""
    found: set[tuple[str, str]] = set()
    for path in _git("ls-tree", "-r", "--name-only", commit, *FOLDERS).split():
        if path.endswith(".py"):
            for node in ast.walk(ast.parse(_git("show", f"{commit}:{path}"))):
                if isinstance(node, ast.FunctionDef) and any(_name(one) in _COMPILED for one in node.decorator_list):
                    node.decorator_list = []
                    if ast.get_docstring(node) is not None:
                        node.body = node.body[1:] or [ast.Pass()]
                    found.add((node.name, ast.dump(node)))
    return found


def _name(decorator: ast.expr) -> str:
    """Of a decorator, called or not."""
    named = decorator.func if isinstance(decorator, ast.Call) else decorator
    return named.id if isinstance(named, ast.Name) else ""


def main(commits: list[str]) -> int:
    """One line for each pair of commits that follow each other."""
    if len(commits) < 2:
        print(__doc__)
        return 2
    before = compiled_functions(commits[0])
    for earlier, later in itertools.pairwise(commits):
        after = compiled_functions(later)
        names = sorted({name for name, _ in before ^ after})
        shown = " ".join(names[:6]) + (" ..." if len(names) > 6 else "")
        print(f"{earlier}..{later}: {len(names)} of {len({name for name, _ in after})} differ {shown}".rstrip())
        before = after
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
