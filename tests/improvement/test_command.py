"""The command: options with units, refusals before anything moves, exit codes, one JSON object."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gimbal_hil.knowledge.improvement import read_journal
from gimbal_hil.knowledge.improvement.journal import Stopped
from gimbal_hil.loop.settings import shipped_settings_path
from gimbal_hil.surface.cli.app import run
from gimbal_hil.surface.cli.improve import _begun_from
from sim_backend.model import shipped_model_path


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """The one line of a refusal, exit code 2."""
    with pytest.raises(SystemExit) as ending:
        run("improve", list(words))
    assert ending.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--torque", "outer:3"), "names no axis"),
        (("--torque", "outer=much"), "is no number"),
        (("--torque", "outer=99"), "over the configuration's limit"),
        (("--travel", "inner=-0.5"), "is no range"),
        (("--travel", "inner=-9..9"), "over the configuration's limits"),
        (("--travel", "inner=0.5..-0.5"), "ends before it begins"),
        (("--resume",), "no such file"),
    ],
)
def test_an_option_that_cannot_be_meant_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], said: str
) -> None:
    line = refused(capsys, "--out", str(tmp_path / "out"), *words)
    assert said in line
    assert line.count("\n") == 1


def test_a_budget_that_the_first_survey_exceeds_is_refused_and_the_journal_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    line = refused(capsys, "--out", str(out), "--survey", "12", "--torque", "inner=0.3")
    assert "N m on inner; 0.3 N m are allowed" in line
    assert isinstance(read_journal(out / "journal.jsonl")[-1], Stopped)
    assert not (out / "round_1").exists()
    assert "already exists" in refused(capsys, "--out", str(out))


@pytest.mark.heavy
def test_the_shipped_antenna_is_at_its_floor_and_the_answer_is_one_json_object(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    code = run("improve", ["--out", str(out), "--survey", "12", "--workers", "1", "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert code == 0
    assert answer["ending"] == "at_the_floor"
    assert answer == json.loads((out / "improve.json").read_text())
    assert (out / "report.html").exists()
    assert (out / "model.yaml").exists()


def test_the_model_that_the_configuration_names_is_begun_with(tmp_path: Path) -> None:
    (tmp_path / "model.yaml").write_text(shipped_model_path("realistic").read_text())
    file = tmp_path / "antenna.yaml"
    file.write_text(shipped_settings_path().read_text() + "\nobserver: {model: model.yaml}\n")
    assert _begun_from(file, None)[1].where == str(tmp_path / "model.yaml")
    assert _begun_from(file, "thesis")[1].name == "thesis"
