"""Where in a text the rows are, what parts their cells, and which lines above them name the columns.

Nothing is asked of the first line: the middle of a log is rows, so what parts most of its lines into equally many
numbers is the separator. The first two lines that look like them are where the rows begin, and the nearest line above
with as many words is the header.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from gimbal_hil.data.tables.marks import LIKE_A_NUMBER
from gimbal_hil.data.tables.raw import EMPTY_WORDS
from gimbal_hil.data.tables.unit_words import is_unit_word

#: None is any space
SEPARATORS: tuple[str | None, ...] = (",", ";", "\t", "|", None)
_SAMPLE = 200
#: least share of cells with numbers among lines of one width
_NUMBERS = 0.25
_COMMENT = re.compile(r"^\s*(?:#|%|//|;)+\s*")
_RULE = re.compile(r"[\s\-=_*+|]+")
_WORDS_WITH_UNITS = re.compile(r"[^\s\[\](){}]+(?:\s*[\[({][^\])}]*[\])}])*(?:[^\s\[\](){}]+)*")
#: lines above the rows among which a header is looked for
_ABOVE = 6


@dataclass(frozen=True)
class Layout:
    """`width` cells a row, parted by `between` (None is any space); `first` is the index of the first line of rows.

    `names` are empty where no line names the columns; `header` is the index of the line that does. `units` are those
    of a row of units below it, or empty. `spare` says that each row ends in a separator. `unfit` are the words of a
    line above the rows that is no header because it has another number of them.
    """

    between: str | None
    width: int
    first: int
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    header: int | None = None
    spare: bool = False
    unfit: tuple[str, ...] = ()
    #: whether each cell came with its name
    labelled: bool = False


def cells_of(line: str, between: str | None) -> list[str]:
    """The cells of one line, quotes and spaces around them taken off."""
    if between is None:
        return line.split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(between)]
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=between, skipinitialspace=True), [])]
    except csv.Error:
        return [line]


def is_number(cell: str) -> bool:
    """Whether a cell may be a number, in any country."""
    return LIKE_A_NUMBER.fullmatch(cell) is not None


def layout_of(lines: Sequence[str]) -> Layout | None:
    """The layout of a text of lines; None where no line has two cells."""
    declared = next((line for line in lines if line.strip()), "")
    stated = re.fullmatch(r"sep=(.)", declared.strip("\n\ufeff ")) or re.fullmatch(r"sep=(\t)", declared)
    found = _separated(lines, (stated[1],) if stated else SEPARATORS)
    if found is None:
        return _of_words(lines)
    between, width, numeric = found
    first = _first_row(lines, between, width, numeric)
    if first is None:
        return _of_words(lines)
    # what stands above a header may look like rows too: those that have numbers throughout are below it
    whole = _first_row(lines, between, width, numeric, throughout=True)
    for begin in dict.fromkeys((first, first if whole is None else whole)):
        for seen, spare in ((width, False), (width - 1, True)):
            if spare and not _ends_empty(lines, between, width):
                break
            named = _named(lines, begin, between, seen, numeric)
            if named is not None:
                return Layout(between, seen, begin, *named, spare)
    wide = _ends_empty(lines, between, width)
    return Layout(between, width - wide, first, spare=wide, unfit=_unfit(lines, first, between))


def _separated(lines: Sequence[str], separators: Sequence[str | None]) -> tuple[str | None, int, frozenset[int]] | None:
    """Separator, cells a row and the places of columns of numbers, from the lines in the middle."""
    filled = [line for line in lines if line.strip()]
    start = max(0, (len(filled) - _SAMPLE) // 2)
    sample = filled[start : start + _SAMPLE]
    best: tuple[float, str | None, int, frozenset[int]] | None = None
    for between in separators:
        rows = [cells_of(line, between) for line in sample if not _COMMENT.match(line)]
        widths = Counter(len(row) for row in rows if len(row) > 1)
        if not widths:
            continue
        width, count = widths.most_common(1)[0]
        alike = [row for row in rows if len(row) == width]
        shares = [sum(is_number(row[k]) for row in alike) / count for k in range(width)]
        numbers = sum(sum(is_number(cell) or cell.lower() in EMPTY_WORDS for cell in row) for row in alike)
        score = numbers / (count * width) * count / len(rows)
        numeric = frozenset(k for k, share in enumerate(shares) if share >= 0.5)
        if numeric and score >= _NUMBERS and (best is None or score > best[0] + 1e-9):
            best = score, between, width, numeric
    return None if best is None else best[1:]


def _first_row(
    lines: Sequence[str], between: str | None, width: int, numeric: frozenset[int], throughout: bool = False
) -> int | None:
    """Index of the first line of two that are rows, blank ones between them aside; of the only one in a short text.
    `throughout` says that they have numbers, or nothing, wherever most rows have numbers.
    """
    found: int | None = None
    for place, line in enumerate(lines):
        if not line.strip():
            continue
        cells = cells_of(line, between)
        row = is_row(cells, width, numeric) and not _COMMENT.match(line)
        if throughout:
            row = row and all(is_number(cells[k]) or cells[k].lower() in EMPTY_WORDS for k in numeric)
        if row and found is not None:
            return found
        found = place if row else None
    return found


def is_row(cells: Sequence[str], width: int, numeric: frozenset[int]) -> bool:
    """Whether cells are those of a row: as many, and numbers where most rows have them."""
    if len(cells) != width:
        return False
    return 2 * sum(is_number(cells[k]) for k in numeric) >= len(numeric)


def _ends_empty(lines: Sequence[str], between: str | None, width: int) -> bool:
    """Whether every line in the middle ends in a separator."""
    filled = [line for line in lines if line.strip()]
    start = max(0, (len(filled) - _SAMPLE) // 2)
    rows = [cells_of(line, between) for line in filled[start : start + _SAMPLE]]
    alike = [row for row in rows if len(row) == width]
    return bool(alike) and all(row[-1] == "" for row in alike)


def _named(
    lines: Sequence[str], first: int, between: str | None, width: int, numeric: frozenset[int]
) -> tuple[tuple[str, ...], tuple[str, ...], int] | None:
    """Names, units and the index of the line of names above the rows; None where none has as many words."""
    above = list(_above(lines, first))
    for k, (place, line) in enumerate(above):
        names = _header_cells(line, between, width, _counts(lines, first, between))
        if names is None:
            if _COMMENT.match(line) or _RULE.fullmatch(line) or (between is not None and between not in line):
                continue
            return None
        upper = _header_cells(above[k + 1][1], between, width, False) if k + 1 < len(above) else None
        units = _units_row(names)
        if upper is not None and units is not None:
            return tuple(upper), units, above[k + 1][0]
        if upper is not None and _is_second_level(upper, names):
            both = (".".join(word for word in pair if word) for pair in zip(upper, names, strict=True))
            return tuple(both), (), above[k + 1][0]
        return tuple(names), (), place
    return None


def _unfit(lines: Sequence[str], first: int, between: str | None) -> tuple[str, ...]:
    """The nearest line above the rows, where it is several words."""
    above = next(_above(lines, first), None)
    cells = () if above is None else cells_of(_COMMENT.sub("", above[1], count=1), between)
    return tuple(cells) if len(cells) > 1 and not any(map(is_number, cells)) else ()


def _above(lines: Sequence[str], first: int) -> Iterator[tuple[int, str]]:
    """The lines above the rows that are not blank, the nearest first."""
    filled = [(place, lines[place]) for place in range(first - 1, -1, -1) if lines[place].strip()]
    yield from filled[:_ABOVE]


def _header_cells(line: str, between: str | None, width: int, counts: bool) -> list[str] | None:
    """The words of a line that could name `width` columns; None where they are other in number, or numbers."""
    bare = _COMMENT.sub("", line, count=1) if _COMMENT.match(line) else line
    for text in dict.fromkeys((bare, line)):
        for separator in (between, *(one for one in SEPARATORS if one != between)):
            cells = _WORDS_WITH_UNITS.findall(text) if separator is None else cells_of(text, separator)
            if len(cells) == width + 1 and cells[-1] == "":
                cells = cells[:-1]
            if counts and len(cells) == width - 1 and separator == between:
                # what pandas and R write without a name: the number of the row
                cells = ["", *cells]
            if len(cells) == width and any(cells) and not any(map(is_number, cells)):
                return cells
    return None


def _counts(lines: Sequence[str], first: int, between: str | None) -> bool:
    """Whether the first cells of the rows count by one."""
    firsts = [cells_of(line, between)[0] for line in lines[first : first + 20] if line.strip()]
    return all(cell.isdecimal() for cell in firsts) and all(
        int(after) == int(before) + 1 for before, after in pairwise(firsts)
    )


def _units_row(cells: Sequence[str]) -> tuple[str, ...] | None:
    """The units of a row of them, brackets taken off; None where a word is no unit."""
    bare = tuple(cell.strip("[](){} ") for cell in cells)
    words = [word for word in bare if word]
    return bare if words and all(map(is_unit_word, words)) else None


def _is_second_level(upper: Sequence[str], lower: Sequence[str]) -> bool:
    """Whether only both lines together tell the columns apart, as the two levels of pandas do; one word above names
    that do so by themselves is a title.
    """
    if sum(map(bool, upper)) == 1 and "" not in lower and len(set(lower)) == len(lower):
        return False
    return ("" in lower or "" in upper or len(set(lower)) < len(lower) or len(set(upper)) < len(upper)) and (
        len(set(zip(upper, lower, strict=True))) == len(lower)
    )


def _of_words(lines: Sequence[str]) -> Layout | None:
    """A text without rows of numbers: its first line that has cells is a header."""
    for place, line in enumerate(lines):
        for between in SEPARATORS[:-1]:
            names = cells_of(line, between)
            if len(names) > 1:
                return Layout(between, len(names), place + 1, tuple(names), header=place)
    return None
