"""One drawn joint of MuJoCo that was once told wrongly (decision 68)."""

from __future__ import annotations

from pathlib import Path

from tests.rigs.drawn import asked


def test_a_gain_is_not_three_numbers_that_are_off_alike(tmp_path: Path) -> None:
    said = asked(tmp_path, "9-45", "gain", "sweeps", 9045)
    assert [one["name"] for one in said["verdict"]["effects"]] == ["torque_gain"]
    assert said["verdict"]["verdict"] == "named" and said["judged"] == "right"
