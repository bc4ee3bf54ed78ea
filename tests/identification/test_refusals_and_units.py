"""A linear axis is told in newtons and metres, a prior is that of the model given."""

from __future__ import annotations

from pathlib import Path

import pytest

from gimbal_hil.knowledge.identification.estimate import Interval, settle, straight
from gimbal_hil.knowledge.identification.units import LINEAR, ROTARY
from gimbal_hil.surface.cli.app import run


@pytest.mark.parametrize(
    ("rotary", "linear"), [("N m", "N"), ("rad/s", "m/s"), ("N m s/rad", "N s/m"), ("N m/rad", "N/m"), ("1", "1")]
)
def test_each_unit_of_a_rotary_axis_has_one_of_a_linear_axis(rotary: str, linear: str) -> None:
    assert straight(settle("any", 1.0, Interval(0.9, 1.1), rotary, None, "")).unit == linear


def test_pictures_are_labelled_in_the_units_of_the_axis() -> None:
    assert (ROTARY.torque, ROTARY.rate) == ("N m", "rad/s") and (LINEAR.torque, LINEAR.rate) == ("N", "m/s")


def test_a_file_in_the_place_of_the_folder_is_refused_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out").write_text("here")
    with pytest.raises(SystemExit) as ended:
        run("identify", ["nothing.csv", "--out", str(tmp_path / "out")])
    assert ended.value.code == 2 and "is a file" in capsys.readouterr().err


def test_ctrl_c_ends_in_one_word_and_nothing_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("gimbal_hil.knowledge.identification.read_logs", stop)
    assert run("identify", ["nothing.csv", "--out", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err.strip() == "interrupted" and not (tmp_path / "out").exists()
