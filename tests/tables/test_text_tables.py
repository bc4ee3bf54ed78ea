"""Text of any logger is read as what it means, or refused by line and column."""

from __future__ import annotations

import gzip
import re
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import ColumnMap, SignalsTable, read_signals
from gimbal_hil.data.tables.moments import seconds_of
from tests.tables.joint import HEADER, ROWS, Q, T, U, grouped, lines

NAMED = ("time_s=t", "joint.torque=tau", "joint.position=q")
BY_NUMBER = ("time_s=1", "joint.torque=#2", "joint.position=3")


def read(path: Path, text: str | bytes, words: tuple[str, ...] = (), **options: float | bool) -> SignalsTable:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_signals(path, ("joint",), columns=ColumnMap.of_words(words), **options)  # type: ignore[arg-type]


def whole(some: list[str]) -> str:
    return "\n".join(some) + "\n"


def with_units(between: str = ",") -> list[str]:
    return lines(between, ("t", "tau", "q"))


#: what a logger wrote, and the `--column` that reads it
FORMS: dict[str, tuple[str | bytes, tuple[str, ...]]] = {
    "plain": (whole(lines()), ()),
    "quoted": (whole([",".join(f'"{cell}"' for cell in line.split(",")) for line in lines()]), ()),
    "semicolons and decimal commas": (whole(lines(";", comma=True)), ()),
    "tabs and decimal commas": (whole(lines("\t", comma=True)), ()),
    "spaces": (whole(lines("   ")), ()),
    "spaces that align": (whole([" " + line for line in lines("  ")]), ()),
    "bars": (whole(lines(" | ")), ()),
    "separator stated": ("sep=;\n" + whole(lines(";")), ()),
    "preamble": ("Logger 3\nDate,2024/01/02\nSamples,600\n\n" + whole(lines()), ()),
    "preamble of numbers": ("Logger,3,7\nSamples,600,1\nGain,0.5\n\n" + whole(lines()), ()),
    "remarks above": ("# joint 1\n# 500 Hz\n" + whole(lines()), ()),
    "header as a remark": ("# " + whole(lines()), ()),
    "percent of ROS": ("%" + whole(with_units()), ("time_s=%t", *NAMED[1:])),
    "remark among rows": (whole([*lines()[:50], "# overrun", *lines()[50:]]), ()),
    "header again": (whole([*lines()[:50], ",".join(HEADER), *lines()[50:]]), ()),
    "no header": (whole(lines(header=None)), BY_NUMBER),
    "no header, spaces": (whole(lines(" ", header=None)), BY_NUMBER),
    "units below": (whole([lines()[0], "s,N m,rad", *lines()[1:]]), ()),
    "two levels": (whole(["time_s,joint,joint", ",torque,position", *lines()[1:]]), ()),
    "a title above": (whole(["Run 5,,", *lines()]), ()),
    "separator at every end": (whole(lines(end=",")), ()),
    "separator at the end of rows": (whole([lines()[0], *lines(end=",")[1:]]), ()),
    "row numbers without a name": (whole([lines()[0], *(f"{k},{one}" for k, one in enumerate(lines()[1:]))]), ()),
    "names in another form": (whole(["# t  tau  q", *lines(";")[1:]]), NAMED),
    "names with units and spaces": (whole(["t [s]  tau [N m]  q [rad]", *lines(" ")[1:]]), BY_NUMBER),
    "blank lines": ("\n\n" + "\n\n".join(lines()) + "\n\n", ()),
    "carriage returns": ("\r".join(lines()) + "\r", ()),
    "of three line ends": ("\r\r\n".join(lines()) + "\r\r\n", ()),
    "zeros behind": (whole(lines()).encode() + bytes(4096), ()),
    "UTF-16": (whole(lines()).encode("utf-16"), ()),
    "UTF-16 without a mark": (whole(lines()).encode("utf-16-le"), ()),
    "UTF-8 with a mark": (whole(lines()).encode("utf-8-sig"), ()),
    "cp1252": (
        whole(lines(header=("t", "tau [N·m]", "Stellung Ä"))).encode("cp1252"),
        ("time_s=t", "joint.torque=tau [N·m]", "joint.position=Stellung Ä"),
    ),
    "packed": (gzip.compress(whole(lines()).encode()), ()),
    "another minus": (whole(lines()).replace("-", "\u2212"), ()),
    "exponents of Fortran": (whole([lines()[0], *(f"{line}D+00" for line in lines()[1:])]), ()),
}


@pytest.mark.parametrize("form", FORMS)
def test_a_table_is_read_however_it_was_written(tmp_path: Path, form: str) -> None:
    text, words = FORMS[form]
    table = read(tmp_path / "run.log", text, words)
    assert np.allclose(table.position("joint"), Q, atol=1e-6)
    assert np.allclose(table.torque("joint"), U, atol=1e-6)
    assert np.allclose(table.time_s, T, atol=1e-9)


@pytest.mark.parametrize(
    "stamp",
    [
        lambda t: f"2024-02-29 23:59:{59 + t:09.6f}" if t < 1.0 else f"2024-03-01T00:00:{t - 1:09.6f}Z",
        lambda t: f"29.02.2024 23:59:{59 + t:09.6f}" if t < 1.0 else f"01.03.2024 00:00:{t - 1:09.6f}",
        lambda t: f"23:59:{59 + t:09.6f}" if t < 1.0 else f"00:00:{t - 1:09.6f}",
        lambda t: f"2024-01-31 23:59:{59 + t:09.6f}" if t < 1.0 else f"2024-02-01 00:00:{t - 1:09.6f}",
        lambda t: f"0 days 00:00:{t:09.6f}",
        lambda t: f"2/29/2024 11:59:{59 + t:09.6f} AM" if t < 1.0 else f"2/29/2024 12:00:{t - 1:09.6f} PM",
        lambda t: f"11:59:{59 + t:09.6f} p.m." if t < 1.0 else f"12:00:{t - 1:09.6f} a.m.",
        lambda t: f"12:59:{59 + t:09.6f}" if t < 1.0 else f"01:00:{t - 1:09.6f}",
        lambda t: f"59:{59 + t:09.6f}" if t < 1.0 else f"00:{t - 1:09.6f}",
    ],
)
def test_dates_and_times_of_day_count_from_the_first(tmp_path: Path, stamp: Callable[[float], str]) -> None:
    rows = [f"{stamp(t)};{u:.6f};{q:.6f}" for t, u, q in zip(T, U, Q, strict=True)]
    table = read(tmp_path / "log.csv", whole([";".join(HEADER), *rows]))
    assert np.allclose(table.time_s, T, atol=1e-6) and any("read as seconds" in note for note in table.notes)


@pytest.mark.parametrize("date", ["2024-02-{:02d}", "{:02d}.02.2024", "2/{:02d}/2024"])
def test_a_date_and_a_time_of_day_in_two_columns_count_midnight_once(tmp_path: Path, date: str) -> None:
    for begin, day in ((59.0, True), (59.0, False), (0.0, True)):
        stamps = [(int(begin + t >= 60.0 and day), (begin + t) % 60.0, begin + t >= 60.0) for t in T]
        rows = [
            f"{date.format(27 + on)};{'00:00' if late else '23:59'}:{second:09.6f};{u:.6f};{q:.6f}"
            for (on, second, late), u, q in zip(stamps, U, Q, strict=True)
        ]
        text = whole(["Date;Time;tau;q", *rows])
        words = ("time_s=Date+Time", "joint.torque=tau", "joint.position=q")
        table = read(tmp_path / "log.csv", text, words)
        assert np.allclose(table.time_s - table.time_s[0], T, atol=1e-6) and len(table) == len(T)


def test_cells_that_carry_their_names_need_no_header(tmp_path: Path) -> None:
    for between, is_ in ((" ", ":"), (",", ":"), ("\t", "="), (", ", " = ")):
        rows = [
            between.join(f"{name}{is_}{value:.6f}" for name, value in zip(("t", "tau 1", "q"), row, strict=True))
            for row in zip(T, U, Q, strict=True)
        ]
        rows.insert(0, "connected")
        words = ("time_s=t", "joint.torque=tau 1", "joint.position=q")
        table = read(tmp_path / "log.txt", whole(rows), words)
        assert np.allclose(table.position("joint"), Q, atol=1e-6) and np.allclose(table.time_s, T, atol=1e-6)
        assert any("carry the names of their columns: t, tau 1, q" in note for note in table.notes)
        with pytest.raises(BadInputError, match=r"line 21: .*1 cells where the header has 3: 'overrun'"):
            read(tmp_path / "log.txt", whole([*rows[:20], "overrun", *rows[20:]]), words)


COUNTS, MICROSECONDS = np.round(Q * 65536).astype(int), np.round(T * 1e6).astype(int)
IN_COUNTS = ("time_s=us:us", "joint.position=counts:rad/65536", "joint.torque=tau")


@pytest.mark.parametrize(("between", "mark", "comma"), [("\t", ",", False), (";", ".", True), ("|", "'", False)])
def test_marks_between_thousands_are_no_decimals(tmp_path: Path, between: str, mark: str, comma: bool) -> None:
    rows = [
        between.join((grouped(us, mark), grouped(n, mark), f"{u:.6f}".replace(".", "," if comma else ".")))
        for us, n, u in zip(MICROSECONDS.tolist(), COUNTS.tolist(), U, strict=True)
    ]
    table = read(tmp_path / "log.csv", whole([between.join(("us", "counts", "tau")), *rows]), IN_COUNTS)
    assert np.allclose(table.position("joint"), Q, atol=1e-5) and table.period_s == pytest.approx(2e-3)
    assert np.allclose(table.torque("joint"), U, atol=1e-6)


def test_each_column_has_its_own_decimal_mark(tmp_path: Path) -> None:
    rows = [f"{t:.3f};{u:.6f}".replace(".", ",") + f";{q:.6f}" for t, u, q in zip(T, U, Q, strict=True)]
    table = read(tmp_path / "log.csv", whole([";".join(HEADER), *rows]))
    assert np.allclose(table.position("joint"), Q, atol=1e-6) and np.allclose(table.torque("joint"), U, atol=1e-6)


def test_a_comma_that_may_part_either_is_refused_by_line_and_column(tmp_path: Path) -> None:
    rows = [f"{k}\t{grouped(20_000 + k, ',')}\t5" for k in range(40)]
    text = whole(["ms\tcounts\ttau", *rows])
    with pytest.raises(BadInputError, match=r"'20,000' in line 2, column counts, which may be 20000 or 20"):
        read(tmp_path / "log.tsv", text, ("time_s=ms:ms", "joint.position=counts", "joint.torque=tau"))
    # nobody asks for that column: nothing is in doubt
    read(tmp_path / "log.tsv", text, ("time_s=ms:ms", "joint.position=tau", "joint.torque=tau"))


def test_decimal_commas_parted_by_commas_are_told_as_that(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"6 cells a row and 3 names above them \(are the decimal commas"):
        read(tmp_path / "log.csv", whole(lines(comma=True)))


def test_a_last_line_without_its_end_is_named_by_line_and_column(tmp_path: Path) -> None:
    (note,) = read(tmp_path / "log.csv", whole(lines()) + "1.200,0.1,-8.9037").notes
    assert "line 602" in note and "column joint.position" in note and "'-8.9037'" in note


@pytest.mark.parametrize("header", [("t", "q", "q", "tau"), ("t", "q", "tau", "")])
def test_doubled_and_blank_names_matter_only_where_they_are_asked_for(tmp_path: Path, header: tuple[str, ...]) -> None:
    rows = [f"{t:.3f},{q:.6f},{u:.6f},{q:.6f}" for t, q, u in zip(T, Q, U, strict=True)]
    path, text = tmp_path / "log.csv", whole([",".join(header), *rows])
    read(path, text, ("time_s=t", "joint.torque=3", "joint.position=2"))
    if header.count("q") == 2:
        with pytest.raises(BadInputError, match="two columns named 'q'; expected q#1 or q#2"):
            read(path, text, ("time_s=t", "joint.torque=tau", "joint.position=q"))
        read(path, text, ("time_s=t", "joint.torque=tau", "joint.position=q#1"))


def test_two_columns_make_one_time(tmp_path: Path) -> None:
    ns = 1_732_340_000_999_000_000 + np.round(T * 1e9).astype(np.int64)
    rows = [f"{n // 10**9},{n % 10**9},{u:.6f},{q:.6f}" for n, u, q in zip(ns.tolist(), U, Q, strict=True)]
    text = whole(["stamp.sec,stamp.nanosec,tau,q", *rows])
    for words in ("time_s=stamp.sec+stamp.nanosec", "time_s=1:s+2:ns"):
        table = read(tmp_path / "log.csv", text, (words, *NAMED[1:]))
        assert np.allclose(table.time_s, T, atol=1e-9)


def test_rows_without_times_have_those_of_the_stated_rate(tmp_path: Path) -> None:
    rows = [f"{u:.6f}\t{q:.6f}" for u, q in zip(U, Q, strict=True)]
    words = ("joint.torque=1", "joint.position=2")
    table = read(tmp_path / "foc.txt", whole(rows), words, rate_hz=500.0)
    assert np.allclose(table.time_s, T) and any("as --rate says" in note for note in table.notes)
    with pytest.raises(BadInputError, match="--rate HZ for rows that have no times"):
        read(tmp_path / "foc.txt", whole(rows), words)
    with pytest.raises(BadInputError, match=r"line 31: is no row \('\[WARN\] overrun'\)"):
        read(tmp_path / "foc.txt", whole([*rows[:30], "[WARN] overrun", *rows[30:]]), words, rate_hz=500.0)


@pytest.mark.parametrize("wrap", ["65536", "2^16"])
def test_a_stated_wrap_carries_a_counter_on_and_gives_a_current_its_sign(tmp_path: Path, wrap: str) -> None:
    counts = np.round(3.0 * Q * 65536).astype(int) + 20_000
    current = np.round(U / 1e-3).astype(int) % 65536
    rows = [f"{t:.3f},{n % 65536},{i}" for t, n, i in zip(T, counts.tolist(), current.tolist(), strict=True)]
    words = ("time_s=t", f"joint.position=enc%{wrap}:rad/65536", f"joint.torque=i%{wrap}:mN m")
    table = read(tmp_path / "log.csv", whole(["t,enc,i", *rows]), words)
    assert np.allclose(table.position("joint"), counts / 65536) and np.allclose(table.torque("joint"), U, atol=6e-4)


def test_units_in_the_header_count_where_none_is_given(tmp_path: Path) -> None:
    path, text = tmp_path / "log.csv", whole([*lines(header=("t [s]", "tau (mNm)", "q [deg]"))])
    words = ("time_s=t [s]", "joint.torque=tau (mNm)", "joint.position=q [deg]")
    table = read(path, text, words)
    assert np.allclose(table.position("joint"), np.radians(Q), atol=1e-6)
    assert np.allclose(table.torque("joint"), 1e-3 * U, atol=1e-6)
    assert "joint.position is in deg, as the file says" in table.notes
    assert np.allclose(read(path, text, (*words[:2], "joint.position=q [deg]:1*rad")).position("joint"), Q, atol=1e-6)
    below = whole([",".join(HEADER), "[s],[Nm],[°]", *lines()[1:]])
    assert np.allclose(read(path, below).position("joint"), np.radians(Q), atol=1e-6)
    behind = whole(lines(header=("t/s", "tau_mNm", "q deg")))
    table = read(path, behind, ("time_s=t/s", "joint.torque=tau_mNm", "joint.position=q deg"))
    assert np.allclose(table.position("joint"), np.radians(Q), atol=1e-6)
    assert np.allclose(table.torque("joint"), 1e-3 * U, atol=1e-6)
    counts = whole([*lines(header=("t [s]", "tau (mNm)", "q [counts]"))])
    with pytest.raises(BadInputError, match=r"'counts', which the file says, is no unit for joint\.position"):
        read(path, counts, (*words[:2], "joint.position=q [counts]"))


def test_a_unit_that_contradicts_the_header_is_refused_unless_it_is_insisted_on(tmp_path: Path) -> None:
    text = whole(lines(header=("t [s]", "tau [N m]", "angle [deg]")))
    words = ("time_s=t [s]", "joint.torque=tau [N m]")
    with pytest.raises(
        BadInputError, match=r"angle \[deg\]:rad: contradicts the file, which says 'deg'.*:1\*rad to insist"
    ):
        read(tmp_path / "log.csv", text, (*words, "joint.position=angle [deg]:rad"))
    with pytest.raises(BadInputError, match="contradicts the file, which says 's'"):
        read(tmp_path / "log.csv", text, ("time_s=t [s]:min", *words[1:], "joint.position=angle [deg]"))
    asked = read(tmp_path / "log.csv", text, (*words, "joint.position=angle [deg]:1*rad"))
    assert np.allclose(asked.position("joint"), Q, atol=1e-6)
    mirrored = read(tmp_path / "log.csv", text, (*words, "joint.position=angle [deg]:-degrees"))
    assert np.allclose(mirrored.position("joint"), -np.radians(Q), atol=1e-6)


def test_where_the_clock_starts_again_the_longest_part_is_kept(tmp_path: Path) -> None:
    rows = lines()[1:]
    path, text = tmp_path / "log.csv", whole([lines()[0], *rows[:200], *rows[:350], *rows[:50]])
    with pytest.raises(BadInputError, match=r"line 202.*--drop-invalid \(keeps 350 of 600 rows\)"):
        read(path, text)
    for option in ("drop_invalid", "resample"):
        table = read(path, text, **{option: True})
        assert len(table) == 350 and np.allclose(table.position("joint"), Q[:350], atol=1e-6)
        assert any("starts again" in note and "line 202" in note for note in table.notes)


def test_rows_that_run_backwards_are_read_from_the_last(tmp_path: Path) -> None:
    path, text = tmp_path / "log.csv", whole([lines()[0], *lines()[:0:-1]])
    with pytest.raises(BadInputError, match="accepts such a log"):
        read(path, text)
    for option in ("drop_invalid", "resample"):
        assert np.allclose(read(path, text, **{option: True}).position("joint"), Q, atol=1e-6)


BAD: dict[str, Callable[[list[str]], list[str]]] = {
    "stamps that repeat": lambda rows: [one for row in rows for one in (row, row)],
    "stamps five times": lambda rows: [rows[k // 5 * 5] for k in range(ROWS)],
    "shuffled": lambda rows: [rows[k] for k in np.random.default_rng(1).permutation(ROWS)],
    "a log line": lambda rows: [*rows[:50], "Logging to: LD0029.CSV", *rows[50:]],
    "a footer": lambda rows: [*rows, "", "max,0.9,1.2", "mean,0.1,0.3"],
    "a cell of words": lambda rows: [*rows[:50], "0.100,fast,0.1", *rows[51:]],
    "a cell too large": lambda rows: [*rows[:50], "0.100,1e308,0.1", *rows[51:]],
    "a gap": lambda rows: [*rows[:50], *rows[90:]],
    "jitter": lambda rows: [f"{float(row[:5]) + 4e-4 * (k % 3):.4f}{row[5:]}" for k, row in enumerate(rows)],
    "one column empty": lambda rows: [row[: row.rindex(",") + 1] for row in rows],
}


@pytest.mark.parametrize("kind", BAD)
def test_every_remedy_that_is_printed_works(tmp_path: Path, kind: str) -> None:
    path, text = tmp_path / "log.csv", whole([lines()[0], *BAD[kind](lines()[1:])])
    with pytest.raises(BadInputError) as refused:
        read(path, text)
    proposed = re.findall(r"--(resample|drop-invalid) \(keeps (\d+) of (\d+) rows\)", str(refused.value))
    assert bool(proposed) == (kind not in ("stamps five times", "shuffled", "one column empty")), str(refused.value)
    for option, kept, rows in proposed:
        table = read(path, text, **{option.replace("-", "_"): True})
        assert table.notes and int(kept) <= int(rows) and len(table) >= int(kept) // 2


def test_archives_of_numpy_may_hold_records_dates_and_matrices(tmp_path: Path) -> None:
    records = np.rec.fromarrays([T, U, Q], names="t,tau,q")
    np.savez(tmp_path / "rec.npz", records)
    np.save(tmp_path / "rec.npy", records)
    np.savez(tmp_path / "matrix.npz", t=T, tau=U, q=np.stack((Q, Q), 1))
    np.savez(tmp_path / "dates.npz", t=np.datetime64("2024-01-01") + (T * 1e9).round().astype("m8[ns]"), tau=U, q=Q)
    for name, words in (("rec.npz", NAMED), ("rec.npy", NAMED), ("matrix.npz", (*NAMED[:2], "joint.position=q[1]")),
                        ("dates.npz", NAMED)):  # fmt: skip
        table = read_signals(tmp_path / name, ("joint",), columns=ColumnMap.of_words(words))
        assert np.allclose(table.position("joint"), Q) and np.allclose(table.time_s, T)


def test_a_column_that_is_missing_is_told_with_the_words_that_its_file_suggests(tmp_path: Path) -> None:
    text = whole(lines(header=("time [s]", "torque_mNm", "angle [deg]")))
    with pytest.raises(BadInputError) as refused:
        read(tmp_path / "log.csv", text)
    suggested = shlex.split(str(refused.value).partition("suggest --column ")[2])
    table = read(tmp_path / "log.csv", text, tuple(suggested))
    assert np.allclose(table.position("joint"), np.radians(Q), atol=1e-6)
    assert np.allclose(table.torque("joint"), 1e-3 * U, atol=1e-6)


def test_dates_that_begin_with_the_year_have_their_month_next() -> None:
    """However close together days of another order would lie."""
    found = seconds_of([f"2026-{month:02d}-01" for month in range(1, 5)])
    assert found is not None and found.tolist() == [0.0, 31 * 86400.0, 59 * 86400.0, 90 * 86400.0]


def test_a_clock_that_is_put_back_within_a_log_goes_on_where_its_zone_is_written() -> None:
    found = seconds_of(["2026-10-25 02:59:59.5+02:00", "2026-10-25 02:00:00+0100", "2026-10-25T01:00:00.5Z"])
    assert found is not None and found.tolist() == [0.0, 0.5, 1.0]
