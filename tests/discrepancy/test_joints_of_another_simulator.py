"""Drawn joints of MuJoCo that were once told wrongly (decision 68)."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.rigs.drawn import asked


@pytest.mark.parametrize(("name", "motion", "seed"), [("9-45", "sweeps", 9045), ("10-62", "turns", 10062)])
def test_a_gain_is_not_three_numbers_that_are_off_alike(name: str, motion: str, seed: int, tmp_path: Path) -> None:
    said = asked(tmp_path, name, "gain", motion, seed)
    assert [one["name"] for one in said["verdict"]["effects"]] == ["torque_gain"]
    assert said["verdict"]["verdict"] == "named" and said["judged"] == "right"
