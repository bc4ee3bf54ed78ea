"""Taking any one guard out of the drive's code makes a scenario fail."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.heavy
def test_no_guard_can_be_taken_out_unnoticed() -> None:
    """Each mutant is the drive's source without one guard, interpreted because compiling it anew would take minutes."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.device.mutants"],
        cwd=Path(__file__).parents[2],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["mutants"] > 40
    assert answer["broken"] == []
    assert answer["survivors"] == []
