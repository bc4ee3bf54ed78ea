"""`discrepancy --settle`: a motion keeps to the limits of the antenna that the logs came from, or is not made."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import RunHeader
from gimbal_hil.data.runs.header import write_header
from gimbal_hil.knowledge import improvement
from gimbal_hil.knowledge.discrepancy import CHANCE, Kind
from gimbal_hil.knowledge.discrepancy.inquiry.inquiry import State
from gimbal_hil.knowledge.improvement.choosing import Option, Pair
from gimbal_hil.knowledge.improvement.showing import ShowingRun
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.surface.cli.app import run
from gimbal_hil.surface.cli.settling import limits_in, write_settling
from gimbal_hil.surface.library import Finding


def a_run(folder: Path, torque_nm: float) -> Path:
    """A run folder that says with which limits it was recorded, and nothing else."""
    configuration = shipped_settings().model_dump(mode="json", by_alias=True)
    configuration["axes"]["inner"]["limits"]["torque_nm"] = torque_nm
    folder.mkdir()
    write_header(folder, RunHeader(configuration, {}, 0, 1_000_000, True), "2026-11-28T00:00:00Z", None)
    return folder


def test_limits_are_those_of_the_first_run_among_the_logs(tmp_path: Path) -> None:
    logs = [tmp_path / "a.csv", a_run(tmp_path / "one", 3.5), a_run(tmp_path / "two", 6.0)]
    assert limits_in(logs).axes["inner"].limits.torque_nm == 3.5


def test_logs_that_are_tables_alone_are_refused_before_they_are_searched(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "a.csv"
    log.write_text("time_s,inner.position,inner.torque\n", encoding="utf-8")
    with pytest.raises(BadInputError, match="limits of its antenna"):
        limits_in([log])
    with pytest.raises(SystemExit) as ending:
        run("discrepancy", ["--measured", str(log), "--out", str(tmp_path / "out"), "--settle"])
    assert ending.value.code == 2
    line = capsys.readouterr().err
    assert "--settle" in line and line.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("rival", "option"), [("static_unbalance", "--measured"), (CHANCE, "--holdout")])
def test_what_is_said_of_a_motion_says_how_its_log_is_used(
    rival: str, option: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    nobody = cast(State, None)
    pair = Pair(nobody, nobody, (("cable_spring", "inner"), (rival, "inner")))
    made = (pair, Option("settle", "inner", 1234.0, 20.7))
    finding = cast(Finding, SimpleNamespace(kind=Kind.AMBIGUOUS, result=None))
    for found, said in ((made, f"a further {option}"), (None, "no motion of the antenna's own")):
        monkeypatch.setattr(improvement, "settling_run", lambda *_, found=found: found)
        assert said in write_settling(tmp_path / "s.yaml", finding, shipped_settings(), 1, lambda text: None)


def test_a_motion_that_decides_is_the_hold_out_of_the_next_call(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    made = ShowingRun((("inertia", "inner"),), (("viscous", "inner"),), Option("settle", "inner", 1234.0, 20.7))
    hidden = (("inertia", "inner"), ("viscous", "outer"), ("viscous", "inner"))
    finding = cast(Finding, SimpleNamespace(kind=Kind.CANNOT_JUDGE, result=SimpleNamespace(hidden=hidden)))
    for found, said in ((made, "its log is the --holdout"), (None, "no motion inside the limits")):
        monkeypatch.setattr(improvement, "showing_run", lambda *_, found=found: found)
        line = write_settling(tmp_path / "s.yaml", finding, shipped_settings(), 1, lambda text: None)
        assert said in line and ("viscous on outer, of which the model file" in line) == (found is not None)
        assert ("viscous on inner, which no motion" in line) == (found is not None)
