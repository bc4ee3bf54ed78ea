"""Positions that are refreshed every few rows only: the log on the rows in which they are, torque as its mean between.

A bus that reads the encoder at 100 Hz beside a log at 500 Hz leaves a staircase: its rate is nothing but zeros and
jumps, and it is late by half a stair.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.signals.resampling import on_grid
from gimbal_hil.data.signals.table import SignalsTable

#: so many changes that all lie on every m-th row are no chance; the longest stair that is looked for, in rows
_FEWEST_CHANGES, _LONGEST_STAIR = 50, 50


def on_refreshed_rows(table: SignalsTable) -> SignalsTable:
    """The table with the rows in which positions were refreshed, where all axes that move have theirs every so many
    rows, the same for all; a note says so. Any other table is itself.
    """
    changes = [np.flatnonzero(np.diff(table.position(axis))) + 1 for axis in table.axes]
    moving = [rows for rows in changes if len(rows) > 0]
    if not moving or min(map(len, moving)) < _FEWEST_CHANGES:
        return table
    rows = np.unique(np.concatenate(moving))
    stair = _stair(rows)
    if stair < 2:
        return table
    first = int(rows[0]) % stair
    thinned = on_grid(table.rows(first, len(table)), stair * table.period_s)
    axes = " and ".join(f"{axis}.position" for axis, found in zip(table.axes, changes, strict=True) if len(found))
    verb = "is" if len(moving) == 1 else "are"
    note = (
        f"{axes} {verb} refreshed every {stair} rows only: the log was put on those rows, {len(thinned)} of "
        f"{len(table)}, with the mean of the torque between them"
    )
    return replace(thinned, notes=(*table.notes, note))


def _stair(rows: NDArray[np.int64]) -> int:
    """The greatest common distance of rows; 1 where it is longer than what is looked for."""
    common = int(np.gcd.reduce(np.diff(rows)))
    return common if common <= _LONGEST_STAIR else 1
