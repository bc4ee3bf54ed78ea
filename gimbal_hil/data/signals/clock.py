"""Times that were printed with too few digits: rows whose stamps are an even clock's, rounded, are counted instead.

Of five rows that share a stamp the first is not at that stamp, and its torque does not hold for five: a log that keeps
it loses four rows of five and makes viscous friction a quarter too large.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals.bursts import times_of_bursts
from gimbal_hil.data.signals.table import JITTER_LIMIT, TIME
from gimbal_hil.data.tables import RawColumns

#: slower logs hold nothing of what friction and joints do; a period in milliseconds looks like one
LONGEST_PERIOD_S = 0.1
#: smaller units of time, s
_SMALLER = ((1e-3, "milliseconds", "ms"), (1e-6, "microseconds", "us"), (1e-9, "nanoseconds", "ns"))
#: stamps of an even clock lie within a band of this many of its own resolutions about a straight line: one by rounding
#: or cutting, the rest by what the ends of a short log do to the line
_STRAIGHT = 1.5
#: fewer stamps than this say nothing about a clock
_FEWEST_STAMPS = 8
#: share of a digit that stamps may be off, and rows by which their roundings may be, as halves are rounded either way
_OF_A_DIGIT, _UNEVEN = 0.05, 2
#: share of the period below which stamps have no scatter, but the digits of a number of 64 bits
_NO_SCATTER = 1e-6
#: share of steps of twice the length from which on they are no lost rows
_MOST_LOST = 0.25
#: up to this share of rows that repeat a stamp are faults of single rows, and may be left out
_FEW = 0.05
#: no joint is logged so often: such times are in another unit
_FASTEST_HZ = 2e5
#: rates and periods are written with fewer digits; ends of a range belong to it, as far as an epoch has digits
_MOST_DIGITS, _SAME = 10, 1e-6


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
    if (measured := times_of_bursts(raw, rows, period_s, notes)) is not None:
        return _at(raw, rows, measured)
    if repair and len(steps) and np.all(steps > 0.0) and _rounded_steps(steps):
        counted = _counted(time_s, period_s)
        if counted is not None:
            notes.append(
                f"the stamps are those of an even clock with too few digits: times were counted from the rows, "
                f"{1.0 / counted[1]:.6g} Hz from zero"
            )
            return _at(raw, rows, counted)
    repeated = np.flatnonzero(steps == 0.0) + 1
    few = len(repeated) <= _FEW * len(time_s)
    if few or np.any(steps < 0.0) or _came_twice(raw, rows, repeated):
        return raw
    where = raw.where(int(rows[repeated[0]]), TIME)
    stamps = len(time_s) - len(repeated)
    counted = _counted(time_s, period_s)
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
        unit = f"the unit of these times, as in --column {TIME}=COLUMN:UNIT (they are read as seconds)"
        counts = f"stamps with more digits; --rate {rate:.6g} counts the rows and leaves none out"
        raise BadInputError(
            where,
            f"repeats the stamp of the row before: {len(time_s)} rows have {stamps} stamps, an even clock of about "
            f"{rate:.6g} Hz with too few digits",
            counts if rate < _FASTEST_HZ else unit,
        )
    shared = "one stamp" if stamps == 1 else f"{stamps} stamps"
    notes.append(
        f"{len(time_s)} rows share {shared}, of too few digits: times were counted from the rows, "
        f"{rate:.6g} Hz from zero, and none was left out"
    )
    return _at(raw, rows, counted)


def smaller_unit(period_s: float) -> tuple[str, str] | None:
    """The unit of time, in words and short, in which rows that are too far apart for a log in seconds are near enough;
    None for those that are.
    """
    if period_s <= LONGEST_PERIOD_S:
        return None
    return next((unit[1:] for unit in _SMALLER if unit[0] * period_s <= LONGEST_PERIOD_S), _SMALLER[-1][1:])


def evened(time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Times of a constant rate without the scatter of their stamps, or what their digits leave of it (numbers of 32
    bits, 600 Hz in microseconds); those that leave a straight line by more are themselves, and so are those that do
    not leave it.
    """
    even = np.linspace(time_s[0], time_s[-1], len(time_s))
    period = float(time_s[-1] - time_s[0]) / (len(time_s) - 1)
    scatter = float(np.max(np.abs(time_s - even))) / period
    return even if _NO_SCATTER < scatter <= JITTER_LIMIT else time_s


def _rounded_steps(steps: NDArray[np.float64]) -> bool:
    """Whether steps of time, none of them zero, are those that rounding makes of even ones: of two lengths, a digit
    apart, the rarer one coming every so many rows. A row that was lost comes when it does.
    """
    digit = float(np.ptp(steps))
    if digit <= JITTER_LIMIT * float(np.median(steps)):
        return False
    counts = np.round(steps / digit)
    if np.any(np.abs(steps / digit - counts) > _OF_A_DIGIT) or counts.min() < 1.0:
        return False
    short, long = (np.flatnonzero(counts == length) for length in (counts.min(), counts.max()))
    if counts.min() == 1.0 and len(long) < _MOST_LOST * len(counts):
        # as many rows are lost by a logger that stops to write, and as evenly
        return False
    rare = min(short, long, key=len)
    return len(rare) >= _FEWEST_STAMPS and int(np.ptp(np.diff(rare))) <= _UNEVEN


def _came_twice(raw: RawColumns, rows: NDArray[np.int64], repeated: NDArray[np.int64]) -> bool:
    """Whether rows that repeat a stamp repeat every other number too: then they hold nothing new."""
    before, after = rows[repeated - 1], rows[repeated]
    return all(np.array_equal(column[before], column[after], equal_nan=True) for column in raw.values.values())


def _counted(time_s: NDArray[np.float64], stated_s: float | None) -> NDArray[np.float64] | None:
    """Even times from zero, (n,), of which these are the rounded ones; None where they are not. Of the periods that
    these stamps allow it is the stated one, else the one that was set most likely.
    """
    stamps = np.unique(time_s)
    if len(stamps) < _FEWEST_STAMPS:
        return None
    places = np.arange(len(time_s), dtype=np.float64)
    resolutions = _resolutions(time_s, stamps)
    slope, start = np.polyfit(places, time_s - time_s[0], 1, w=1.0 / resolutions)
    off = time_s - time_s[0] - (start + slope * places)
    if float(np.ptp(off / resolutions)) > _STRAIGHT or slope <= 0.0:
        return None
    # a stamp changes within one row, so that between two changes the period is known to a row over all between, and to
    # what rounding does at either of them
    first, last = np.flatnonzero(np.diff(time_s) > 0.0)[[0, -1]] + 1
    spanned, between = float(time_s[last] - time_s[first]), int(last - first)
    resolution, unlike = float(resolutions[last]), 0.5 * float(resolutions[last] - resolutions[first])
    low, high = (spanned - unlike) / (between + 1), (spanned + unlike) / (between - 1)
    if len(stamps) == len(time_s):
        # no row is where a stamp changes: both ends are known to the resolution
        low, high = (spanned - resolution) / between, (spanned + resolution) / between
    if stated_s is not None and low <= stated_s <= high:
        slope = stated_s
    else:
        # a whole number of rows to a stamp, if only one will do, or a rate or a period that is written short
        least, most = np.ceil(resolution / high), np.floor(resolution / low)
        slope = resolution / most if least == most > 0 else _roundest(low, high)
    return np.asarray(slope * places)


def _resolutions(time_s: NDArray[np.float64], stamps: NDArray[np.float64]) -> NDArray[np.float64]:
    """What stamps differ by at each row, (n,). Times of so many digits have one less behind the point from each power
    of ten on; where few stamps have that many, it is as with one more.
    """
    steps = np.diff(stamps)
    if len(stamps) == len(time_s):
        # of stamps that all differ it is what their steps differ by
        return np.full(len(time_s), float(np.ptp(steps)))
    powers = np.floor(np.log10(np.maximum(np.abs(stamps[1:]), 1e-9)))
    known, by_power = float(np.median(steps)), {}
    for power in np.unique(powers)[::-1]:
        own = steps[powers == power]
        known = by_power[power] = float(np.median(own)) if len(own) >= _FEWEST_STAMPS else known
    found, starts = np.empty(len(time_s)), np.searchsorted(time_s, stamps[1:])
    for power, resolution in sorted(by_power.items(), key=lambda one: starts[powers == one[0]].min()):
        found[starts[powers == power].min() if power != powers[0] else 0 :] = resolution
    return found


def _roundest(low_s: float, high_s: float) -> float:
    """The period between two that is written with the fewest digits, as a rate or as itself."""
    for digits in range(1, _MOST_DIGITS):
        for middle, turned in ((0.5 / low_s + 0.5 / high_s, True), (0.5 * (low_s + high_s), False)):
            short = float(f"{middle:.{digits}g}")
            period = 1.0 / short if turned else short
            if low_s * (1.0 - _SAME) <= period <= high_s * (1.0 + _SAME):
                return period
    return 0.5 * (low_s + high_s)


def _at(raw: RawColumns, rows: NDArray[np.int64], counted: NDArray[np.float64]) -> RawColumns:
    times = raw.values[TIME].copy()
    times[rows] = counted
    return replace(raw, values={**raw.values, TIME: times})
