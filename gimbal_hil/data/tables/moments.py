"""Dates, times of day and spans of time as seconds from the first of them."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from gimbal_hil.data.tables.raw import EMPTY_WORDS, Floats

_CLOCK = r"(?P<h>\d{1,2}):(?P<m>\d{2})(?::(?P<s>\d{2}(?:[.,]\d+)?))?"
_ZONE = r"\s*(?:Z|UTC|[+-]\d{2}:?\d{2})?"
_YEAR_FIRST = re.compile(rf"(?P<y>\d{{4}})[-/.](?P<mo>\d{{1,2}})[-/.](?P<d>\d{{1,2}})(?:[T ]\s*{_CLOCK})?{_ZONE}")
_YEAR_LAST = re.compile(rf"(?P<d>\d{{1,2}})[./](?P<mo>\d{{1,2}})[./](?P<y>\d{{4}})(?:[T ,]\s*{_CLOCK})?{_ZONE}")
_SPAN = re.compile(rf"(?:(?P<days>-?\d+) days?,?\s*)?\+?{_CLOCK}")
_DAY_S = 86_400.0


def seconds_of(cells: Sequence[str | None]) -> Floats | None:
    """Seconds (n,) from the first cell, NaN for an empty one; None where a cell is no moment. Times of day go on past
    midnight.
    """
    first = next((cell for cell in cells if not _is_empty(cell)), None)
    if first is None:
        return None
    form = next((one for one in (_YEAR_FIRST, _YEAR_LAST, _SPAN) if one.fullmatch(first.strip())), None)
    if form is None:
        return None
    day_of_first: np.datetime64 | None = None
    found = np.full(len(cells), np.nan)
    for row, cell in enumerate(cells):
        if cell is None or _is_empty(cell):
            continue
        match = form.fullmatch(cell.strip())
        if match is None:
            return None
        part = match.groupdict()
        seconds = 3600.0 * int(part["h"] or 0) + 60.0 * int(part["m"] or 0)
        seconds += float((part["s"] or "0").replace(",", "."))
        if form is not _SPAN:
            day = _day(part)
            if day is None:
                return None
            day_of_first = day if day_of_first is None else day_of_first
            seconds += _DAY_S * float((day - day_of_first) / np.timedelta64(1, "D"))
        elif part["days"]:
            seconds += _DAY_S * int(part["days"])
        found[row] = seconds
    if form is _SPAN and "day" not in first:
        good = np.isfinite(found)
        found[good] += _DAY_S * np.concatenate(([0.0], np.cumsum(np.diff(found[good]) < -0.5 * _DAY_S)))
    return found - found[np.isfinite(found)][0]


def seconds_of_array(values: np.ndarray) -> Floats:
    """The same of numpy's dates and spans, any unit, (n,)."""
    counts = values.astype("datetime64[ns]" if values.dtype.kind == "M" else "timedelta64[ns]").astype(np.int64)
    empty = np.isnat(values)
    first = counts[~empty][0] if not empty.all() else 0
    return np.where(empty, np.nan, (counts - first) * 1e-9)


def _day(part: dict[str, str]) -> np.datetime64 | None:
    """The day; where months and days stand in the order of the other side of the ocean, the one that there is."""
    for month, day in ((part["mo"], part["d"]), (part["d"], part["mo"])):
        try:
            return np.datetime64(f"{part['y']}-{int(month):02d}-{int(day):02d}", "D")
        except ValueError:
            continue
    return None


def _is_empty(cell: str | None) -> bool:
    return cell is None or cell.strip().lower() in EMPTY_WORDS
