"""Every notebook runs from its first cell to its last, and its own assertions hold."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.rigs.data import DATA, data_folder

ROOT = Path(__file__).resolve().parent.parent.parent
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.py"))


@pytest.mark.heavy
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_from_its_first_cell_to_its_last(notebook: Path, tmp_path: Path) -> None:
    if notebook.stem == "a_real_log":
        data_folder("emps")
    environment = os.environ | {
        "GIMBAL_HIL_DATA": str(DATA),
        "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]),
    }
    done = subprocess.run(
        [sys.executable, str(notebook)], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_has_cells_words_and_something_that_it_asserts_and_stands_on_the_page(notebook: Path) -> None:
    text = notebook.read_text()
    compile(text, str(notebook), "exec")
    assert text.count("# %%") > 5 and "# %% [markdown]" in text and "\nassert " in text
    assert f"(../notebooks/{notebook.name})" in (ROOT / "docs" / "reference" / "library.md").read_text()
