"""Signals tables from CSV and Parquet: what is sound comes in exactly, what is not is refused by file, row and
column.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable, read_signals, write_signals

AXES = ("outer", "inner")
HEADER = "time_s,outer.torque,outer.position,inner.torque,inner.position"


def csv_lines(rows: int = 50, period: float = 0.001) -> list[str]:
    return [HEADER] + [
        f"{k * period:.6f},{0.1 * k},{math.sin(k / 9)!r},{-0.1 * k},{math.cos(k / 9)!r}" for k in range(rows)
    ]


def write_lines(path: Path, lines: list[str]) -> Path:
    path.write_text("\n".join(lines) + "\n")
    return path


def refusal(path: Path, **options: bool) -> str:
    with pytest.raises(BadInputError) as caught:
        read_signals(path, AXES, **options)
    text = str(caught.value)
    assert "\n" not in text and path.name in text
    return text


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    optional=st.sets(
        st.sampled_from(
            ["outer.rate", "inner.temperature", "outer.position_ref", "base.roll", "base.r", "outer.torque_measured"]
        )
    ),
    laps=st.booleans(),
    ending=st.sampled_from(["csv", "parquet", "npz"]),
)
def test_a_written_table_is_read_back_bit_for_bit(
    tmp_path_factory: pytest.TempPathFactory, seed: int, optional: set[str], laps: bool, ending: str
) -> None:
    random = np.random.default_rng(seed)
    names = ["outer.torque", "outer.position", "inner.torque", "inner.position", *optional]
    columns = {name: random.normal(size=40) * 10.0 ** random.integers(-12, 3) for name in names}
    table = SignalsTable.of(
        AXES, np.arange(40) * 1e-3 + random.normal(), columns, np.arange(40) // 10 if laps else None
    )
    path = tmp_path_factory.mktemp("table") / f"log.{ending}"
    write_signals(table, path)
    found = read_signals(path, AXES)
    assert found.time_s.tobytes() == table.time_s.tobytes()
    assert {name: values.tobytes() for name, values in found.columns.items() if name != "base.roll"} == {
        name: values.tobytes() for name, values in table.columns.items() if name != "base.roll"
    }
    assert (found.repeat is None) == (not laps) and found.notes == ()
    if laps:
        assert found.repeat is not None and found.repeat.tolist() == (np.arange(40) // 10).tolist()


def test_arrays_of_a_table_cannot_be_written_to(tmp_path: Path) -> None:
    table = read_signals(write_lines(tmp_path / "log.csv", csv_lines()), AXES)
    with pytest.raises(ValueError, match="read-only"):
        table.torque("outer")[0] = 1.0
    with pytest.raises(TypeError):
        table.columns["outer.torque"] = table.time_s  # type: ignore[index]


def test_the_period_is_the_mean_one_and_optional_columns_are_none(tmp_path: Path) -> None:
    table = read_signals(write_lines(tmp_path / "log.csv", csv_lines(period=0.002)), AXES)
    assert table.period_s == pytest.approx(0.002, rel=1e-9)
    assert (
        len(table) == 50
        and table.signal("outer", "rate") is None
        and table.base("roll") is None
        and table.repeat is None
    )


@pytest.mark.parametrize(
    ("line", "text", "words"),
    [
        (7, "0.005000,nan,0,0,0", ("line 7", "outer.torque", "not a number")),
        (7, "0.005000,0,,0,0", ("line 7", "outer.position", "empty")),
        (7, "0.005000,0,0,fast,0", ("line 7", "inner.torque", "'fast'")),
        (7, "0.005000,0,0,0,inf", ("line 7", "inner.position", "'inf'")),
        (7, "soon,0,0,0,0", ("line 7", "time_s", "'soon'")),
        (7, "0.004000,0,0,0,0", ("line 7", "time_s", "same as in the row before")),
        (7, "0.003500,0,0,0,0", ("line 7", "time_s", "not later")),
        (7, "0.005100,0,0,0,0", ("line 7", "time_s", "jitter over 5 %")),
        (7, "0.005000,0,0,0", ("line 7", "4 cells", "header has 5")),
        (7, "0.005000,0,0,0,0,0", ("line 7", "6 cells", "header has 5")),
    ],
)
def test_a_bad_row_is_refused_by_line_and_column_and_both_options_accept_it(
    tmp_path: Path, line: int, text: str, words: tuple[str, ...]
) -> None:
    lines = csv_lines()
    lines[line - 1] = text
    path = write_lines(tmp_path / "log.csv", lines)
    message = refusal(path)
    assert all(word in message for word in words), message
    assert "--resample" in message and "--drop-invalid" in message
    kept, resampled = read_signals(path, AXES, drop_invalid=True), read_signals(path, AXES, resample=True)
    both = read_signals(path, AXES, drop_invalid=True, resample=True)
    assert kept.notes and resampled.notes and both.notes
    assert 40 <= len(kept) <= 50 and len(resampled) == len(both) == 50
    for table in (kept, resampled, both):
        assert np.ptp(np.diff(table.time_s)) < 1e-9
        assert all(np.isfinite(values).all() for values in table.columns.values())


def test_a_gap_is_refused_cut_at_or_filled_with_torques_between_its_ends(tmp_path: Path) -> None:
    lines = csv_lines(100)
    path = write_lines(tmp_path / "log.csv", lines[:31] + lines[34:])
    message = refusal(path)
    assert "line 32" in message and "a gap" in message and "1 gaps" in message
    kept = read_signals(path, AXES, drop_invalid=True)
    assert (len(kept), kept.time_s[0]) == (67, 0.033)
    filled = read_signals(path, AXES, resample=True)
    assert len(filled) == 100
    assert any("3 of them bridge gaps" in note for note in filled.notes)
    assert filled.torque("outer")[29:34] == pytest.approx([2.9, 3.0, 3.1, 3.2, 3.3])
    assert filled.position("outer")[20] == pytest.approx(np.sin(20 / 9))


def test_a_torque_that_is_sent_more_slowly_than_the_rows_is_held_between_its_samples(tmp_path: Path) -> None:
    """Empty cells between are no missing rows; and of rows that are missing a long stretch is not bridged."""
    held = np.repeat(np.random.default_rng(5).normal(size=40), 10)
    lines = [HEADER] + [f"{k * 1e-3:.6f},{held[k] if k % 10 == 0 else ''},{k * 1e-3},0,0" for k in range(391)]
    table = read_signals(write_lines(tmp_path / "log.csv", lines), AXES, resample=True)
    assert table.torque("outer")[:380] == pytest.approx(held[:380], abs=1e-9)


def test_resampling_keeps_the_impulse_of_the_torque_and_the_line_of_the_position(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    times = np.arange(400) * 1e-3 + random.uniform(-3e-4, 3e-4, 400)
    times[0], times[-1] = 0.0, 0.399
    torque = random.normal(size=400)
    lines = [HEADER] + [
        f"{t!r},{u!r},{2.5 * t + 1!r},0,0" for t, u in zip(times.tolist(), torque.tolist(), strict=True)
    ]
    table = read_signals(write_lines(tmp_path / "log.csv", lines), AXES, resample=True)
    held = float(np.sum(torque[:-1] * np.diff(times)))
    grid_end = table.time_s[-1]
    covered = float(np.sum(table.torque("outer")[:-1]) * table.period_s)
    tail = float(np.sum((np.minimum(times[1:], np.inf) - np.maximum(times[:-1], grid_end)).clip(0) * torque[:-1]))
    assert covered == pytest.approx(held - tail, abs=1e-12)
    assert table.position("outer") == pytest.approx(2.5 * table.time_s + 1, abs=1e-12)


def test_a_wrapped_heading_is_unwrapped_and_laps_follow_their_rows(tmp_path: Path) -> None:
    yaw = np.arange(50) * 0.2
    lines = [f"{HEADER},base.yaw,repeat"]
    lines += [f"{k * 1e-3:.6f},0,0,0,0,{math.remainder(yaw[k], math.tau)!r},{k // 10}" for k in range(50)]
    for table in (
        read_signals(write_lines(tmp_path / "log.csv", lines), AXES),
        read_signals(write_lines(tmp_path / "cut.csv", lines[:25] + lines[26:]), AXES, resample=True),
    ):
        heading = table.base("yaw")
        assert heading is not None and heading == pytest.approx(yaw, abs=1e-9)
        assert table.repeat is not None and table.repeat.tolist() == [k // 10 for k in range(50)]


def test_a_broken_lap_number_is_refused(tmp_path: Path) -> None:
    lines = [f"{HEADER},repeat"] + [f"{line},{0.5 if k == 4 else 0}" for k, line in enumerate(csv_lines()[1:])]
    assert "line 6, column repeat" in refusal(write_lines(tmp_path / "log.csv", lines))


def test_unknown_columns_are_reported_and_left_out(tmp_path: Path) -> None:
    lines = [f"{HEADER},outer.voltage,note"] + [f"{line},1,hello" for line in csv_lines()[1:]]
    table = read_signals(write_lines(tmp_path / "log.csv", lines), AXES)
    assert any("'outer.voltage'" in note for note in table.notes) and any("'note'" in note for note in table.notes)
    assert set(table.columns) == set(HEADER.split(",")[1:])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((HEADER.replace("outer.torque", "outer.torqe"),), ("no column 'outer.torque'", "'outer.torqe'")),
        ((HEADER.replace("time_s", "t"),), ("no column 'time_s'",)),
        ((HEADER.replace("inner", "elevation"),), ("no column 'inner.torque'", "outer, inner")),
        ((HEADER.replace("inner.torque", "outer.torque"),), ("two columns named 'outer.torque'",)),
        ((HEADER.replace(",", "~"),), ("parted by commas",)),
    ],
)
def test_a_wrong_header_is_refused_by_the_column_it_lacks(
    tmp_path: Path, change: tuple[str], words: tuple[str, ...]
) -> None:
    lines = [change[0]] + [line.replace(",", "~") if "~" in change[0] else line for line in csv_lines()[1:]]
    message = refusal(write_lines(tmp_path / "log.csv", lines))
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    "content", [b"", b"PAR1 cut", b"\x89PNG\r\n\0\xff\xfe", bytes(range(256)) * 20, HEADER.encode(), b"\n\n\n"]
)
@pytest.mark.parametrize("name", ["log.csv", "log.parquet", "log.npz", "log"])
def test_a_foreign_or_empty_file_is_refused_in_one_line(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    refusal(tmp_path / name)


@settings(max_examples=60, deadline=None)
@given(content=st.binary(max_size=300))
def test_any_bytes_at_all_are_a_table_or_bad_input(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.mktemp("any") / "log.csv"
    path.write_bytes(HEADER.encode() + b"\n" + content)
    with pytest.raises(BadInputError):
        read_signals(path, AXES)


def test_a_truncated_parquet_file_is_refused(tmp_path: Path) -> None:
    table = read_signals(write_lines(tmp_path / "log.csv", csv_lines()), AXES)
    write_signals(table, tmp_path / "log.parquet")
    content = (tmp_path / "log.parquet").read_bytes()
    (tmp_path / "log.parquet").write_bytes(content[: len(content) // 2])
    assert "no whole Parquet file" in refusal(tmp_path / "log.parquet")


def test_parquet_cells_without_a_number_are_named_by_row(tmp_path: Path) -> None:
    columns = {name: pa.array([float(k) for k in range(20)]) for name in HEADER.split(",")}
    columns["inner.position"] = pa.array([None if k == 3 else k for k in range(20)], pa.int64())
    pq.write_table(pa.table(columns), tmp_path / "log.parquet")
    assert "row 4, column inner.position" in refusal(tmp_path / "log.parquet")
    columns["inner.position"] = pa.array(["x"] * 20)
    pq.write_table(pa.table(columns), tmp_path / "log.parquet")
    assert "row 1, column inner.position: holds 'x'" in refusal(tmp_path / "log.parquet")
    with pytest.raises(BadInputError, match="holds no number at all"):
        read_signals(tmp_path / "log.parquet", AXES, resample=True)


def test_an_archive_of_numpy_is_a_table_unless_its_arrays_differ_in_length_or_it_is_cut(tmp_path: Path) -> None:
    columns = {name: np.arange(20.0) for name in HEADER.split(",")} | {"time_s": np.arange(20) * 1e-3}
    path = tmp_path / "log.npz"
    np.savez(path, **columns)
    assert read_signals(path, AXES).position("inner").tolist() == list(range(20))
    content = path.read_bytes()
    for size in range(0, len(content), 97):
        path.write_bytes(content[:size])
        refusal(path)
    np.savez(path, **columns | {"outer.torque": np.arange(19.0)})
    assert "several shapes" in refusal(path)
    np.savez(path, **columns | {"inner.torque": np.array(["fast"] * 20)})
    assert "row 1, column inner.torque: holds 'fast'" in refusal(path)
    np.savez(path, **columns | {"inner.torque": np.array([None] * 20)})
    assert "no whole npz file" in refusal(path)


@pytest.mark.parametrize("action", ["write", "read"])
def test_parquet_without_its_package_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, action: str
) -> None:
    table = read_signals(write_lines(tmp_path / "log.csv", csv_lines()), AXES)
    write_signals(table, tmp_path / "log.parquet")
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(BadInputError, match=r"needs the package pyarrow.*gimbal-hil\[parquet\]"):
        read_signals(tmp_path / "log.parquet", AXES) if action == "read" else write_signals(
            table, tmp_path / "other.parquet"
        )
    write_signals(table, tmp_path / "other.npz")


def test_a_missing_file_and_a_folder_without_a_run_are_refused(tmp_path: Path) -> None:
    assert "no such file" in refusal(tmp_path / "log.csv")
    assert "is not a run folder" in refusal(tmp_path)


def test_writing_refuses_what_is_there_and_leaves_nothing_half_written(tmp_path: Path) -> None:
    table = read_signals(write_lines(tmp_path / "log.csv", csv_lines()), AXES)
    before = (tmp_path / "log.csv").read_bytes()
    with pytest.raises(BadInputError, match="already exists"):
        write_signals(table, tmp_path / "log.csv")
    assert (tmp_path / "log.csv").read_bytes() == before
    with pytest.raises(BadInputError, match="ending"):
        write_signals(table, tmp_path / "log.xlsx")
    with pytest.raises(BadInputError, match="not a folder"):
        write_signals(table, tmp_path / "no" / "log.csv")
    write_signals(table, tmp_path / "log.csv", force=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.csv"]


def coming_round(rows: int = 4000) -> tuple[np.ndarray, list[str]]:
    """The angle of a joint that turns on, and the lines of a log in which its encoder begins again each turn."""
    angle = 3.0 + 4.0 * np.sin(0.002 * np.arange(rows))
    lines = [HEADER] + [f"{k * 1e-3:.6f},0.1,{a % (2.0 * math.pi)!r},0.1,0.0" for k, a in enumerate(angle.tolist())]
    return angle, lines


def test_an_encoder_that_begins_again_each_turn_is_carried_on(tmp_path: Path) -> None:
    angle, lines = coming_round()
    table = read_signals(write_lines(tmp_path / "round.csv", lines), AXES)
    turns = (table.position("outer") - angle) / (2.0 * math.pi)
    assert np.ptp(turns) < 1e-9 and any("whole turns were added" in note for note in table.notes)


def test_a_jump_that_is_no_whole_turn_stays(tmp_path: Path) -> None:
    lines = csv_lines(200)
    lines[100:] = [line.replace(line.split(",")[2], repr(4.0 + float(line.split(",")[2]))) for line in lines[100:]]
    table = read_signals(write_lines(tmp_path / "jump.csv", lines), AXES)
    assert np.max(np.abs(np.diff(table.position("outer")))) > 3.5 and not table.notes
