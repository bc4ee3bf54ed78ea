"""Rows of uneven time put on an even grid, each signal by what its samples mean."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.signals.table import BASE_ANGLES, HELD_SIGNALS, REPEAT, TIME
from gimbal_hil.signals.table_file import RawColumns

Floats = NDArray[np.float64]


def resample_rows(
    raw: RawColumns, rows: NDArray[np.int64], names: Sequence[str], notes: list[str], gap_periods: float
) -> tuple[Floats, dict[str, Floats], Floats | None]:
    """Time, columns and laps on a grid of the median period over the rows between the first and last numbers of all columns.

    Commanded values hold from one sample to the next, so a grid value is their mean over its period (the impulse is kept); sampled
    values are interpolated linearly; a lap number is that of the nearest sample. Cells without a number are bridged column by column.
    Raises BadInputError when nothing is left. The times of `rows` must increase.
    """
    period = float(np.median(np.diff(raw.values[TIME][rows])))
    known = [rows[~np.isnan(raw.values[name][rows])] for name in names]
    rows = rows[(rows >= max(some[0] for some in known)) & (rows <= min(some[-1] for some in known))]
    if len(rows) < 2:
        raise BadInputError(str(raw.path), "has no stretch in which all columns hold numbers", "columns that overlap in time")
    time_s = raw.values[TIME][rows]
    count = int(np.floor((time_s[-1] - time_s[0]) / period + 1e-6)) + 1
    grid = time_s[0] + period * np.arange(count)
    columns: dict[str, Floats] = {}
    laps = None
    for name in names:
        if name == TIME:
            continue
        numbers = rows[~np.isnan(raw.values[name][rows])]
        at, values = raw.values[TIME][numbers], raw.values[name][numbers]
        if name == REPEAT:
            laps = np.round(values[_nearest(at, grid)])
        elif name.rpartition(".")[2] in HELD_SIGNALS:
            columns[name] = mean_of_held(at, values, grid, period)
        else:
            columns[name] = np.interp(grid, at, np.unwrap(values) if name in BASE_ANGLES else values)
    before = np.searchsorted(time_s, grid + 1e-6 * period, side="right") - 1
    after = np.minimum(before + 1, len(time_s) - 1)
    made_up = np.count_nonzero((time_s[after] - time_s[before] > gap_periods * period) & (grid - time_s[before] > 0.5 * period))
    bridged = f", {made_up} of them bridge gaps and were not measured" if made_up else ""
    notes.append(f"resampled to {count} rows at {period:.9g} s{bridged}")
    return grid, columns, laps


def mean_of_held(at: Floats, values: Floats, grid: Floats, period: float) -> Floats:
    """Mean over [g, g + period) of a value that holds from each sample to the next, shape of `grid`; the last holds on."""
    at = np.concatenate(([min(at[0], grid[0])], at[1:]))
    edges = np.append(at, grid[-1] + 2 * period)
    integral = np.concatenate(([0.0], np.cumsum(values * np.diff(edges))))
    means: Floats = (np.interp(grid + period, edges, integral) - np.interp(grid, edges, integral)) / period
    exact = np.searchsorted(at, grid + 1e-6 * period, side="right") - 1
    covered = np.append(at, np.inf)[exact + 1] >= grid + period * (1 - 1e-6)
    return np.where(covered & (exact >= 0), values[np.maximum(exact, 0)], means)


def _nearest(at: Floats, grid: Floats) -> NDArray[np.int64]:
    return np.searchsorted((at[1:] + at[:-1]) / 2, grid)
