"""A short turn of the coverage-guided fuzzer on every target; longer ones by hand (see `coverage_guided`)."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("atheris", reason="the extra fuzz is not installed")


@pytest.mark.parametrize(("target", "runs"), [("wire", 5000), ("door", 1000), ("loaders", 600), ("log", 150)])
def test_a_turn_of_fuzzing_finds_nothing_and_goes_deeper_than_its_seeds(target: str, runs: int, tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "tests.fuzz.coverage_guided",
        target,
        "--runs",
        str(runs),
        "--corpus",
        str(tmp_path / "corpus"),
    ]
    done = subprocess.run(
        command, cwd=Path(__file__).parents[2], capture_output=True, text=True, errors="replace", timeout=600
    )
    assert done.returncode == 0, done.stderr[-4000:]
    covered = [int(edges) for edges in re.findall(r"cov: (\d+)", done.stderr)]
    assert f"Done {runs} runs" in done.stderr and covered[-1] > covered[0] > 20
