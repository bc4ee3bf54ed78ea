"""Is one log a piece of another? A hold-out that was searched in judges nothing.

Two logs are held against each other at the one offset at which most of their rows are the same. What counts is one
stretch without a gap, and in it only rows in which something changed: every log stands somewhere, and motion that is
driven again is the same row for row only where nothing is noisy.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from gimbal_hil.data.signals import SignalsTable

#: rows by which an offset is found; values that differ by less than this share of the largest are the same, as where a
#: file was written with fewer digits
_ROWS, _SAME = 8, 1e-5


def share_copied(one: SignalsTable, other: SignalsTable) -> float:
    """Share of the shorter log that the longer one holds in one piece, counted in rows in which something changes."""
    axes = [axis for axis in one.axes if axis in other.axes]
    short, long = sorted((_values(one, axes), _values(other, axes)), key=len)
    size = np.maximum(np.abs(short).max(axis=0, initial=0.0), np.abs(long).max(axis=0, initial=0.0))
    step = _SAME * np.where(size > 0.0, size, 1.0)
    short, long = short / step, long / step
    changes = _changes(short)
    offset = _offset(np.round(short), np.round(long), changes)
    if offset is None:
        return 0.0
    first, last = max(0, -offset), min(len(short), len(long) - offset)
    same = np.all(np.abs(short[first:last] - long[first + offset : last + offset]) <= 1.0, axis=1)
    so_far = np.cumsum(changes[first:last])
    at_last_break = np.maximum.accumulate(np.where(same, 0, so_far))
    return float(np.max(so_far - at_last_break, initial=0)) / max(1, int(changes.sum()))


def _values(table: SignalsTable, axes: Sequence[str]) -> NDArray[np.float64]:
    """Positions and torques of some axes, (rows, 2 axes)."""
    return np.column_stack([part(axis) for axis in axes for part in (table.position, table.torque)]).astype(float)


def _changes(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Rows that are not those before them."""
    return np.concatenate([[False], np.any(np.abs(np.diff(values, axis=0)) > 1.0, axis=1)])


def _offset(short: NDArray[np.float64], long: NDArray[np.float64], changes: NDArray[np.bool_]) -> int | None:
    """By how many rows the longer log begins earlier, as most stretches of the shorter one that it holds too say; None
    where it holds none.
    """
    if len(short) < _ROWS:
        return None
    moving = sliding_window_view(changes, _ROWS).any(axis=1)
    mine, others = _stretches(short)[moving], _stretches(long)
    known, where = np.unique(others, return_index=True)
    at = np.minimum(np.searchsorted(known, mine), len(known) - 1)
    found = known[at] == mine
    if not found.any():
        return None
    offsets, votes = np.unique(where[at[found]] - np.flatnonzero(moving)[found], return_counts=True)
    return int(offsets[np.argmax(votes)])


def _stretches(values: NDArray[np.float64]) -> NDArray[np.uint64]:
    """One number for every stretch of rows, the same for the same values."""
    rows = len(values) - _ROWS + 1
    # adding zero makes one of the two zeros
    bits = np.ascontiguousarray(values + 0.0).view(np.uint64)
    weights = np.random.default_rng(0).integers(1, 2**63, (_ROWS, bits.shape[1]), dtype=np.uint64) * 2 + 1
    found = np.zeros(rows, np.uint64)
    for k, row in enumerate(weights):
        found += bits[k : k + rows] @ row
    return found
