"""`gimbal-hil experiment` as a user runs it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gimbal_hil.data.runs import open_run
from gimbal_hil.surface.cli.app import run as run_command

ONE_AXIS = "schema: 1\nname: arm\nkind: rotary\naxes: {arm: {body: {inertia: {zz: 0.5}}}}\n"


def exit_code(words: list[str]) -> int:
    try:
        return run_command("experiment", words)
    except SystemExit as end:
        return int(end.code or 0)


def test_a_sequence_leaves_a_run_a_table_and_a_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "run"
    assert run_command("experiment", ["base_motion", "--short", "--base", "3.1/2", "--out", str(out), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["experiment"] == "base_motion" and len(answer["rows"]) == 1
    assert (out / "table.csv").read_text().startswith("step,") and "Holding still" in (out / "report.html").read_text()
    assert run_command("experiment", ["survey", "--short", "--out", str(tmp_path / "survey")]) == 0
    said = capsys.readouterr().out
    assert "  Recorded: outer from -0." in said and "rad/s and " in said and "table.csv (1 row)" in said
    assert "Recorded: outer from -0." in (tmp_path / "survey" / "report.html").read_text()
    run = open_run(out)
    assert run.record.end is not None and run.record.end.exit_code == 0
    assert [event.text for event in run.events if event.kind.value == "segment"][-1] == "torque off"
    assert run_command("replay", [str(out)]) == 0


def test_a_finished_run_is_not_overwritten_without_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "run"
    words = ["base_motion", "--short", "--out", str(out), "--json"]
    assert exit_code(words) == 0
    assert exit_code(words) == 2
    assert exit_code([*words, "--force"]) == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing"], "is no sequence and no plan file"),
        (["sliding", "--axis", "middle"], "no axis 'middle'"),
        (["presliding", "--breakaway", "middle=1"], "no axis 'middle'"),
        (["presliding", "--breakaway", "inner=much"], "'much' is no torque"),
        (["presliding", "--breakaway", "inner=-1"], "'-1' is no torque"),
        (["sliding", "--resume"], "does not say which run"),
        (["sliding", "--real-time"], "does not say which daemon"),
        (["base_motion", "--base", "3.1/9"], "has no case 9"),
    ],
)
def test_wrong_use_is_one_line_and_exit_code_2(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = [] if "--resume" in words else ["--out", str(tmp_path / "run")]
    assert exit_code([*words, *folder]) == 2
    assert said in capsys.readouterr().err.replace("\n", " ")


def test_a_model_of_one_axis_is_refused_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "arm.yaml").write_text(ONE_AXIS)
    assert exit_code(["sliding", "--short", "--model", str(tmp_path / "arm.yaml"), "--out", str(tmp_path / "run")]) == 2
    assert "arm.yaml: kind: is rotary" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("begun", [True, False])
def test_ctrl_c_says_how_to_go_on_where_there_is_something_to_go_on_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, begun: bool
) -> None:
    def stop(*_: object, **__: object) -> None:
        (tmp_path / "run").mkdir()
        if begun:
            (tmp_path / "run" / "checkpoint.json").write_text("{}")
        raise KeyboardInterrupt

    monkeypatch.setattr("gimbal_hil.knowledge.experiments.conduct", stop)
    assert exit_code(["sliding", "--short", "--out", str(tmp_path / "run")]) == 130
    said = capsys.readouterr().err
    assert said.startswith("interrupted") and (f"--out {tmp_path / 'run'} --resume" in said) == begun
