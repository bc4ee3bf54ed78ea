"""The blind bench lives with the tests, because it must share no code with what it tests; this only starts it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from firmware_protocol.errors import BadInputError

_CHECKOUT = Path(__file__).resolve().parents[2]


def run_blind(folder: Path, every: int, workers: int, dask: str | None) -> int:
    """Draw, diagnose and score every `every`-th case into `folder`; the exit code of the bench."""
    if not (_CHECKOUT / "tests" / "blind" / "run.py").exists():
        raise BadInputError("bench blind", "is not part of the installed package", "a source checkout (its generator lies in tests/blind)")
    words = ["-m", "tests.blind.run", str(folder.resolve()), "--every", str(every), "--workers", str(workers)]
    words += ["--dask", dask] if dask else []
    return subprocess.run([sys.executable, *words], cwd=_CHECKOUT).returncode
