"""Modules of the tests that are worth something only where the code runs interpreted."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

_SWITCH = "NUMBA_DISABLE_JIT"


def run_interpreted(module: str) -> str:
    """What the module prints in a process of its own whose kernels are interpreted; AssertionError where it fails."""
    done = subprocess.run(
        [sys.executable, "-m", module],
        cwd=Path(__file__).parents[1],
        env={**os.environ, _SWITCH: "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def refuse_compiled(module: str) -> None:
    """End with 1 and how to start the module where kernels are compiled: they do not change with their source."""
    if os.environ.get(_SWITCH) != "1":
        name = module.rsplit(".", 1)[-1]
        sys.exit(f"{name}: {_SWITCH} is not 1; expected {_SWITCH}=1 python -m {module}")
