"""Dates, times of day and spans of time as seconds from the first of them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from gimbal_hil.data.tables.raw import EMPTY_WORDS, Floats

_CLOCK = r"(?P<h>\d{1,2}):(?P<m>\d{2})(?::(?P<s>\d{2}(?:[.,:]\d+)?))?(?:\s*(?P<half>[AaPp])\.?\s?[Mm]\.?)?"
_ZONE = r"\s*(?:Z|UTC|(?P<east>[+-])(?P<zh>\d{2}):?(?P<zm>\d{2}))?"
_YEAR_FIRST = re.compile(rf"(?P<y>\d{{4}})[-/.](?P<mo>\d{{1,2}})[-/.](?P<d>\d{{1,2}})(?:[T ]\s*{_CLOCK})?{_ZONE}")
_YEAR_LAST = re.compile(rf"(?P<d>\d{{1,2}})[./](?P<mo>\d{{1,2}})[./](?P<y>\d{{4}})(?:[T ,]\s*{_CLOCK})?{_ZONE}")
_SPAN = re.compile(rf"(?:(?P<days>-?\d+) days?,?\s*)?\+?{_CLOCK}")
#: what spreadsheets show of a time with parts of a second
_IN_AN_HOUR = re.compile(r"(?P<m>\d{1,2}):(?P<s>\d{2}[.,]\d+)")
_HOUR_S, DAY_S = 3600.0, 86_400.0
#: clocks begin again after a day, half a day (those that say no AM or PM) or an hour; stamps fall by that, but for the
#: time between two rows
_ROUNDS_S, BETWEEN_ROWS_S = (DAY_S, 0.5 * DAY_S, _HOUR_S), 60.0


def seconds_of(cells: Sequence[str | None]) -> Floats | None:
    """Seconds (n,) from the first cell, NaN for an empty one; None where a cell is no moment. Times of a clock go on
    past the end of its day, half a day without AM and PM, or hour.
    """
    first = next((cell for cell in cells if not _is_empty(cell)), None)
    if first is None:
        return None
    form = next((one for one in (_YEAR_FIRST, _YEAR_LAST, _SPAN, _IN_AN_HOUR) if one.fullmatch(first.strip())), None)
    if form is None:
        return None
    found = np.full(len(cells), np.nan)
    dates: dict[int, tuple[str, str, str]] = {}
    for row, cell in enumerate(cells):
        if cell is None or _is_empty(cell):
            continue
        match = form.fullmatch(cell.strip())
        if match is None:
            return None
        part = match.groupdict()
        hour = _hour(part)
        if hour is None:
            return None
        seconds = (
            _HOUR_S * hour + 60.0 * int(part["m"] or 0) + float((part["s"] or "0").replace(",", ".").replace(":", "."))
        )
        if form in (_YEAR_FIRST, _YEAR_LAST):
            dates[row] = (str(part["y"]), str(part["mo"]), str(part["d"]))
            seconds -= _east(part)
        elif part.get("days"):
            seconds += DAY_S * int(part["days"])
        found[row] = seconds
    if dates:
        days = _days(dates, closest=form is _YEAR_LAST)
        if days is None:
            return None
        found[list(days)] += DAY_S * np.fromiter(days.values(), np.float64)
    elif "day" not in first:
        good = np.isfinite(found)
        found[good] += _gone_on(found[good])
    return found - found[np.isfinite(found)][0]


def _hour(part: dict[str, str | None]) -> int | None:
    """Hours since midnight; None for one that no clock with AM and PM shows."""
    hour = int(part.get("h") or 0)
    if not part.get("half"):
        return hour
    if not 1 <= hour <= 12:
        return None
    return hour % 12 + 12 * (str(part["half"]).lower() == "p")


def _east(part: dict[str, str | None]) -> float:
    """Seconds by which the clock of a zone is ahead; it changes within a log where summer time ends."""
    ahead = _HOUR_S * int(part["zh"] or 0) + 60.0 * int(part["zm"] or 0)
    return -ahead if part["east"] == "-" else ahead


def _gone_on(seconds: Floats) -> Floats:
    """What is to be added to each, (n,), so that the time goes on where a clock begins again."""
    falls = -np.diff(seconds)
    added = np.zeros(len(falls))
    for around in _ROUNDS_S:
        added[(falls <= around) & (falls > around - BETWEEN_ROWS_S)] = around
    return np.concatenate(([0.0], np.cumsum(added)))


def seconds_of_array(values: np.ndarray) -> Floats:
    """The same of numpy's dates and spans, any unit, (n,)."""
    counts = values.astype("datetime64[ns]" if values.dtype.kind == "M" else "timedelta64[ns]").astype(np.int64)
    empty = np.isnat(values)
    first = counts[~empty][0] if not empty.all() else 0
    return np.where(empty, np.nan, (counts - first) * 1e-9)


def _days(dates: Mapping[int, tuple[str, str, str]], closest: bool) -> dict[int, float] | None:
    """Days since the first one by row, of year, month and day as they are written; None where no order of them has such
    days. Months and days stand in the order of either side of the ocean, the same in all rows: where both make sense,
    the one in which the rows lie `closest`, or, of dates that begin with the year, the usual one.
    """
    best: dict[tuple[str, str, str], float] = {}
    for order in ((0, 1, 2), (0, 2, 1)):
        try:
            known = {date: _day(*(int(date[k]) for k in order)) for date in set(dates.values())}
        except ValueError:
            continue
        if not best or (closest and np.ptp(list(known.values())) < np.ptp(list(best.values()))):
            best = known
    return {row: best[date] - min(best.values()) for row, date in dates.items()} if best else None


def _day(year: int, month: int, day: int) -> float:
    """Days since 1970; ValueError for a day that there is not."""
    return float(np.datetime64(f"{year:04d}-{month:02d}-{day:02d}", "D").astype(np.int64))


def _is_empty(cell: str | None) -> bool:
    return cell is None or cell.strip().lower() in EMPTY_WORDS
