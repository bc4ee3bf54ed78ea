"""`runs` lists what was recorded, shows one run, and says how two of them differ."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.data.catalogue.comparison import _change_in_words, difference_of
from gimbal_hil.data.runs import Event, EventKind
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.surface.cli import app
from gimbal_hil.surface.cli.following_logs import after_compare
from gimbal_hil.surface.cli.runs import _told_events
from tests.runs.synthetic import CONFIGURATION, HEADER, record_run


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    for name, ticks in (("first", 1200), ("second", 1600)):
        record_run(tmp_path / "runs" / name, ticks)
    (tmp_path / "runs" / "no run").mkdir()
    return tmp_path / "runs"


def answer(capsys: pytest.CaptureFixture[str], *words: str | Path) -> dict[str, object]:
    capsys.readouterr()
    assert app.run("runs", [*map(str, words), "--json"]) == 0
    found: dict[str, object] = json.loads(capsys.readouterr().out)
    return found


def test_the_list_has_every_run_below_a_folder_with_its_length_and_ending(
    runs: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    listed = answer(capsys, "list", runs)["runs"]
    assert [(Path(one["folder"]).name, one["length_s"], one["ending"]) for one in listed] == [  # type: ignore[attr-defined]
        ("first", 1.2, "done"),
        ("second", 1.6, "done"),
    ]
    assert app.run("runs", ["list", str(runs)]) == 0
    assert f"next: gimbal-hil runs show {runs / 'second'}" in capsys.readouterr().out


def test_a_run_that_cannot_be_read_is_in_the_list_and_says_why(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (runs / "first" / "run.yaml").write_text("schema: 7\n")
    listed = answer(capsys, "list", runs)["runs"]
    assert "cannot be read" in next(one["ending"] for one in listed if one["folder"].endswith("first"))  # type: ignore[attr-defined]


def test_a_run_is_shown_with_figures_of_each_axis_and_what_was_commanded(
    runs: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shown = answer(capsys, "show", runs / "first")
    figures = {one["name"]: one["value"] for one in shown["figures"]}  # type: ignore[attr-defined]
    # the made-up run: 0.3 rad times the sine, torque 0.25 N m times the sine
    assert figures["ticks"] == 1200 and figures["ticks missed"] == 0
    assert figures["outer: travel"] == pytest.approx(0.6, rel=0.01)
    assert figures["outer: torque at most"] == pytest.approx(0.25, rel=0.01)
    assert [event["kind"] for event in shown["events"]] == ["command", "command"]  # type: ignore[attr-defined]


def test_the_same_command_again_and_again_is_one_line() -> None:
    words = ["start", "start", "stop", "start"]
    events = [Event(10 * number, 10_000_000 * number, EventKind.COMMAND, word) for number, word in enumerate(words)]
    assert _told_events(events, 0.001) == [
        "      0.000 s  command  start (2 times, the last at 0.010 s)",
        "      0.020 s  command  stop",
        "      0.030 s  command  start",
    ]


def test_two_runs_are_compared_by_figures_and_settings_and_drawn_over_each_other(
    runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = replace(HEADER, configuration=CONFIGURATION | {"gains": CONFIGURATION["gains"] | {"kp": 3.5e-05}})
    record_run(runs / "other", 1600, header=other)
    out = tmp_path / "compared"
    found = answer(capsys, "compare", runs / "first", runs / "other", "--out", out)
    assert found["settings"] == [{"key": "configuration.gains.kp", "first": "2.5e-05", "second": "3.5e-05"}]
    ticks = next(one for one in found["figures"] if one["name"] == "ticks")  # type: ignore[attr-defined]
    assert (ticks["first"], ticks["second"]) == (1200, 1600)
    assert json.loads((out / "comparison.json").read_text()) == found
    assert app.run("runs", ["compare", str(runs / "first"), str(runs / "other")]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("Torque rms of outer ")
    assert said[1] == "Set otherwise: gains.kp (2.5e-05, then 3.5e-05)."
    page = (out / "report.html").read_text()
    assert page.index(">Figures</h2>") < page.index("outer: both runs from their first row on")
    assert "outer: both runs from their first row on" in page and "configuration.gains.kp" in page
    with pytest.raises(SystemExit) as end:
        app.run("runs", ["compare", str(runs / "first"), str(runs / "other"), "--out", str(out)])
    assert end.value.code == 2


def number(value: float, unit: str, source: str) -> dict[str, object]:
    return {"value": value, "unit": unit, "source": source}


def test_models_are_told_apart_in_words_and_every_key_is_kept_for_programs(
    runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    effects = [
        {"name": "transport_delay", "axis": axis, "delay": number(0.002, "s", "assumed")} for axis in ("outer", "inner")
    ]
    ripple = {"name": "cogging", "axis": "outer", "amplitude": number(0.1, "N m", "measured")}
    more = ripple | {"amplitude": number(0.2, "N m", "guessed")}
    ours = {"name": "plain", "text": "long words", "effects": [ripple]}
    theirs = {"name": "rich", "text": "other words", "effects": [*effects, more], "mass": number(2.0, "kg", "scale")}
    for name, model, seed in (("plain", ours, 1), ("rich", theirs, 7)):
        record_run(runs / name, 1200, header=replace(HEADER, model=model, seed=seed))
    assert app.run("runs", ["compare", str(runs / "plain"), str(runs / "rich"), "--out", str(tmp_path / "c")]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[:2] == [
        "No figure differs.",
        "Set otherwise: model (plain, then rich: 2 effects only in the second, 2 other numbers); seed (1, then 7).",
    ]
    rows = [line for line in said if " | " in line]
    assert rows == [
        "model.effects: - | 2 effects more: transport_delay (outer, inner)",
        "model.effects.cogging of outer.amplitude: 0.1 N m | 0.2 N m",
        "model.mass: - | 2 kg",
        "model.name: plain | rich",
        "seed: 1 | 7",
    ]
    assert (
        said[-1]
        == f"next: gimbal-hil changed --before {runs / 'plain'} --after {runs / 'rich'} --out {tmp_path}/changed"
    )
    page = (tmp_path / "c" / "report.html").read_text()
    assert page.index("Both over each other</h2>") < page.index("model.effects.1.delay.source")
    keys = [one["key"] for one in json.loads((tmp_path / "c" / "comparison.json").read_text())["settings"]]
    assert "model.effects.1.delay.source" in keys


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [(3.99, 4.55, "torque at most of inner +14 % (3.99 to 4.55 N m)"),
     (1.11e-3, 0.997e-3, "torque at most of inner -10 % (1.11 mN m to 997 µN m)"),
     (2.0, 2.004, "torque at most of inner +0.2 % (2 to 2.004 N m)"),
     (0.0, 0.5, "torque at most of inner new (0 to 0.5 N m)")],
)  # fmt: skip
def test_a_figure_that_changed_is_told_by_how_much_and_from_what(old: float, new: float, said: str) -> None:
    assert _change_in_words("inner: torque at most", "N m", old, new) == said


def test_two_motions_of_one_antenna_are_held_against_a_model_and_a_damaged_run_is_looked_at(runs: Path) -> None:
    pair = [runs / name for name in ("survey", "survey_holdout")]
    for run in pair:
        record_run(run, 200, header=replace(HEADER, title=run.name))
    line = after_compare(*pair, runs / "compared", True)
    assert line == f"gimbal-hil discrepancy --measured {pair[0]} --holdout {pair[1]} --out {runs / 'verdict'}"
    assert after_compare(*pair, runs / "compared", False) == f"gimbal-hil runs show {pair[1]}"


def test_what_a_second_run_has_more_is_drawn_over_the_time_that_both_cover() -> None:
    longer, shorter = (
        SignalsTable(("a",), 0.001, np.arange(count) * 0.001, {"a.torque": offset + np.arange(count) * 0.01})
        for count, offset in ((100, 0.0), (60, 0.5))
    )
    for first, second, apart in ((longer, shorter, 0.5), (shorter, longer, -0.5)):
        time_s, more = difference_of(first, second, "a.torque")
        assert time_s.tolist() == shorter.time_s.tolist()
        np.testing.assert_allclose(more, apart, atol=1e-12)


@pytest.mark.parametrize("words", [["show"], ["compare", "a"], ["list", "a", "b"], ["show", "nowhere"], ["list", "no"]])
def test_the_wrong_number_of_runs_and_folders_that_are_none_are_refused(words: list[str]) -> None:
    with pytest.raises(SystemExit) as end:
        app.run("runs", words)
    assert end.value.code == 2


def test_a_run_that_lost_half_its_ticks_is_called_good_by_no_reader(
    runs: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ticks = runs / "second" / "ticks.arrow"
    assert app.run("runs", ["show", str(runs / "second")]) == app.run("check", [str(runs / "second")]) == 0
    ticks.write_bytes(ticks.read_bytes()[: ticks.stat().st_size // 2])
    capsys.readouterr()
    assert app.run("runs", ["show", str(runs / "second")]) == 1
    assert "NOT AS IT WAS RECORDED" in capsys.readouterr().out
    assert app.run("runs", ["show", str(runs / "second"), "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["sound"] is False
    assert app.run("runs", ["compare", str(runs / "first"), str(runs / "second")]) == 1
    assert "NOT AS RECORDED" in capsys.readouterr().out
    assert app.run("check", [str(runs / "second")]) == 1
    assert "ticks that were recorded are missing" in capsys.readouterr().out


def test_a_tolerance_makes_runs_that_are_apart_an_answer_of_no(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, second = str(runs / "first"), str(runs / "second")
    assert app.run("runs", ["compare", first, first, "--tolerance", "0"]) == 0
    assert app.run("runs", ["compare", first, second, "--tolerance", "0"]) == 1
    assert "further apart than 0 %" in capsys.readouterr().out
    out = str(runs.parent / "compared")
    assert app.run("runs", ["compare", first, second, "--tolerance", "0", "--out", out]) == 1
    assert '<div class="callout bad">Further apart than 0 %: ' in (runs.parent / "compared" / "report.html").read_text()
    assert app.run("runs", ["compare", first, second, "--tolerance", "1"]) == 0
