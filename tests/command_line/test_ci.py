"""What CI asks for: JUnit files, and a bench that fails when a figure misses its target."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from gimbal_hil.data.runs import Difference, ReplayResult
from gimbal_hil.loop.settings import shipped_settings_path
from gimbal_hil.loop.timing.miss_causes import MissCause
from gimbal_hil.pages.report import Case, write_junit
from gimbal_hil.proof.bench import Figure, Goal, GoalKind
from gimbal_hil.proof.bench.real_time import RealTime
from gimbal_hil.surface.cli import app
from tests.runs.synthetic import record_run


def figure(value: float, ratio: float, target: Goal | None) -> Figure:
    return Figure("plant step", value, "ns", "MuJoCo", ratio, ratio, ratio, 9, target)


@pytest.mark.parametrize(
    ("value", "ratio", "kind", "limit", "missed"),
    [
        (50.0, 12.0, GoalKind.RATIO_AT_LEAST, 10.0, False),
        (50.0, 9.0, GoalKind.RATIO_AT_LEAST, 10.0, True),
        (50.0, 1.2, GoalKind.RATIO_BELOW, 1.3, False),
        (0.1, 1.3, GoalKind.RATIO_BELOW, 1.3, True),
        (1000.0, 1.6, GoalKind.VALUE_AT_LEAST, 1000.0, False),
        (349.0, 2000.0, GoalKind.VALUE_AT_LEAST, 1000.0, True),
        (0.04, 1.3, GoalKind.VALUE_BELOW, 0.5, False),
        (0.6, 0.1, GoalKind.VALUE_BELOW, 0.5, True),
    ],
)
def test_a_figure_whose_value_or_ratio_misses_its_target_is_marked(
    value: float, ratio: float, kind: GoalKind, limit: float, missed: bool
) -> None:
    one = figure(value, ratio, Goal(kind, limit))
    assert bool(one.problem) is missed
    assert ("MISSED" in one.as_row()[-1]) is missed
    assert f"{kind} {limit:g}" in one.as_row()[-1]
    assert figure(value, ratio, None).problem == ""


@pytest.mark.parametrize(("ratio", "code"), [(20.0, 0), (5.0, 1)])
def test_the_bench_ends_with_one_when_a_figure_misses_its_target(
    ratio: float, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = Goal(GoalKind.RATIO_AT_LEAST, 10.0)
    monkeypatch.setattr("gimbal_hil.proof.bench.speed_figures", lambda repeats, say: [figure(50.0, ratio, asked)])
    assert app.run("bench", ["speed"]) == code
    assert ("MISSED" in capsys.readouterr().out) is bool(code)


@pytest.mark.heavy
def test_the_bench_judges_what_it_measures_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = app.run("bench", ["speed", "--repeats", "3", "--json", "--out", str(tmp_path)])
    rows = json.loads(capsys.readouterr().out)
    asked = [row for row in rows if row["target"]]
    assert {row["name"] for row in asked} >= {"plant step", "--help", "frame path, every frame and tick kept"}
    assert {row["target"]["kind"] for row in asked} == set(GoalKind)
    assert code == int(any(row["problem"] for row in rows))
    page = (tmp_path / "report.html").read_text()
    assert ("MISSED" in page) is bool(code)


def real_time(own: int, ratio: int, computing_ns: int, rate_hz: float = 1000.0) -> RealTime:
    found = RealTime("unix", rate_hz, ratios=[1.0], ready_s=[1.0])
    for late_ns in range(10_000, 100_000, 1000):
        found.latency.add(late_ns * ratio)
        found.reference.add(late_ns)
        found.computing.add(computing_ns)
    found.missed[MissCause.OWN_COMPUTING], found.missed[MissCause.LATE_TIMER] = own, 9
    return found


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (real_time(0, 1, 50_000), ""),
        (real_time(2, 1, 50_000), "2 own misses"),
        (real_time(0, 3, 50_000), "p99 ratio"),
        (real_time(0, 1, 150_000), "computing p99"),
        # at 2 kHz only the ratio and the misses are asked for
        (real_time(0, 1, 150_000, 2000.0), ""),
    ],
)
def test_the_real_time_bench_says_which_target_it_misses_and_ends_with_one(
    found: RealTime, words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (words in found.problem) and bool(found.problem) is bool(words)
    monkeypatch.setattr("gimbal_hil.proof.bench.real_time_figures", lambda *given: [found])
    assert app.run("bench", ["realtime"]) == (1 if words else 0)
    assert ("MISSED" in capsys.readouterr().out) is bool(words)


def test_a_junit_file_says_what_failed_and_what_did_not(tmp_path: Path) -> None:
    write_junit(
        tmp_path / "new" / "a.xml", "suite", [Case("good", "all is well", False), Case("bad", "<no>\nmore", True)]
    )
    suite = ElementTree.parse(tmp_path / "new" / "a.xml").getroot()[0]
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    failure = suite.find("testcase[@name='bad']/failure")
    assert failure is not None and failure.get("message") == "<no>" and failure.text == "<no>\nmore"
    assert suite.find("testcase[@name='good']/failure") is None


def test_check_leaves_a_case_a_file(tmp_path: Path) -> None:
    (tmp_path / "plan.yaml").write_text("segments: 7\n")
    out = tmp_path / "check.xml"
    words = [str(shipped_settings_path()), str(tmp_path / "plan.yaml"), "--junit", str(out)]
    assert app.run("check", words) == 1
    suite = ElementTree.parse(out).getroot()[0]
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")


def test_replay_leaves_its_answer_as_a_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    record_run(tmp_path / "run", 100)
    found = Difference(7, "tick.torque_outer", "1", "2", "")
    for difference, code in ((None, 0), (found, 1)):
        answer = ReplayResult(100, 700, difference)
        monkeypatch.setattr(
            "gimbal_hil.surface.cli.replay._replay", lambda log, config, quiet, answer=answer: (answer, None)
        )
        out = tmp_path / f"{code}.xml"
        assert app.run("replay", [str(tmp_path / "run"), "--junit", str(out)]) == code
        suite = ElementTree.parse(out).getroot()[0]
        assert suite.get("failures") == str(code)
        assert suite[0][0].text is not None and ("differs at tick 7" in suite[0][0].text) is bool(code)
