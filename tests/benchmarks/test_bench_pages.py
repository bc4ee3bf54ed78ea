"""What the benches say of what they measured, on figures made up here; and what they refuse."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from gimbal_hil.loop.timing.miss_causes import MissCause
from gimbal_hil.pages.report import Callout
from gimbal_hil.proof.bench.faults import FaultOutcome, Motion, Transport, fault_rows, matrix_blocks
from gimbal_hil.proof.bench.figures import Figure, Goal, GoalKind
from gimbal_hil.proof.bench.real_time import RealTime
from gimbal_hil.proof.bench.real_time_page import real_time_blocks, real_time_text
from gimbal_hil.proof.bench.results import bench_page, bench_text, speed_blocks
from gimbal_hil.proof.bench.search import Cost, SearchFigures
from gimbal_hil.proof.bench.search_page import search_blocks, search_text
from gimbal_hil.proof.bench.soak_page import soak_blocks
from gimbal_hil.surface.cli.app import run


def real_time() -> RealTime:
    found = RealTime("unix", 1000.0, ratios=[1.1, 1.3], ready_s=[2.0])
    for late_ns in range(1000, 100_000, 1000):
        found.latency.add(late_ns)
        found.reference.add(late_ns // 2)
        found.computing.add(40_000)
    found.missed[MissCause.OWN_COMPUTING], found.missed[MissCause.PREEMPTION] = 1, 7
    return found


def test_the_real_time_page_tells_own_misses_from_all_and_the_ratio_to_the_c_loop() -> None:
    found = real_time()
    assert found.own_misses == 1
    assert 1.8 < found.ratio < 2.2
    assert json.loads(json.dumps(found.as_dict()))["missed_by_cause"]["preemption"] == 7
    assert "own computing" in real_time_text([found])
    page = bench_page(real_time_blocks([found]), "gimbal-hil bench realtime").render()
    assert (
        "1 tick missed for reasons of the daemon" in page
        and ">Deadlines in real time</h1>" in page
        and "C loop, unix 1000 Hz" in page
    )


def test_cost_in_proportion_has_the_power_one() -> None:
    lengths = tuple(Cost(n, n, n, 3.0 * n, "cogging on outer") for n in (15.0, 30.0, 60.0, 120.0))
    found = SearchFigures(2, lengths, tuple(Cost(n, n, n, 5.0 * n**2) for n in (14.0, 28.0, 54.0)))
    assert found.exponents == pytest.approx((1.0, 2.0))
    assert "cogging on outer" in search_text(found)
    assert "in proportion" in bench_page(search_blocks(found), "gimbal-hil bench search").render()


def test_effects_have_a_table_of_their_own_on_the_speed_page() -> None:
    figures = [Figure(name, 1.0, "ns", "a sine", 2.0, 1.5, 2.5, 9) for name in ("plant step", "step with cogging")]
    page = bench_page(speed_blocks(figures), "gimbal-hil bench").render()
    assert "What each effect costs" in page and ">cogging<" in page and "Cost of one effect" in page
    assert "step with cogging" in bench_text(figures)


def test_the_speed_page_begins_with_the_targets_that_were_met_and_missed() -> None:
    goals = (Goal(GoalKind.RATIO_AT_LEAST, 1.0), Goal(GoalKind.VALUE_AT_LEAST, 5.0), None)
    figures = [Figure(f"part {n}", 1.0, "ns", "a sine", 2.0, 1.5, 2.5, 9, goal) for n, goal in enumerate(goals)]
    first = speed_blocks(figures)[0]
    assert isinstance(first, Callout) and first.tone == "warning"
    assert first.text.startswith("1 of 2 targets met on this machine.\nMissed: part 1: 1 ns")


def test_the_page_of_faults_begins_with_which_came_nearest_or_did_not_end_as_it_must() -> None:
    row = next(one for one in fault_rows() if one.motion is Motion.FAST)
    right = FaultOutcome(row, Transport.CAN, "runaway", 0.5 * row.safe_s, 0.1, 0.0, 0.1 * row.travel_rad, True, "")
    page = bench_page(matrix_blocks([right]), "gimbal-hil bench faults").render()
    assert ">Faults</h1>" in page and "The one fault on CAN ended safely and within its bounds, the slowest" in page
    # one that is ridden through has no bound to be near to
    ridden = next(one for one in fault_rows() if one.safe_s == 0.0)
    through = FaultOutcome(ridden, Transport.CAN, "", 0.0, 0.0, 0.0, 0.0, True, "")
    assert "All 2 faults on CAN" in bench_page(matrix_blocks([right, through]), "gimbal-hil bench faults").render()
    wrong = replace(right, transport=Transport.SERIAL, problem="not safe")
    first = matrix_blocks([right, wrong])[0]
    assert isinstance(first, Callout) and first.tone == "bad"
    assert first.text.endswith(f"The first: {row.name} on serial: not safe.")


def test_a_soak_says_first_what_was_wrong() -> None:
    good, bad = (soak_blocks("1 h of antenna time: 2 ticks\nWRONG: late", problems)[0] for problems in ([], ["late"]))
    assert isinstance(good, Callout) and good.text == "Nothing was wrong in 1 h of antenna time: 2 ticks."
    assert isinstance(bad, Callout) and (bad.text, bad.more) == ("Late.", "1 h of antenna time: 2 ticks.")


@pytest.mark.parametrize("words", [["sleep"], ["blind"], ["realtime", "--link", "smoke_signals", "--seconds", "1"]])
def test_what_cannot_be_measured_is_one_line(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        run("bench", words)
    assert ended.value.code == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith("error: ")


def test_a_page_that_is_there_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("older")
    with pytest.raises(SystemExit):
        run("bench", ["search", "--out", str(tmp_path)])
    assert (tmp_path / "report.html").read_text() == "older"
