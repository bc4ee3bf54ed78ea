"""Points and commas in numbers: which of them part thousands and which decimals, told by each column for itself.

`20.480` is 20480 where another column has decimal commas, and 20.48 where none has. A mark that comes twice in a
number, or that parts groups of three in every number above 999 and is missing in all below, parts thousands. One after
a leading zero, or before fewer or more than three digits, parts decimals. Where nothing tells, a comma is no number.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

#: what a number may look like in any country
LIKE_A_NUMBER = re.compile(
    r"[+\-\u2212]?(?:\d+(?:[.,'\u2019\u00a0\u202f]\d+)*\.?|[.,]\d+)(?:[eEdD][+\-\u2212]?\d+)?", re.ASCII
)
#: other numbers than this many are too few to tell a habit of a column
_HABIT = 30
_ALWAYS_THOUSANDS = str.maketrans("", "", "'\u2019\u00a0\u202f")


class MarkUse(Enum):
    """What one mark does in the numbers of one column."""

    NONE = "is not there"
    DECIMALS = "parts decimals"
    THOUSANDS = "parts thousands"
    #: groups of three behind each, and no number without it
    EITHER = "may part either"


@dataclass(frozen=True)
class ColumnMarks:
    """The use of points and of commas in one column."""

    point: MarkUse
    comma: MarkUse

    @property
    def is_plain(self) -> bool:
        """Whether the numbers are as a program reads them."""
        return self.comma is MarkUse.NONE and self.point in (MarkUse.NONE, MarkUse.DECIMALS)


def plain(cell: str) -> str:
    """A number's text without what has one meaning only: another minus, another exponent, spaces of thousands."""
    return cell.strip().translate(_ALWAYS_THOUSANDS).replace("\u2212", "-").replace("D", "E").replace("d", "e")


def without_marks(cell: str, marks: ColumnMarks) -> str:
    """A number's text as a program reads it; empty for one whose marks part no groups of three."""
    for mark, decimals, use in ((".", ",", marks.point), (",", ".", marks.comma)):
        if use is MarkUse.THOUSANDS and mark in cell:
            whole, _, rest = cell.partition(decimals)
            if not re.fullmatch(rf"[+-]?[1-9]\d{{0,2}}(?:{re.escape(mark)}\d{{3}})+", whole) or mark in rest:
                return ""
            cell = cell.replace(mark, "")
    return cell.replace(",", ".") if marks.comma is MarkUse.DECIMALS else cell


def marks_of(columns: Sequence[Sequence[str]]) -> list[ColumnMarks]:
    """Of each column of numbers, with what the others of its file tell where it does not tell itself."""
    alone = [ColumnMarks(_use(cells, "."), _use(cells, ",")) for cells in columns]
    told = {
        (mark, use): any(getattr(one, mark) is use for one in alone)
        for mark in ("point", "comma")
        for use in (MarkUse.DECIMALS, MarkUse.THOUSANDS)
    }
    return [ColumnMarks(_settled(one.point, "point", told), _settled(one.comma, "comma", told)) for one in alone]


def _settled(use: MarkUse, mark: str, told: Mapping[tuple[str, MarkUse], bool]) -> MarkUse:
    if use is not MarkUse.EITHER:
        return use
    other = "comma" if mark == "point" else "point"
    decimals = told[mark, MarkUse.DECIMALS] or told[other, MarkUse.THOUSANDS]
    thousands = told[mark, MarkUse.THOUSANDS] or told[other, MarkUse.DECIMALS]
    if decimals == thousands:
        # programs write points, so a lone one is that; a comma may be either
        return MarkUse.DECIMALS if mark == "point" and not decimals else MarkUse.EITHER
    return MarkUse.DECIMALS if decimals else MarkUse.THOUSANDS


def _use(cells: Sequence[str], mark: str) -> MarkUse:
    marked = [cell for cell in cells if mark in cell]
    if not marked:
        return MarkUse.NONE
    other = "," if mark == "." else "."
    if any(cell.count(mark) > 1 for cell in marked):
        return MarkUse.THOUSANDS
    both = [cell for cell in marked if other in cell]
    if both:
        return MarkUse.DECIMALS if all(c.rindex(mark) > c.rindex(other) for c in both) else MarkUse.THOUSANDS
    group = re.compile(rf"[+-]?[1-9]\d{{0,2}}{re.escape(mark)}\d{{3}}")
    if not all(map(group.fullmatch, marked)):
        return MarkUse.DECIMALS
    below = list(_below_a_thousand(cells, mark))
    if below and all(below) and len(set(marked)) >= _HABIT:
        return MarkUse.THOUSANDS
    return MarkUse.EITHER


def _below_a_thousand(cells: Sequence[str], mark: str) -> Iterator[bool]:
    """Of each number without the mark, whether it needs none: it is whole and has three digits at most."""
    for cell in cells:
        if cell and mark not in cell:
            yield re.fullmatch(r"[+-]?\d{1,3}", cell) is not None
