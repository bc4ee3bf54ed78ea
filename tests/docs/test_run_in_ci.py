"""The page "Run in CI": what it asks to record is recorded, and the steps of its workflow then pass."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.docs.test_five_minutes import lines_of

PAGE = Path(__file__).resolve().parent.parent.parent / "docs" / "how-to" / "run-in-ci.md"
PYTHON = Path(sys.executable).parent


def workflow() -> dict[str, Any]:
    found = re.search(r"^```yaml\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.M | re.S)
    assert found is not None
    made: dict[str, Any] = yaml.safe_load(found[1])
    return made


def steps() -> list[str]:
    """What the workflow runs, but for what installs."""
    told = [step["run"] for step in workflow()["jobs"]["antenna"]["steps"] if "run" in step]
    return [line for line in told if "pip install" not in line]


def test_every_file_that_the_workflow_reads_is_made_by_the_lines_below_it() -> None:
    made = {word for line in lines_of(PAGE, 0) for word in re.findall(r"(?:--out|init) (\S+)", line)}
    read = {word for line in steps() for word in re.findall(r"(?:runs/\w+|antenna|friction)(?=[/ ]|$)", line)}
    assert read and read <= made


@pytest.mark.heavy
def test_the_workflow_passes_on_what_the_page_says_to_record(tmp_path: Path) -> None:
    for line in [*lines_of(PAGE, 0), *steps()]:
        done = subprocess.run(
            ["bash", "-c", f'PATH="{PYTHON}:$PATH"; {line}'], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"
    assert {path.name for path in (tmp_path / "results").iterdir()} == {"check.xml", "replay.xml", "discrepancy.xml"}
