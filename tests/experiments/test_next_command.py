"""`experiment` names all its sequences in its help, and ends with the command that one mostly wants next."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gimbal_hil.data.runs import RunWriter
from gimbal_hil.knowledge.experiments.sequences.registry import SEQUENCES
from gimbal_hil.surface.cli import main
from gimbal_hil.surface.cli.app import run
from gimbal_hil.surface.cli.following_logs import after_experiment
from gimbal_hil.surface.cli.origin import LogOrigin
from tests.runs.synthetic import HEADER


def test_the_help_names_every_sequence(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["experiment", "--help"])
    said = capsys.readouterr().out.replace("│", " ")
    words = " ".join(said.split()).replace(",", " ").replace(".", " ").split()
    assert not set(SEQUENCES) - set(words)


def test_the_help_of_discrepancy_says_where_logs_come_from(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["discrepancy", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "experiment survey" in said and "survey_holdout" in said


def test_the_way_from_a_step_to_a_verdict_is_shown_command_by_command() -> None:
    config, runs = Path("mine/antenna.yaml"), Path("mine/runs")
    origin = LogOrigin(config)
    assert after_experiment("step", runs / "step", origin) == (
        "gimbal-hil experiment survey --config mine/antenna.yaml --out mine/runs/survey"
    )
    assert after_experiment("survey", runs / "survey", origin, "m.yaml") == (
        "gimbal-hil experiment survey_holdout --config mine/antenna.yaml --known m.yaml --out mine/runs/survey_holdout"
    )
    # without a survey beside it there is nothing to look into yet
    assert after_experiment("survey_holdout", runs / "survey_holdout", origin, "m.yaml") == (
        "gimbal-hil experiment survey --config mine/antenna.yaml --known m.yaml --out mine/runs/survey"
    )
    assert after_experiment("sliding", runs / "sliding", LogOrigin()) == (
        "gimbal-hil identify mine/runs/sliding --out mine/runs/identified"
    )
    assert after_experiment("sliding", Path("my runs/A"), LogOrigin()) == (
        "gimbal-hil identify 'my runs/A' --out 'my runs/identified'"
    )


def test_a_survey_under_a_name_of_ones_own_is_found_and_the_model_is_the_configurations(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    run("init", ["mine", "--yes"])
    for name, title in (("older", "survey"), ("A", "survey"), ("C", "step")):
        RunWriter(tmp_path / name, replace(HEADER, title=title)).close(0, "")
    config = Path("mine/antenna.yaml")
    assert after_experiment("survey_holdout", Path("B"), LogOrigin(config)) == (
        "gimbal-hil discrepancy --model mine/model.yaml --measured A --holdout B --out verdict"
    )
    assert after_experiment("sliding", Path("S"), LogOrigin(config)) == (
        "gimbal-hil identify S --model mine/model.yaml --out identified"
    )
    run("init", ["far", "--yes", "--link", "unix:/tmp/antenna"])
    assert "--model far/model.yaml" in after_experiment("sliding", Path("S"), LogOrigin(Path("far/antenna.yaml")))


def test_help_says_what_to_write_and_not_what_python_calls_it(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["identify", "--help"])
    said = capsys.readouterr().out
    assert "--axis TEXT " in said and "RUN...  " in said and "--workers NUMBER " in said
    assert not any(word in said for word in ("<list[str", "<path", "<str", " range>"))
