"""The benches remember what they found, and say what became slower."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gimbal_hil.proof.bench import HISTORY_FILE, Figure, remember
from gimbal_hil.surface.cli import app


def test_what_lies_above_the_last_benches_by_more_than_their_spread_is_slower(tmp_path: Path) -> None:
    file = tmp_path / "out" / HISTORY_FILE
    for cost in (1.0, 1.2, 1.1):
        assert remember(file, "speed", {"step": cost, "tick": 2.0}) == []
    assert remember(file, "speed", {"step": 1.25, "tick": 2.0}) == []
    (told,) = remember(file, "speed", {"step": 2.3, "tick": 2.0, "new": 9.0})
    assert told.startswith("step: 2.00 times the median of the last 4 benches")
    first = json.loads(file.read_text().splitlines()[0])
    assert first["costs"] == {"step": 1.0, "tick": 2.0} and first["version"] and first["code"] and first["time"]


def test_each_bench_is_compared_with_its_own_kind_and_a_line_cut_off_is_none(tmp_path: Path) -> None:
    file = tmp_path / HISTORY_FILE
    for _ in range(3):
        remember(file, "search", {"step": 1.0})
    assert remember(file, "speed", {"step": 5.0}) == []
    with file.open("a") as history:
        history.write('{"bench": "search", "co\n')
    assert len(remember(file, "search", {"step": 5.0})) == 1


def test_the_bench_says_what_became_slower_on_terminal_and_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def measured(times_faster: float) -> list[Figure]:
        return [Figure("plant step", 50.0, "ns", "a sine", times_faster, 1.0, 99.0, 9, faster=True)]

    for times_faster in (40.0, 42.0, 41.0, 20.0):
        figures = measured(times_faster)
        monkeypatch.setattr("gimbal_hil.proof.bench.speed_figures", lambda repeats, say, figures=figures: figures)
        capsys.readouterr()
        assert app.run("bench", ["speed", "--out", str(tmp_path), "--force"]) == 0
    assert "SLOWER plant step, beside a sine: 2.05 times the median" in capsys.readouterr().err
    assert "Slower: plant step" in (tmp_path / "report.html").read_text()
