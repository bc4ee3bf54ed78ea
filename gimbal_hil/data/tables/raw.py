"""A file as it stands: named columns of numbers, and every cell that is none by row and text."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError

Floats = NDArray[np.float64]
#: counts as large as nanoseconds since 1970 are read; what comes of them is checked in SI units
_LARGEST_COUNT = 1e20
#: columns that a message lists, and characters of each name
_MOST_NAMES, _LONGEST_NAME = 24, 48
#: words for a value that is not there
EMPTY_WORDS = frozenset(("", "nan", "na", "n/a", "null", "none", "nat", "<na>"))


#: what is said of a file whose encoding was guessed, and what to do where the guess is wrong
GUESSED = "was read as cp1252"
IN_UTF_8 = "the file in UTF-8: iconv -f ENCODING -t UTF-8 FILE > NEW, with GB18030, SHIFT_JIS or whatever wrote it"


@dataclass(frozen=True)
class FileColumn:
    """The column of a file that another one was read from: its name there, the unit that was said for it, and the size
    of one of its numbers in the SI unit.
    """

    name: str
    unit: str = ""
    size: float = 1.0


@dataclass(frozen=True)
class OddLine:
    """A line among the rows that is no row: its number in the file, the cells that a row has, its own, its text."""

    line: int
    wanted: int
    cells: int
    text: str


@dataclass(frozen=True)
class RawColumns:
    """A file as it is: `values` (n,) by column name with NaN where there is no finite number, `texts` what stood there
    instead.

    `lines` (n,) are the rows' numbers in a file of text; without them rows are counted from `first_row`. `odd` lists
    lines that are no rows (left out).
    """

    path: Path
    values: Mapping[str, Floats]
    texts: Mapping[str, Mapping[int, str]]
    first_row: int = 0
    odd: tuple[OddLine, ...] = ()
    lines: NDArray[np.int64] | None = None
    #: what the file calls columns that were given another name, by that name
    called: Mapping[str, str] = field(default_factory=dict)
    #: the one column of the file that each was read from
    origins: Mapping[str, FileColumn] = field(default_factory=dict)
    #: units that the file states, by column
    units: Mapping[str, str] = field(default_factory=dict)
    #: names that cannot be read as they are -> what is wrong with them, and what to do
    doubts: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    #: what a reader of results should know of how the file was read
    notes: tuple[str, ...] = ()
    #: by how much columns belong later than their rows, s, where that was stated
    shifts_s: Mapping[str, float] = field(default_factory=dict)

    def where(self, row: int, column: str) -> str:
        """Names file, row and column of a cell."""
        place = f"row {row + self.first_row}" if self.lines is None else f"line {self.lines[row]}"
        return f"{self.path}: {place}, column {self.called.get(column, column)}"

    @property
    def doubt_of_encoding(self) -> str:
        """What to do about names that are not what they should be, where the encoding was guessed; else nothing."""
        return f"; if these names look wrong, {IN_UTF_8}" if any(GUESSED in note for note in self.notes) else ""

    def require_certain(self, name: str) -> None:
        """BadInputError for a name that cannot be read as it is."""
        if name in self.doubts:
            raise BadInputError(str(self.path), *self.doubts[name])


def listed(names: Sequence[str]) -> str:
    """Names for a message: no more, and no longer ones, than a person reads."""
    short = [name if len(name) <= _LONGEST_NAME else f"{name[:_LONGEST_NAME]}..." for name in names[:_MOST_NAMES]]
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return ", ".join(short) + more


def told_apart(names: Sequence[str]) -> tuple[list[str], dict[str, tuple[str, str]]]:
    """Names of columns as they can be asked for, and doubts: one that comes twice is NAME#1 and NAME#2, one that is
    blank is the number of its column.
    """
    often = {name: count for name, count in Counter(names).items() if count > 1 and name}
    seen: Counter[str] = Counter()
    found = []
    for place, name in enumerate(names, 1):
        seen[name] += 1
        found.append(f"{name}#{seen[name]}" if name in often else name or str(place))
    doubts = {
        name: (f"has {'two' if count == 2 else count} columns named {name!r}", f"{name}#1 or {name}#2, one of them")
        for name, count in often.items()
    }
    return found, doubts


def cleaned(values: Floats) -> tuple[Floats, dict[int, str]]:
    """The values with NaN for what nobody measures, and what stood there: infinite, or larger than any count."""
    beyond = np.isinf(values) | (np.isfinite(values) & (np.abs(values) > _LARGEST_COUNT))
    texts = {int(row): f"{values[row]:g}" for row in np.flatnonzero(beyond)}
    return np.where(beyond, math.nan, values), texts
