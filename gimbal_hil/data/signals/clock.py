"""Times that were printed with too few digits: rows whose stamps are an even clock's, rounded, are counted instead.

Of five rows that share a stamp the first is not at that stamp, and its torque does not hold for five: a log that keeps
it loses four rows of five and makes viscous friction a quarter too large.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals.table import TIME
from gimbal_hil.data.tables import RawColumns

#: stamps of an even clock lie within a band of this many of its own resolutions about a straight line: one by rounding
#: or cutting, the rest by what the ends of a short log do to the line
_STRAIGHT = 1.5
#: fewer stamps than this say nothing about a clock
_FEWEST_STAMPS = 8
#: up to this share of rows that repeat a stamp are faults of single rows, and may be left out
_FEW = 0.05


def with_counted_times(
    raw: RawColumns, rows: NDArray[np.int64], repair: bool, period_s: float | None, notes: list[str]
) -> RawColumns:
    """The file with times counted from row to row where its stamps are an even clock's with too few digits.

    Where they have so few that they say nothing of a clock, rows are counted at the stated `period_s`, if any. Only
    where `repair` allows it; else BadInputError says what the stamps are and which option reads them. Raises it
    too where so many rows share a stamp that leaving them out would leave another log.
    """
    time_s = raw.values[TIME][rows]
    steps = np.diff(time_s)
    repeated = np.flatnonzero(steps == 0.0) + 1
    few = len(repeated) <= _FEW * len(time_s)
    if few or np.any(steps < 0.0) or _came_twice(raw, rows, repeated):
        return raw
    where = raw.where(int(rows[repeated[0]]), TIME)
    stamps = len(time_s) - len(repeated)
    counted = _counted(time_s)
    if counted is None and stamps < _FEWEST_STAMPS and period_s is not None:
        counted = np.asarray(period_s * np.arange(len(time_s)), np.float64)
    if counted is None:
        one = "one stamp" if stamps == 1 else f"{stamps} stamps"
        raise BadInputError(
            where,
            f"repeats the stamp of the row before: {len(time_s)} rows share {one}",
            "a time column with more digits, or --rate HZ with the rate at which the rows were logged"
            if stamps < _FEWEST_STAMPS
            else "a time column with more digits",
        )
    rate = (len(counted) - 1) / float(counted[-1] - counted[0])
    if not repair:
        raise BadInputError(
            where,
            f"repeats the stamp of the row before: {len(time_s)} rows have {stamps} stamps, an even clock of about "
            f"{rate:.6g} Hz with too few digits",
            f"stamps with more digits; --rate {rate:.6g} counts the rows and leaves none out",
        )
    shared = "one stamp" if stamps == 1 else f"{stamps} stamps"
    notes.append(
        f"{len(time_s)} rows share {shared}, of too few digits: times were counted from the rows, "
        f"{rate:.6g} Hz from zero, and none was left out"
    )
    values: Mapping[str, NDArray[np.float64]] = {**raw.values, TIME: _in_place(raw.values[TIME], rows, counted)}
    return replace(raw, values=values)


def _came_twice(raw: RawColumns, rows: NDArray[np.int64], repeated: NDArray[np.int64]) -> bool:
    """Whether rows that repeat a stamp repeat every other number too: then they hold nothing new."""
    before, after = rows[repeated - 1], rows[repeated]
    return all(np.array_equal(column[before], column[after], equal_nan=True) for column in raw.values.values())


def _counted(time_s: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Even times from zero, (n,), of which these are the rounded ones; None where they are not."""
    stamps = np.unique(time_s)
    if len(stamps) < _FEWEST_STAMPS:
        return None
    places = np.arange(len(time_s), dtype=np.float64)
    slope, start = np.polyfit(places, time_s - time_s[0], 1)
    off = time_s - time_s[0] - (start + slope * places)
    resolution = float(np.median(np.diff(stamps)))
    if float(np.ptp(off)) > _STRAIGHT * resolution or slope <= 0.0:
        return None
    # a stamp changes within one row, so that between two changes the period is known to a row over all between
    first, last = np.flatnonzero(np.diff(time_s) > 0.0)[[0, -1]] + 1
    spanned, between = float(time_s[last] - time_s[first]), int(last - first)
    slope = spanned / between
    # and a period that prints short is the one that was set: a whole number of rows to a stamp
    whole = round(resolution / slope)
    if whole >= 1 and spanned / (between + 1) <= resolution / whole <= spanned / (between - 1):
        slope = resolution / whole
    return np.asarray(slope * places)


def _in_place(whole: NDArray[np.float64], rows: NDArray[np.int64], counted: NDArray[np.float64]) -> NDArray[np.float64]:
    times = whole.copy()
    times[rows] = counted
    return times
