"""Lines whose cells carry their names, as a plotter of serial lines wants them: `t:0.002 pos:1.25 tau:0.04`."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from gimbal_hil.data.tables.layout import Layout, layout_of
from gimbal_hil.data.tables.marks import LIKE_A_NUMBER

_CELL = re.compile(
    rf"(?P<name>[^\W\d][\w.\[\]/ -]*?)\s*[:=]\s*(?P<number>{LIKE_A_NUMBER.pattern}|nan|[+-]?inf)(?:[\s,;|]+|$)",
    re.IGNORECASE,
)
#: lines in the middle of a text that are looked at, and the share of them that has to be so
_SAMPLE, _MOST = 200, 0.9


def arranged(lines: Sequence[str]) -> tuple[list[str], Layout | None]:
    """The lines of a text, with numbers alone where each cell carries its name, and their layout."""
    filled = [line for line in lines if line.strip()]
    start = max(0, (len(filled) - _SAMPLE) // 2)
    sample = filled[start : start + _SAMPLE]
    often = Counter(found[0] for line in sample if (found := _cells(line)) is not None)
    names, alike = often.most_common(1)[0] if often else ((), 0)
    if len(names) < 2 or alike < _MOST * len(sample):
        return list(lines), layout_of(lines)
    bare, rows = list(lines), []
    for k, line in enumerate(lines):
        found = _cells(line)
        if found is not None and found[0] == names:
            bare[k] = "\t".join(found[1])
            rows.append(k)
    return bare, Layout("\t", len(names), rows[0], names, labelled=True)


def _cells(line: str) -> tuple[tuple[str, ...], list[str]] | None:
    """Names and numbers of a line that is nothing else; None of another."""
    text, at = line.strip(), 0
    names, numbers = [], []
    while at < len(text):
        match = _CELL.match(text, at)
        if match is None:
            return None
        names.append(match["name"])
        numbers.append(match["number"])
        at = match.end()
    return (tuple(names), numbers) if names else None
