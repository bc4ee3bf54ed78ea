"""Rows of uneven time, or of another rate, put on an even grid, each signal by what its samples mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals.table import BASE_ANGLES, HELD_SIGNALS, REPEAT, TIME, SignalsTable
from gimbal_hil.data.tables import RawColumns

#: a longer step of time, in periods of the data, has samples missing
GAP_PERIODS = 1.5
#: a grid that is more times finer than the data holds almost nothing that was measured
_FINEST = 10.0
#: a step so long is no late row, but one that is missing
_MISSING_PERIODS = 1.75
#: up to so many rows in a row that are missing are bridged; a longer gap parts the log
LONGEST_BRIDGED = 20
#: of the steps of time all but this share are no gaps, in a log whose rows come in bursts too
_ALMOST_ALL = 0.99
#: references are levels that a loop was told: the one in force is taken, since a mean of two levels was never asked for
_LEVELS = ("position_ref", "rate_ref")
_TORQUES = ("torque", "current")

Floats = NDArray[np.float64]


def resample_rows(
    raw: RawColumns, rows: NDArray[np.int64], names: Sequence[str], notes: list[str], period_s: float | None = None
) -> tuple[Floats, dict[str, Floats], Floats | None]:
    """Time, columns and laps on a grid of `period_s` (the data's median period without one) over the rows that all
    columns share.

    Commanded torque holds from one sample to the next, so a grid value is its mean over the period (the impulse is
    kept); over rows that are missing it goes straight from the last to the next. Of a reference it is the level in
    force. Sampled values are interpolated by monotone cubics (PCHIP): a position that stands on one count stays on it
    and none leaves the range of its neighbours, while a smooth motion is followed to third order. A lap number is that
    of the nearest sample. Cells without a number are bridged column by column.

    Raises BadInputError when nothing is left, or for a grid far finer than the data. The times of `rows` must increase.
    """
    own = float(np.median(np.diff(raw.values[TIME][rows])))
    period = period_s or own
    if own > _FINEST * period:
        raise BadInputError(
            f"--rate {1.0 / period:.6g}",
            f"is {own / period:.4g} times finer than {raw.path}, whose rows lie {own:.4g} s apart by its column {TIME}",
            f"at most {_FINEST:g} times its rate, or the unit of its time, as in --column {TIME}=COLUMN:ms",
        )
    known = [rows[~np.isnan(raw.values[name][rows])] for name in names]
    if any(len(some) < 2 for some in known):
        raise BadInputError(
            str(raw.path), "has a column with fewer than two numbers", "numbers in every column, or no such column"
        )
    rows = rows[(rows >= max(some[0] for some in known)) & (rows <= min(some[-1] for some in known))]
    if len(rows) < 2:
        raise BadInputError(
            str(raw.path), "has no stretch in which all columns hold numbers", "columns that overlap in time"
        )
    time_s = raw.values[TIME][rows]
    count = int(np.floor((time_s[-1] - time_s[0]) / period + 1e-6)) + 1
    if count < 2:
        raise BadInputError(
            str(raw.path), f"lasts {time_s[-1] - time_s[0]:.4g} s", f"at least two periods of {period:.6g} s"
        )
    grid = time_s[0] + period * np.arange(count)
    columns: dict[str, Floats] = {}
    laps = None
    for name in names:
        if name == TIME:
            continue
        numbers = rows[~np.isnan(raw.values[name][rows])]
        at, values = raw.values[TIME][numbers], raw.values[name][numbers]
        if name == REPEAT:
            laps = np.round(values[np.searchsorted((at[1:] + at[:-1]) / 2, grid)])
        else:
            signal = name.rpartition(".")[2]
            if signal in _TORQUES:
                at, values = _with_missing_rows(at, values)
            values = np.unwrap(values) if name in BASE_ANGLES else values
            columns[name] = _on_grid(signal, at, values, grid, period)
    before = np.searchsorted(time_s, grid + 1e-6 * own, side="right") - 1
    after = np.minimum(before + 1, len(time_s) - 1)
    made_up = np.count_nonzero(
        (time_s[after] - time_s[before] > GAP_PERIODS * own) & (grid - time_s[before] > 0.5 * own)
    )
    bridged = f", {made_up} of them bridge gaps and were not measured" if made_up else ""
    notes.append(f"resampled to {count} rows at {period:.9g} s{bridged}")
    return grid, columns, laps


def parted_rows(time_s: Floats) -> NDArray[np.int64]:
    """Places in increasing times (n,) where a part begins after a gap that is too long to be bridged."""
    steps = np.diff(time_s)
    usual = max(float(np.median(steps)), float(np.mean(steps[steps <= np.quantile(steps, _ALMOST_ALL)])))
    return np.flatnonzero(steps > (LONGEST_BRIDGED + GAP_PERIODS) * usual) + 1


def _with_missing_rows(at: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Times and torques with those of the rows that are missing, straight between their neighbours: the last torque
    before a short gap was not in force all over it. A torque that is sent more slowly than the rows misses none.
    """
    steps = np.diff(at) / float(np.median(np.diff(at)))
    gaps = (steps > _MISSING_PERIODS) & (steps < LONGEST_BRIDGED + GAP_PERIODS)
    missing = np.where(gaps, np.round(steps) - 1.0, 0.0).astype(np.int64)
    if not missing.any():
        return at, values
    before = np.flatnonzero(missing)
    added = [np.linspace(at[k], at[k + 1], missing[k] + 2)[1:-1] for k in before]
    times = np.sort(np.concatenate([at, *added]))
    return times, np.interp(times, at, values)


def on_grid(table: SignalsTable, period_s: float) -> SignalsTable:
    """A table of even rate with rows every `period_s` instead, by the rules of `resample_rows`; itself where they are
    so already.
    """
    if abs(table.period_s - period_s) * len(table) < 1e-3 * period_s:
        return table
    laps: Mapping[str, Floats] = {} if table.repeat is None else {REPEAT: table.repeat.astype(np.float64)}
    values = {TIME: table.time_s, **table.columns, **laps}
    raw = RawColumns(Path(table.source or "log"), values, {name: {} for name in values})
    notes: list[str] = []
    grid, columns, repeat = resample_rows(raw, np.arange(len(table)), list(values), notes, period_s)
    return SignalsTable.of(
        table.axes,
        grid,
        columns,
        None if repeat is None else repeat.astype(np.int64),
        table.source,
        (*table.notes, *notes),
    )


def shifted(name: str, time_s: Floats, values: Floats, shift_s: float) -> Floats:
    """A column (n,) of even rows whose values belong `shift_s` later than their rows, at the times of the rows; its
    ends hold on.
    """
    period = float(time_s[-1] - time_s[0]) / (len(time_s) - 1)
    return _on_grid(name.rpartition(".")[2], time_s, values, time_s - shift_s, period)


def mean_of_held(at: Floats, values: Floats, grid: Floats, period: float) -> Floats:
    """Mean over [g, g + period) of a value that holds from each sample to the next, shape of `grid`; the last holds
    on.
    """
    at = np.concatenate(([min(at[0], grid[0])], at[1:]))
    edges = np.append(at, max(at[-1], grid[-1]) + 2 * period)
    integral = np.concatenate(([0.0], np.cumsum(values * np.diff(edges))))
    means: Floats = (np.interp(grid + period, edges, integral) - np.interp(grid, edges, integral)) / period
    exact = np.searchsorted(at, grid + 1e-6 * period, side="right") - 1
    covered = np.append(at, np.inf)[exact + 1] >= grid + period * (1 - 1e-6)
    return np.where(covered & (exact >= 0), values[np.maximum(exact, 0)], means)


def _on_grid(signal: str, at: Floats, values: Floats, grid: Floats, period: float) -> Floats:
    from scipy.interpolate import PchipInterpolator

    if signal in _LEVELS:
        return np.asarray(values[np.maximum(np.searchsorted(at, grid + 1e-6 * period, side="right") - 1, 0)])
    if signal in HELD_SIGNALS:
        return mean_of_held(at, values, grid, period)
    nearest = np.searchsorted((at[1:] + at[:-1]) / 2, grid)
    between = np.asarray(PchipInterpolator(at, values)(np.clip(grid, at[0], at[-1])))
    return np.where(np.abs(at[nearest] - grid) < 1e-6 * period, values[nearest], between)
