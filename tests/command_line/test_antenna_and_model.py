"""What is printed as next moves the antenna of the logs, and asks the model that somebody has of it; never the one in
place of the other.
"""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

from gimbal_hil.data.runs import RunWriter
from gimbal_hil.knowledge.discrepancy import Kind, refusal
from gimbal_hil.surface.cli.discrepancy import AskedLogs, with_all_effects_next
from gimbal_hil.surface.cli.following_logs import (
    after_discrepancy,
    after_experiment,
    after_identify,
    after_improve,
    after_testable,
)
from gimbal_hil.surface.cli.log_options import LogOptions, SearchOptions
from gimbal_hil.surface.cli.origin import LogOrigin, origin_of
from gimbal_hil.surface.library import Finding
from tests.runs.synthetic import HEADER

OPEN: dict[str, Any] = {"effects": [], "alternatives": [], "where": [], "next_experiment": None}
UNEXPLAINED = OPEN | {"verdict": "unexplained"}


def recorded(folder: Path, title: str, *options: str, model: str = "realistic") -> Path:
    """A run of that sequence, as a command with these options leaves it."""
    words = ("gimbal-hil", "experiment", title, *options)
    RunWriter(folder, replace(HEADER, title=title, command_line=words, model={"name": model})).close(0, "")
    return folder


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_the_antenna_of_a_log_is_the_one_that_its_command_moved() -> None:
    assert origin_of([recorded(Path("a"), "survey", "--model", "realistic")]) == LogOrigin(model="realistic")
    assert origin_of([recorded(Path("b"), "survey", "--model=m.yaml")]) == LogOrigin(model="m.yaml")
    # through a daemon the model is what was asked about, and moves nothing
    daemon = recorded(Path("daemon"), "daemon")
    assert origin_of([recorded(Path("c"), "survey", "--run", str(daemon), "--model", "m.yaml")]) == LogOrigin()
    Path("table.csv").write_text("", encoding="utf-8")
    assert origin_of([Path("table.csv")]).elsewhere


def test_from_friction_of_an_antenna_its_model_goes_to_the_search_and_the_antenna_stays() -> None:
    slid = recorded(Path("slid"), "sliding", "--model", "realistic")
    first = after_identify(Path("id"), [slid], 2, True)
    assert first == "gimbal-hil experiment survey --model realistic --known id/model.yaml --out survey"
    survey, origin = recorded(Path("survey"), *shlex.split(first)[2:]), LogOrigin(model="realistic")
    second = after_experiment("survey", survey, origin, "id/model.yaml")
    assert second == "gimbal-hil experiment survey_holdout --model realistic --known id/model.yaml --out survey_holdout"
    holdout = recorded(Path("survey_holdout"), *shlex.split(second)[2:])
    search = "gimbal-hil discrepancy --model id/model.yaml --measured survey --holdout survey_holdout --out verdict"
    assert after_experiment("survey_holdout", holdout, origin, "id/model.yaml") == search
    # with both logs there a new identification is asked at once
    assert after_identify(Path("id"), [slid], 2, True) == search
    deciding = after_discrepancy(UNEXPLAINED, "id/model.yaml", 2, Path("verdict"), [survey, holdout])
    assert deciding == "gimbal-hil experiment plateaus --model realistic --known id/model.yaml --out plateaus"
    decade = recorded(Path("plateaus"), *shlex.split(deciding)[2:])
    again = after_experiment("plateaus", decade, origin, "id/model.yaml")
    assert "--model id/model.yaml --measured survey --measured plateaus --holdout survey_holdout" in again
    # what was recorded already decides nothing a second time
    once_more = after_discrepancy(UNEXPLAINED, "id/model.yaml", 2, Path("verdict"), [survey, decade, holdout])
    assert "experiment reversals --model realistic" in once_more


def test_an_antenna_is_not_held_against_itself() -> None:
    recorded(Path("survey"), "survey", "--model", "realistic")
    holdout = recorded(Path("survey_holdout"), "survey_holdout", "--model", "realistic")
    asked = after_experiment("survey_holdout", holdout, LogOrigin(model="realistic"))
    assert asked == "gimbal-hil discrepancy --measured survey --holdout survey_holdout --out verdict"


def test_a_survey_of_another_antenna_is_not_searched() -> None:
    recorded(Path("survey"), "survey", model="thesis")
    holdout = recorded(Path("survey_holdout"), "survey_holdout", "--model", "realistic")
    line = after_experiment("survey_holdout", holdout, LogOrigin(model="realistic"))
    assert line == "gimbal-hil experiment survey --model realistic --out survey_2"


def test_what_explains_its_logs_is_used_and_takes_no_antennas_place() -> None:
    named = OPEN | {"verdict": "named"}
    log = recorded(Path("survey"), "survey", "--model", "realistic")
    line = after_discrepancy(named, None, 2, Path("verdict"), [log])
    assert line == "gimbal-hil export-model verdict/model.yaml --to mjcf --out model.xml"
    assert after_improve(Path("better"), None, True).startswith("gimbal-hil export-model better/model.yaml ")


def test_files_of_an_antenna_that_nothing_here_moves_move_no_other() -> None:
    tables = [Path("a.csv"), Path("b.csv")]
    for table in tables:
        table.write_text("", encoding="utf-8")
    line = after_discrepancy(UNEXPLAINED, "mine.yaml", 2, Path("verdict"), tables)
    assert line == "gimbal-hil testable --plan plateaus --model mine.yaml"
    found = after_identify(Path("id"), tables, 2, True, ["time_s=t"])
    assert found == (
        "gimbal-hil discrepancy --model id/model.yaml --measured a.csv --measured b.csv --column time_s=t --out verdict"
    )


@pytest.mark.parametrize("axes", [1, 2])
def test_where_some_effects_alone_were_searched_the_same_logs_are_searched_for_all(axes: int) -> None:
    verdict = replace(refusal("-"), kind=Kind.UNEXPLAINED, next_experiment={"plan": "first", "separates": []})
    finding = Finding(verdict, cast(Any, None))
    asked = AskedLogs(measured=[Path("a.csv")], out=Path("verdict"), holdout=[Path("b.csv")], model="m.yaml")
    reading = LogOptions(column=["time_s=t:ms"], rate=500.0)
    told = with_all_effects_next(finding, asked, reading, SearchOptions(only=["cogging"], band=12.5))
    line = after_discrepancy(told.verdict.document, "m.yaml", axes, asked.out, asked.logs)
    assert line == (
        "gimbal-hil discrepancy --model m.yaml --measured a.csv --holdout b.csv --column time_s=t:ms --rate 500 "
        "--band 12.5 --out verdict_of_all"
    )
    assert with_all_effects_next(finding, asked, reading, SearchOptions()) is finding


def test_a_run_that_was_foreseen_for_a_configuration_is_run_on_its_antenna() -> None:
    assert after_testable("survey", "m.yaml", Path("c.yaml"), True) == (
        "gimbal-hil experiment survey --short --config c.yaml --known m.yaml --out runs/survey"
    )
