"""Nothing in the search may see the antenna that made the data, or the bench's truth."""

from __future__ import annotations

import re
from pathlib import Path

import gimbal_hil.discrepancy

FOLDER = Path(gimbal_hil.discrepancy.__file__).parent
FORBIDDEN = re.compile(r"\btests\b|truth\.json|sim_backend\.(plant|device|server)|read_config|hidden")


def test_no_module_of_the_search_imports_or_names_the_truth() -> None:
    for path in FOLDER.glob("*.py"):
        code = "\n".join(
            line for line in path.read_text(encoding="utf-8").splitlines() if "import" in line or "open(" in line
        )
        assert not FORBIDDEN.search(code), path.name


def test_modules_stay_short() -> None:
    assert all(len(path.read_text(encoding="utf-8").splitlines()) < 400 for path in FOLDER.glob("*.py"))
