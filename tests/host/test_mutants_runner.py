"""The mutants are interpreted: compiled code would not change with its source, and every one of them would live."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.parametrize("module", ["tests.host.mutants", "tests.device.mutants"])
def test_the_mutants_are_not_run_on_compiled_code(module: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", module],
        cwd=Path(__file__).parents[2],
        env={**os.environ, "NUMBA_DISABLE_JIT": "0"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert f"expected NUMBA_DISABLE_JIT=1 python -m {module}" in done.stderr
    assert done.stdout == ""
