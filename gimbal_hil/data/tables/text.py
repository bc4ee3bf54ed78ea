"""A table of text as columns of numbers: whatever parts its cells, wherever its header is."""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.tables.decoding import decoded
from gimbal_hil.data.tables.labels import arranged
from gimbal_hil.data.tables.layout import Layout, cells_of, is_number
from gimbal_hil.data.tables.marks import ColumnMarks, MarkUse, marks_of, plain, without_marks
from gimbal_hil.data.tables.moments import seconds_of
from gimbal_hil.data.tables.raw import EMPTY_WORDS, Floats, OddLine, RawColumns, cleaned, told_apart
from gimbal_hil.data.tables.unit_words import IN_BRACKETS, is_unit_word

#: lines below which a file is no log that was cut off
_LEAST_LINES = 10
_EXPECTED = "a table of text with one row per sample, its cells parted by commas, semicolons, tabs, bars or spaces"
_NAMES = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", None: "spaces"}
_LISTED = 60
#: a number with one mark between thousands is smaller, and so is what a mark for decimals would make of it
_LARGEST_GROUPED = 1e6


@dataclass
class _Rows:
    """Cells by row, the number of each row's line, and lines that are none."""

    cells: list[list[str]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    odd: list[OddLine] = field(default_factory=list)
    remarks: int = 0
    headers: int = 0


def read_text(path: Path, data: bytes) -> RawColumns:
    """The table in a file of text; BadInputError where there is none."""
    text, notes = decoded(path, data)
    lines = text.split("\n")
    cut = lines.pop()
    lines, layout = arranged([*lines, cut] if cut else lines)
    if layout is None:
        raise BadInputError(str(path), "is no table: no line of it has two cells", _EXPECTED)
    cut = lines.pop() if cut else cut
    if cut and len(lines) >= _LEAST_LINES:
        notes.append(_of_a_cut_line(cut, len(lines) + 1, layout))
    elif cut:
        lines.append(cut)
    names, doubts = told_apart(layout.names or [""] * layout.width)
    doubts |= _of_an_unfit_header(layout)
    notes += _of_the_layout(layout, lines)
    found = _all_numbers(lines, layout)
    if found is None:
        rows = _rows(lines, layout)
        columns = [[row[k] for row in rows.cells] for k in range(layout.width)]
        raw = _of_cells(path, names, columns, doubts, notes, np.array(rows.lines, np.int64))
        raw = _with_odd(raw, rows, notes)
    else:
        values, at = found
        good = {name: cleaned(column) for name, column in zip(names, values, strict=True)}
        raw = RawColumns(
            path,
            {name: column for name, (column, _) in good.items()},
            {name: texts for name, (_, texts) in good.items()},
            lines=at,
            doubts=doubts,
        )
    return RawColumns(
        raw.path,
        raw.values,
        raw.texts,
        odd=raw.odd,
        lines=raw.lines,
        units=_units(names, layout),
        doubts=raw.doubts,
        notes=(*notes, *raw.notes),
    )


def text_of_lines(path: Path, lines: Sequence[str]) -> RawColumns:
    """The table in lines that were no file of text by themselves; BadInputError where there is none."""
    return read_text(path, "".join(f"{line}\n" for line in lines).encode())


def looks_like_rows(data: bytes, path: Path) -> bool:
    """Whether a text of unknown ending is a table: most lines have numbers in columns."""
    try:
        text, _ = decoded(path, data)
    except BadInputError:
        return False
    lines = text.split("\n")
    lines, layout = arranged(lines)
    if layout is None:
        return False
    rows = [cells_of(line, layout.between) for line in lines[layout.first :] if line.strip()]
    numbers = sum(2 * sum(map(is_number, row)) >= len(row) for row in rows)
    return numbers >= _LEAST_LINES and 2 * numbers > len(rows)


def _units(names: Sequence[str], layout: Layout) -> dict[str, str]:
    """Units that the header states: a row of them, or words in brackets behind a name that are units."""
    if layout.units:
        return {name: unit for name, unit in zip(names, layout.units, strict=True) if unit}
    found = {name: match["unit"].strip() for name in names if (match := IN_BRACKETS.match(name))}
    return {name: unit for name, unit in found.items() if is_unit_word(unit)}


def _of_the_layout(layout: Layout, lines: Sequence[str]) -> list[str]:
    if layout.labelled:
        return ["its cells carry the names of their columns: " + ", ".join(layout.names)]
    notes = []
    if layout.header is None:
        notes.append(f"has no header: its columns are called 1 to {layout.width}")
    above = [place for place in range(layout.first if layout.header is None else layout.header) if lines[place].strip()]
    if above:
        begins = f"the header is in line {layout.header + 1}" if layout.header is not None else (
            f"the rows begin in line {layout.first + 1}"
        )  # fmt: skip
        notes.append(f"{begins}; what stands above was left out, beginning with {_short(lines[above[0]])!r}")
    if layout.between not in (",", ";", "\t"):
        notes.append(f"its cells are parted by {_NAMES[layout.between]}")
    return notes


def _of_an_unfit_header(layout: Layout) -> dict[str, tuple[str, str]]:
    """Doubts about the names in a line above the rows that has more or fewer words than they have cells."""
    count = len(layout.unfit)
    why = " (are the decimal commas parted by commas?)" if layout.between == "," and layout.width == 2 * count else ""
    return {
        name: (
            f"has {layout.width} cells a row and {count} names above them{why}",
            f"one name for each, or columns by number: --column NAME=1 to {layout.width}",
        )
        for name in layout.unfit
        if name
    }


def _of_a_cut_line(cut: str, number: int, layout: Layout) -> str:
    """What to know of a last line that has no end: which cell may be cut, since a number that was cut is one still."""
    cells = cells_of(cut, layout.between)
    place = min(len(cells), layout.width)
    name = layout.names[place - 1] if layout.names else str(place)
    return (
        f"line {number}, the last one, has no line end and was left out: it may be cut in column {name}, "
        f"where it reads {cells[-1] if cells else ''!r}"
    )


def _all_numbers(lines: Sequence[str], layout: Layout) -> tuple[Floats, np.ndarray] | None:
    """Columns (width, n) and lines (n,) of a file in which every cell is a plain number; None for another."""
    if layout.spare or layout.between == "|":
        return None
    rows = lines[layout.first :]
    text = "\n".join(rows)
    if layout.between != "," and "," in text:
        if "." in text:
            return None
        text = text.replace(",", ".")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # of a file without rows
            found = np.loadtxt(io.StringIO(text), np.float64, comments=None, delimiter=layout.between, ndmin=2)
    except (ValueError, UserWarning):
        return None
    if found.shape[1] != layout.width or (layout.between != "," and _may_be_thousands(found)):
        return None
    at = np.arange(len(rows)) + layout.first + 1
    if len(found) != len(rows):
        at = at[[bool(line.strip()) for line in rows]]
    return (found.T, at) if len(at) == len(found) else None


def _may_be_thousands(values: Floats) -> bool:
    """Whether every broken number of some column has three decimals and is above one: a point may part thousands."""
    small = np.where(np.abs(values) < _LARGEST_GROUPED, values, 0.0)
    broken = np.isfinite(small) & (small % 1.0 != 0.0)
    thousandths = np.where(broken, small * 1e3, 0.0)
    three = (np.abs(thousandths - np.round(thousandths)) < 1e-6) & (np.abs(values) >= 1.0)
    return bool(np.any(broken.any(axis=0) & np.all(three | ~broken, axis=0)))


def _rows(lines: Sequence[str], layout: Layout) -> _Rows:
    found = _Rows()
    header = lines[layout.header].strip() if layout.header is not None else None
    width = layout.width + layout.spare
    for number, line in enumerate(lines[layout.first :], layout.first + 1):
        bare = line.strip()
        if not bare:
            continue
        cells = cells_of(line, layout.between)
        if len(cells) == width or (layout.spare and len(cells) == layout.width):
            if bare == header:
                found.headers += 1
                continue
            found.cells.append(cells[: layout.width])
            found.lines.append(number)
        elif len(cells) == layout.width + 1 and cells[-1] == "":
            found.cells.append(cells[:-1])
            found.lines.append(number)
        elif bare[0] in "#%" or bare.startswith("//"):
            found.remarks += 1
        else:
            found.odd.append(OddLine(number, layout.width, len(cells), _short(bare)))
    return found


def _with_odd(raw: RawColumns, rows: _Rows, notes: list[str]) -> RawColumns:
    if rows.remarks:
        notes.append(f"remarks among the rows were left out, {rows.remarks} in all")
    if rows.headers:
        notes.append(f"the header comes again among the rows and was left out there, {rows.headers} in all")
    return RawColumns(
        raw.path, raw.values, raw.texts, odd=tuple(rows.odd), lines=raw.lines, doubts=raw.doubts, notes=raw.notes
    )


def _of_cells(
    path: Path,
    names: Sequence[str],
    columns: Sequence[Sequence[str]],
    doubts: Mapping[str, tuple[str, str]],
    notes: Sequence[str],
    lines: np.ndarray,
) -> RawColumns:
    values: dict[str, Floats] = {}
    texts: dict[str, dict[int, str]] = {}
    doubted = dict(doubts)
    said: list[str] = []
    bare = [[plain(cell) if is_number(cell) else "" for cell in cells] for cells in columns]
    for name, cells, numbers, marks in zip(names, columns, bare, marks_of(bare), strict=True):
        found = np.array([_number(number, marks, cell) for number, cell in zip(numbers, cells, strict=True)])
        if MarkUse.EITHER in (marks.point, marks.comma):
            doubted[name] = _of_marks(name, numbers, lines)
        elif MarkUse.THOUSANDS in (marks.point, marks.comma):
            said.append(f"in column {name} {_first_marked(numbers)} is {_of(_first_marked(numbers), marks):g}")
        if cells and not np.isfinite(found).any():
            # a date in points looks like a number and is none
            seconds = seconds_of(cells)
            if seconds is not None:
                said.append(f"column {name} holds dates or times of day and was read as seconds from the first of them")
                values[name], texts[name] = seconds, {}
                continue
        values[name], texts[name] = cleaned(found)
        texts[name] |= {
            row: _short(cell)
            for row, cell in enumerate(cells)
            if not math.isfinite(found[row]) and cell.strip().lower() not in EMPTY_WORDS
        }
    return RawColumns(path, values, texts, lines=lines, doubts=doubted, notes=tuple(said))


def _number(number: str, marks: ColumnMarks, cell: str) -> float:
    try:
        if number:
            return float(without_marks(number, marks))
        # words of numbers: inf, nan
        return float(cell) if cell.strip("+-").isalpha() else math.nan
    except ValueError:
        return math.nan


def _of(number: str, marks: ColumnMarks) -> float:
    return _number(number, marks, number)


def _first_marked(numbers: Sequence[str]) -> str:
    return next((one for one in numbers if "," in one or "." in one), "")


def _of_marks(name: str, numbers: Sequence[str], lines: np.ndarray) -> tuple[str, str]:
    """The doubt about a column in which a mark may part thousands or decimals."""
    row = next(k for k, one in enumerate(numbers) if "," in one or "." in one)
    digits = numbers[row].replace(",", "").replace(".", "")
    return (
        f"has {numbers[row]!r} in line {lines[row]}, column {name}, which may be {digits} or {int(digits) / 1000:g}",
        "numbers without marks between thousands",
    )


def _short(line: str) -> str:
    line = line.strip()
    return line if len(line) <= _LISTED else f"{line[:_LISTED]}..."
