"""Where the measured data are."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

DATA = Path(os.environ.get("GIMBAL_HIL_DATA") or Path(__file__).parents[3] / "shared" / "data")


def data_folder(name: str) -> Path:
    """Folder of a data set; skips the test with the reason when it is not there."""
    folder = DATA / name
    if not folder.is_dir():
        pytest.skip(f"measured data {name!r} is not at {DATA} (set GIMBAL_HIL_DATA to the folder that holds it)")
    return folder
