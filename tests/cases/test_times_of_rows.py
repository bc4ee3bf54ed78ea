"""Clocks of logs: stamps with too few digits, rows that were lost, clocks that were set meanwhile, lagging torques."""

from __future__ import annotations

import json
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import ColumnMap, SignalsTable, read_signals
from gimbal_hil.surface.cli.app import run
from tests.cases.joint import BENCH, TRUE, JointLog, table_text

LOG = BENCH.log()
ROWS = len(LOG.time)
AXES = ("joint",)


def read(folder: Path, text: str, *words: str, **repair: object) -> SignalsTable:
    (folder / "log.csv").write_text(text)
    return read_signals(folder / "log.csv", AXES, columns=ColumnMap.of_words(words), **repair)  # type: ignore[arg-type]


def at_times(times: np.ndarray, form: str) -> str:
    return LOG.but(time=times).text(forms={"time_s": form})


def without(lost: np.ndarray) -> JointLog:
    kept = ~np.isin(np.arange(ROWS), lost)
    return JointLog(*(values[kept] for values in (LOG.time, LOG.torque, LOG.position, LOG.rate)))


@pytest.mark.parametrize("rate_hz", [150.0, 400.0, 700.0])
def test_milliseconds_of_another_rate_are_counted_from_the_rows(tmp_path: Path, rate_hz: float) -> None:
    text = at_times(np.arange(ROWS) / rate_hz, ".3f")
    with pytest.raises(BadInputError, match=rf"--resample \(keeps {ROWS} of {ROWS} rows\)"):
        read(tmp_path, text)
    table = read(tmp_path, text, resample=True)
    assert table.period_s == pytest.approx(1.0 / rate_hz, rel=1e-9) and len(table) == ROWS
    assert table.position("joint") == pytest.approx(LOG.position, abs=1e-7)
    assert any(f"even clock with too few digits: times were counted from the rows, {rate_hz:g} Hz" in note
               for note in table.notes)  # fmt: skip


def test_of_the_rates_that_stamps_allow_the_roundest_is_taken_or_the_stated_one(tmp_path: Path) -> None:
    text = at_times(1.7e9 + LOG.time, ".1f")
    with pytest.raises(BadInputError, match=r"--rate 500 counts the rows"):
        read(tmp_path, text)
    assert read(tmp_path, text, resample=True).period_s == pytest.approx(0.002, rel=1e-9)
    assert read(tmp_path, text, rate_hz=499.99).period_s == pytest.approx(1.0 / 499.99, rel=1e-9)


@pytest.mark.parametrize(("start_s", "digits", "told"), [(0.0, 3, True), (8.0, 4, False), (95.0, 5, True)])
def test_times_of_so_many_digits_that_lose_one_at_each_power_of_ten_are_counted(
    tmp_path: Path, start_s: float, digits: int, told: bool
) -> None:
    text = at_times(start_s + LOG.time, f".{digits}g")
    with pytest.raises(BadInputError, match=r"--rate 500 counts the rows" if told else "too few digits"):
        read(tmp_path, text)
    table = read(tmp_path, text, rate_hz=500.0)
    assert len(table) == ROWS and table.period_s == pytest.approx(0.002, rel=1e-9)


def test_days_with_few_digits_are_asked_for_their_unit_and_then_read(tmp_path: Path) -> None:
    text = at_times(LOG.time / 86400.0, ".7f")
    with pytest.raises(BadInputError, match=r"--column time_s=COLUMN:UNIT \(they are read as seconds\)"):
        read(tmp_path, text)
    assert read(tmp_path, text, "time_s=time_s:d", resample=True).period_s == pytest.approx(0.002, rel=1e-6)


@pytest.mark.parametrize("every", [10, 97])
def test_rows_that_are_lost_at_even_distances_are_bridged_and_not_counted(tmp_path: Path, every: int) -> None:
    table = read(tmp_path, without(np.arange(every, ROWS - 1, every)).text(), resample=True)
    assert table.period_s == pytest.approx(0.002, rel=1e-6) and len(table) == ROWS


def test_the_scatter_of_stamps_within_what_is_allowed_is_no_motion(tmp_path: Path) -> None:
    scatter = np.where(np.arange(ROWS) % 3 == 1, 3e-5, 0.0)
    table = read(tmp_path, at_times(LOG.time + scatter, ".6f"))
    assert np.diff(table.time_s) == pytest.approx(0.002, rel=1e-5)


def test_the_digits_of_stamps_are_no_motion(tmp_path: Path) -> None:
    stamps = LOG.time.astype(np.float32).astype(np.float64)
    assert abs(np.median(np.diff(stamps)) / 0.002 - 1.0) > 5e-5
    table = read(tmp_path, at_times(stamps, ".9f"))
    assert np.diff(table.time_s) == pytest.approx(0.002, rel=1e-6)


def test_in_a_short_gap_the_torque_goes_straight_to_its_other_end(tmp_path: Path) -> None:
    lost = np.concatenate([np.arange(row, row + 6) for row in range(600, ROWS - 300, 600)])
    table = read(tmp_path, without(lost).text(), resample=True)
    off = table.torque("joint")[lost] - LOG.torque[lost]
    assert np.sqrt(np.mean(off**2)) < 0.01


@pytest.mark.parametrize("away_s", [0.5, 1.7e9])
def test_a_clock_that_was_set_meanwhile_parts_the_log_and_fills_nothing_between(tmp_path: Path, away_s: float) -> None:
    table = read(tmp_path, at_times(LOG.time + away_s * (np.arange(ROWS) > 2999), ".6f"), resample=True)
    # an epoch has no more digits than that
    assert abs(len(table) - (ROWS - 3000)) <= 1
    assert table.position("joint")[:4000] == pytest.approx(LOG.position[3000:7000], abs=2e-3)
    assert any("gaps that are too long to be bridged: 1" in note and "line 3002" in note for note in table.notes)


@pytest.mark.parametrize("form", ["%m/%d/%Y %H:%M:%S.%f", "%m/%d/%Y %I:%M:%S.%f %p", "%d.%m.%Y %H:%M:%S.%f"])
def test_days_and_months_stand_in_one_order_past_midnight(tmp_path: Path, form: str) -> None:
    begin = datetime(2024, 3, 9, 23, 59, 55)
    stamps = [(begin + timedelta(seconds=float(at))).strftime(form) for at in LOG.time]
    lines = LOG.text().splitlines()
    rows = [",".join([stamp, *line.split(",")[1:]]) for stamp, line in zip(stamps, lines[1:], strict=True)]
    table = read(tmp_path, "\n".join([lines[0], *rows]) + "\n")
    assert len(table) == ROWS and table.period_s == pytest.approx(0.002, rel=1e-6)


def test_the_words_that_are_proposed_for_a_file_with_times_of_its_own_read_it(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    rows = zip(LOG.time[:500], LOG.position, LOG.torque, strict=False)
    path.write_text("".join(json.dumps({"t": t, "q": q, "u": u}) + "\n" for t, q, u in rows))
    with pytest.raises(BadInputError, match=r"time_s=time_s joint\.position=q joint\.torque=u"):
        read_signals(path, AXES)
    words = ("time_s=time_s", "joint.position=q", "joint.torque=u")
    assert len(read_signals(path, AXES, columns=ColumnMap.of_words(words))) == 500


@pytest.mark.parametrize("kind", ["behind 60 Hz", "refreshed every other row"])
def test_a_torque_that_lags_leaves_an_inertia_whose_interval_holds_the_truth(
    tmp_path: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    torque = lfilter(*butter(1, 60.0 / 250.0), LOG.torque) if kind == "behind 60 Hz" else np.repeat(LOG.torque[::2], 2)
    columns = {"time_s": LOG.time, "joint.torque": torque, "joint.position": LOG.position}
    (tmp_path / "log.csv").write_text(table_text(columns))
    (tmp_path / "model.yaml").write_text(BENCH.model_text())
    words = ["--model", str(tmp_path / "model.yaml"), "--out", str(tmp_path / "out"), "--json"]
    assert run("identify", [str(tmp_path / "log.csv"), *words]) == 0
    found = {one["name"]: one for one in json.loads(capsys.readouterr().out)["axes"][0]["estimates"]}
    assert found["inertia"]["verdict"] == "identified"
    assert found["inertia"]["low"] <= TRUE["inertia"] <= found["inertia"]["high"]


def test_milliseconds_that_are_not_even_are_told_their_unit_first_and_row_numbers_their_rate(tmp_path: Path) -> None:
    with pytest.raises(
        BadInputError, match=r"line \d+, column time_s: .*: --column time_s=time_s:ms for millisec"
    ) as found:
        read(tmp_path, at_times(2.5e0 * np.arange(ROWS), ".0f"))
    assert "accepts" not in str(found.value)
    numbered = read(tmp_path, at_times(np.arange(ROWS), ".0f"), rate_hz=500.0)
    assert numbered.period_s == pytest.approx(0.002, rel=1e-9) and len(numbered) == ROWS


def test_a_line_of_remarks_between_header_and_rows_hides_no_header(tmp_path: Path) -> None:
    lines = LOG.text().splitlines()
    assert len(read(tmp_path, "\n".join([lines[0], "connection lost", *lines[1:]]) + "\n")) == ROWS


def test_columns_by_number_do_for_a_header_of_other_words(tmp_path: Path) -> None:
    lines = LOG.text().splitlines()
    words = ("time_s=1", "joint.torque=2", "joint.position=3")
    assert len(read(tmp_path, "\n".join(["time_s,joint.torque", *lines[1:]]) + "\n", *words)) == ROWS
