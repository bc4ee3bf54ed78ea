"""Positions that were read every few rows only: the log on the rows in which they were, torque as its mean between.

A bus that reads the encoder at 100 Hz beside a log at 500 Hz leaves a staircase: its rate is nothing but zeros and
jumps, and it is late by half a stair. Who put the columns on one grid afterwards leaves straight lines between the
reads: all accelerations are in a few rows, and too small.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.signals.resampling import on_grid
from gimbal_hil.data.signals.table import SignalsTable

#: so many changes that all lie on every m-th row are no chance; the longest stair that is looked for, in rows
_FEWEST_CHANGES, _LONGEST_STAIR = 50, 50
#: between two reads a line bends by less than this share of what it does at a read, in all but one row in a hundred
_STRAIGHT, _ALMOST_ALL = 0.02, 0.99


def on_refreshed_rows(table: SignalsTable) -> SignalsTable:
    """The table with the rows in which positions were read, where all axes that move have theirs every so many rows,
    the same for all, and stairs or straight lines between; a note says so. Any other table is itself.
    """
    changes = [np.flatnonzero(np.diff(table.position(axis))) + 1 for axis in table.axes]
    moving = [rows for rows in changes if len(rows) > 0]
    if not moving or min(map(len, moving)) < _FEWEST_CHANGES:
        return table
    rows = np.unique(np.concatenate(moving))
    stair = _stair(rows)
    how, first = "refreshed", int(rows[0]) % max(stair, 1)
    if stair < 2:
        moved = [axis for axis, found in zip(table.axes, changes, strict=True) if len(found)]
        lines = {_lines(table.position(axis)) for axis in moved}
        if len(lines) > 1 or (only := next(iter(lines))) is None:
            return table
        # where torque was put on the same lines, both lack the same of what is fast, and agree as they are
        if any(_lines(table.torque(axis)) is not None for axis in moved):
            return table
        how, (stair, first) = "straight between reads", only
    thinned = on_grid(table.rows(first, len(table)), stair * table.period_s)
    axes = " and ".join(f"{axis}.position" for axis, found in zip(table.axes, changes, strict=True) if len(found))
    verb = "is" if len(moving) == 1 else "are"
    note = (
        f"{axes} {verb} {how} every {stair} rows only: the log was put on those rows, {len(thinned)} of "
        f"{len(table)}, with the mean of the torque between them"
    )
    of_text = None if table.lines is None else table.lines[first : first + stair * len(thinned) : stair]
    return replace(thinned, notes=(*table.notes, note), lines=of_text, origins=table.origins)


def _lines(position: NDArray[np.float64]) -> tuple[int, int] | None:
    """Every how many rows a line between two reads ends, and the first row in which one does; None where there are no
    such lines.
    """
    bends = np.abs(np.diff(position, 2))
    if len(bends) < _FEWEST_CHANGES * 2:
        return None
    # the strongest bends are at reads, all at one place of a period
    strongest = np.sort(np.argsort(bends)[-_FEWEST_CHANGES:])
    every = int(np.gcd.reduce(np.diff(strongest)))
    if not 2 <= every <= _LONGEST_STAIR or len(bends) < _FEWEST_CHANGES * every:
        return None
    first = int(strongest[0]) % every
    at_reads = np.zeros(len(bends), dtype=np.bool_)
    at_reads[first::every] = True
    usual = float(np.median(bends[at_reads]))
    between = float(np.quantile(bends[~at_reads], _ALMOST_ALL))
    return (every, (first + 1) % every) if usual > 0.0 and between < _STRAIGHT * usual else None


def _stair(rows: NDArray[np.int64]) -> int:
    """The greatest common distance of rows; 1 where it is longer than what is looked for."""
    common = int(np.gcd.reduce(np.diff(rows)))
    return common if common <= _LONGEST_STAIR else 1
