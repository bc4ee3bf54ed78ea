"""Logs that are refused leave an answer that says so, and nothing of an earlier one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.knowledge.discrepancy import Verdict
from gimbal_hil.surface.cli.app import main

EARLIER = ("model.yaml", "model_recalibrated.yaml", "report.html")


def log(path: Path, seconds: float = 8.0, phase: float = 0.0) -> Path:
    """A swing of both axes at 250 Hz, with noise of its own."""
    t = np.arange(round(250 * seconds)) / 250.0
    noise = np.random.default_rng(int(10 * phase)).standard_normal((len(t), 2))
    columns = {"time_s": t}
    for i, axis in enumerate(("outer", "inner")):
        columns[f"{axis}.torque"] = 0.3 * np.sign(np.cos(2.0 * t + phase)) + 0.01 * noise[:, i]
        columns[f"{axis}.position"] = 0.5 * np.sin(2.0 * t + phase)
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    return path


def asked(folder: Path, *words: str, force: bool = True) -> int:
    with pytest.raises(SystemExit) as ended:
        main(["discrepancy", "--out", str(folder), "--workers", "1", *words, *(["--force"] if force else [])])
    return int(ended.value.code or 0)


def with_an_answer(folder: Path) -> Path:
    folder.mkdir()
    for name in (*EARLIER, "verdict.json"):
        (folder / name).write_text("of before", encoding="utf-8")
    return folder


@pytest.mark.parametrize("seconds", [1.0, 1.6])
def test_a_refusal_takes_the_place_of_an_earlier_answer(
    seconds: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, junit = with_an_answer(tmp_path / "out"), tmp_path / "junit.xml"
    # one is refused as it is read, the other when its last third is to judge
    short = str(log(tmp_path / "short.csv", seconds))
    assert asked(out, "--measured", short, "--junit", str(junit), "--json", "--band", "1.25") == 2
    said = json.loads((out / "verdict.json").read_text(encoding="utf-8"))
    assert said["verdict"] == "unusable_data" and "short.csv" in said["text"] and said["gap"] is None
    assert not any((out / name).exists() for name in EARLIER)
    printed = capsys.readouterr()
    assert json.loads(printed.out) == said and said["text"] in printed.err
    assert "unusable_data" in junit.read_text(encoding="utf-8") and 'failures="1"' in junit.read_text(encoding="utf-8")
    # the same keys as in every verdict
    words = {"answer", "grounds", "left", "text"}
    assert set(said) - {"schema", "verdict"} - words == set(Verdict.__dataclass_fields__) - {"kind", "said"}
    assert words <= set(said)


@pytest.mark.parametrize("words", [("--only", "cogging", "--without", "cogging"), ("--band", "500")])
def test_an_option_that_is_refused_says_nothing_of_the_logs(
    words: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = with_an_answer(tmp_path / "out")
    logs = [str(log(tmp_path / f"{k}.csv", phase=k)) for k in range(2)]
    assert asked(out, "--measured", logs[0], "--holdout", logs[1], *words) == 2
    assert words[0] in capsys.readouterr().err
    assert all((out / name).read_text(encoding="utf-8") == "of before" for name in (*EARLIER, "verdict.json"))


def test_a_log_that_is_not_there_removes_no_answer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = with_an_answer(tmp_path / "out")
    there = str(log(tmp_path / "there.csv"))
    assert asked(out, "--measured", there, "--holdout", str(tmp_path / "their.csv")) == 2
    assert "their.csv: no such file" in capsys.readouterr().err
    assert all((out / name).read_text(encoding="utf-8") == "of before" for name in (*EARLIER, "verdict.json"))


@pytest.mark.parametrize("name", ["model.yaml", "model_recalibrated.yaml"])
def test_an_answer_never_takes_the_place_of_the_model_that_it_is_about(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = with_an_answer(tmp_path / "out")
    logs = [str(log(tmp_path / f"{k}.csv", phase=k)) for k in range(2)]
    assert asked(out, "--model", str(out / name), "--measured", logs[0], "--holdout", logs[1]) == 2
    assert "another --out" in capsys.readouterr().err
    assert (out / name).read_text(encoding="utf-8") == "of before"


@pytest.mark.parametrize("name", [*EARLIER, "verdict.json"])
def test_without_force_no_file_of_an_earlier_answer_is_touched(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).write_text("of before", encoding="utf-8")
    assert asked(tmp_path / "out", "--measured", str(log(tmp_path / "short.csv", 1.0)), force=False) == 2
    assert "--force" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "out").iterdir()] == [name]
    assert (tmp_path / "out" / name).read_text(encoding="utf-8") == "of before"
