"""The mutants are interpreted: compiled code would not change with its source, and every one of them would live."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def test_the_mutants_are_not_run_on_compiled_code() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.host.mutants"],
        cwd=Path(__file__).parents[2],
        env={**os.environ, "NUMBA_DISABLE_JIT": "0"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "expected NUMBA_DISABLE_JIT=1" in done.stderr
    assert done.stdout == ""
