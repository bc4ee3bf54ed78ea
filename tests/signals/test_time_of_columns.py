"""When the values of a row were in force: stamps of too few digits, columns that are early or late, sampled torque."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import ColumnMap, SignalsTable, read_signals

ROWS = 600
RATE_HZ = 500.0
TIME = np.arange(ROWS) / RATE_HZ
TORQUE = np.random.default_rng(1).normal(size=ROWS)
POSITION = np.sin(3.0 * TIME)


def log(path: Path, stamps: list[str], torque: np.ndarray = TORQUE) -> Path:
    rows = zip(stamps, torque.tolist(), POSITION.tolist(), strict=True)
    path.write_text("\n".join(["t,tau,q", *(f"{t},{u!r},{q!r}" for t, u, q in rows)]) + "\n", encoding="utf-8")
    return path


def read(path: Path, torque: str = "joint.torque=tau", **repair: float | bool) -> SignalsTable:
    words = ["time_s=t", torque, "joint.position=q"]
    return read_signals(path, ("joint",), columns=ColumnMap.of_words(words), **repair)  # type: ignore[arg-type]


@settings(max_examples=30, deadline=None)
@given(
    rate_hz=st.sampled_from([300.0, 500.0, 1000.0, 1200.0]),
    digits=st.integers(1, 3),
    start=st.floats(0.0, 1e5),
    cut=st.booleans(),
)
def test_rows_of_a_clock_with_too_few_digits_are_counted_and_none_is_left_out(
    tmp_path_factory: pytest.TempPathFactory, rate_hz: float, digits: int, start: float, cut: bool
) -> None:
    times = start + np.arange(ROWS) / rate_hz
    short = np.floor(times * 10**digits) / 10**digits if cut else np.round(times, digits)
    if len(np.unique(short)) < 10 or len(np.unique(short)) > 0.9 * ROWS:
        return
    path = log(tmp_path_factory.mktemp("clock") / "log.csv", [f"{t:.{digits}f}" for t in short])
    with pytest.raises(BadInputError, match="too few digits") as refused:
        read(path)
    assert "none out" in str(refused.value) and "--resample" not in str(refused.value)
    table = read(path, resample=True)
    assert len(table) == ROWS
    assert np.allclose(table.torque("joint"), TORQUE, atol=1e-9)
    assert table.period_s == pytest.approx(1.0 / rate_hz, rel=0.5 * 10**-digits * rate_hz / ROWS * 4.0)
    assert any("none was left out" in note for note in table.notes)


@pytest.mark.parametrize("start", [0.0, 0.3, 0.998])
def test_a_clock_of_whole_seconds_tells_its_rate_to_a_row(tmp_path: Path, start: float) -> None:
    count = 6000
    stamps = np.floor(start + np.arange(count) / 500.0)
    rows = [f"{t:.0f},{0.1 * np.sin(k / 90):.6f},{np.sin(k / 300):.6f}" for k, t in enumerate(stamps)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["time_s,joint.torque,joint.position", *rows]) + "\n")
    with pytest.raises(BadInputError, match=r"about 500 Hz .*--rate 500 counts"):
        read(path)


def test_stamps_that_say_nothing_need_the_rate_and_are_counted_with_it(tmp_path: Path) -> None:
    path = log(tmp_path / "log.csv", ["1.73234e+09"] * ROWS)
    for repair in ({}, {"resample": True}, {"drop_invalid": True}):
        with pytest.raises(BadInputError, match=r"share one stamp.*--rate HZ"):
            read(path, **repair)
    table = read(path, rate_hz=RATE_HZ)
    assert len(table) == ROWS and table.period_s == pytest.approx(1.0 / RATE_HZ)


def test_irregular_stamps_that_many_rows_share_are_never_thinned_in_silence(tmp_path: Path) -> None:
    stamps = np.repeat(np.cumsum(np.random.default_rng(2).uniform(0.001, 0.1, ROWS // 4)), 4)
    path = log(tmp_path / "log.csv", [f"{t:.6f}" for t in stamps])
    for repair in ({}, {"resample": True}, {"drop_invalid": True}):
        with pytest.raises(BadInputError, match="600 rows share 150 stamps"):
            read(path, **repair)


def test_rows_that_came_twice_hold_nothing_new_and_may_go(tmp_path: Path) -> None:
    path = log(tmp_path / "log.csv", [f"{t:.6f}" for t in TIME])
    lines = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join([lines[0], *(line for line in lines[1:] for _ in range(2))]) + "\n", encoding="utf-8")
    table = read(path, drop_invalid=True)
    assert len(table) == ROWS and np.array_equal(table.torque("joint"), TORQUE)
    assert any("600 rows were left out" in note for note in table.notes)


@pytest.mark.parametrize("rows", [1, 3])
def test_a_torque_stated_to_be_late_is_taken_earlier_by_whole_rows_exactly(tmp_path: Path, rows: int) -> None:
    late = np.concatenate([np.full(rows, TORQUE[0]), TORQUE[:-rows]])
    path = log(tmp_path / "log.csv", [f"{t:.6f}" for t in TIME], late)
    table = read(path, f"joint.torque=tau@-{2 * rows}ms")
    assert np.array_equal(table.torque("joint")[:-rows], TORQUE[:-rows])
    assert any(f"{2 * rows} ms earlier" in note for note in table.notes)


def test_a_part_of_a_row_keeps_the_impulse_and_the_unit_stands_behind_the_time(tmp_path: Path) -> None:
    path = log(tmp_path / "log.csv", [f"{t:.6f}" for t in TIME])
    table = read(path, "joint.torque=tau@-500us:mN m")
    expected = 1e-3 * (0.75 * TORQUE[:-1] + 0.25 * TORQUE[1:])
    assert np.allclose(table.torque("joint")[:-1], expected, atol=1e-12)


def test_a_sampled_torque_becomes_its_mean_over_the_row(tmp_path: Path) -> None:
    path = log(tmp_path / "log.csv", [f"{t:.6f}" for t in TIME])
    table = read(path, "joint.torque_sampled=tau")
    assert np.allclose(table.torque("joint")[:-1], 0.5 * (TORQUE[1:] + TORQUE[:-1]), atol=1e-15)
    assert any("mean of joint.torque_sampled" in note for note in table.notes)


@pytest.mark.parametrize(("source", "states"), [("tau", False), ("tau@0ms", True), ("tau@-2ms:mN m", True)])
def test_a_map_says_whether_it_states_the_time_of_a_torque(source: str, states: bool) -> None:
    assert ColumnMap({"joint.torque": source}).states_time_of("joint") is states


def test_the_time_column_itself_is_not_shifted(tmp_path: Path) -> None:
    path = log(tmp_path / "log.csv", [f"{t:.6f}" for t in TIME])
    words = ["time_s=t@-2ms", "joint.torque=tau", "joint.position=q"]
    with pytest.raises(BadInputError, match="shifts time_s"):
        read_signals(path, ("joint",), columns=ColumnMap.of_words(words))


@pytest.mark.parametrize("stair", [2, 5])
def test_a_log_whose_position_is_refreshed_every_few_rows_keeps_those_rows_and_says_so(
    tmp_path: Path, stair: int
) -> None:
    stairs = POSITION[np.maximum(1, (np.arange(ROWS) - 1) // stair * stair + 1)]
    rows = zip(TIME.tolist(), TORQUE.tolist(), stairs.tolist(), strict=True)
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["t,tau,q", *(f"{t:.6f},{u!r},{q!r}" for t, u, q in rows)]) + "\n", encoding="utf-8")
    table = read(path)
    assert table.period_s == pytest.approx(stair / RATE_HZ)
    assert np.allclose(table.position("joint")[1:-1], POSITION[1:][stair::stair][: len(table) - 2], atol=1e-12)
    assert table.torque("joint")[1] == pytest.approx(TORQUE[1 + stair : 1 + 2 * stair].mean())
    assert any(f"every {stair} rows only" in note for note in table.notes)


@pytest.mark.parametrize(("every", "first"), [(2, 0), (10, 0), (10, 7)])
def test_positions_on_straight_lines_between_reads_keep_the_reads(tmp_path: Path, every: int, first: int) -> None:
    reads = np.arange(first, ROWS, every)
    lines = np.interp(np.arange(ROWS), reads, POSITION[reads])
    rows = zip(TIME.tolist(), TORQUE.tolist(), lines.tolist(), strict=True)
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["t,tau,q", *(f"{t},{u!r},{q:.9g}" for t, u, q in rows)]) + "\n", encoding="utf-8")
    table = read(path)
    assert table.period_s == pytest.approx(every / RATE_HZ)
    assert np.min(np.abs(table.position("joint")[3] - POSITION[reads])) < 1e-8
    assert any(f"straight between reads every {every} rows only" in note for note in table.notes)


def test_torque_on_the_same_lines_as_the_position_stays_with_it(tmp_path: Path) -> None:
    reads = np.arange(0, ROWS, 10)
    lines = [np.interp(np.arange(ROWS), reads, column[reads]) for column in (TORQUE, POSITION)]
    path = tmp_path / "log.csv"
    rows = (f"{t},{u:.9g},{q:.9g}" for t, u, q in zip(TIME.tolist(), *lines, strict=True))
    path.write_text("\n".join(["t,tau,q", *rows]) + "\n", encoding="utf-8")
    assert len(read(path)) == ROWS


def test_an_encoder_that_changes_now_and_then_is_no_stair(tmp_path: Path) -> None:
    coarse = np.round(POSITION / 0.02) * 0.02
    rows = zip(TIME.tolist(), TORQUE.tolist(), coarse.tolist(), strict=True)
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["t,tau,q", *(f"{t:.6f},{u!r},{q!r}" for t, u, q in rows)]) + "\n", encoding="utf-8")
    assert len(read(path)) == ROWS
