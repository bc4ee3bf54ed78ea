"""Checks and content hashes of log rows: which bit of a damaged row is wrong, and whether two runs are the same.

A row is mixed word by word into 64 bits (each step is a bijection of the state, so one changed word always changes the
result). After the content words the state is the row's share of the run's content hash; after all words its lower half
is the row's check.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.runs.schema import CONTENT_WORDS

_START = np.uint64(0x243F6A8885A308D3)
_MULTIPLIER = np.uint64(0x9E3779B97F4A7C15)
_HALF = np.uint64(32)
_LOWER = np.uint64(0xFFFFFFFF)


@dataclass(frozen=True)
class Damage:
    """A row whose check does not hold; `column` and `original` are None when more than one bit is wrong."""

    row: int
    tick: int
    column: str | None
    found: object
    original: object


def seal(rows: NDArray[np.void]) -> NDArray[np.uint64]:
    """Write the check of every row in place; the rows' shares of the content hash, shape (n,)."""
    content, check = _mix(rows)
    rows["check"] = check
    return content


def broken_rows(rows: NDArray[np.void]) -> NDArray[np.int64]:
    """Indices of rows whose check does not hold."""
    return np.flatnonzero(_mix(rows)[1] != rows["check"])


def explain(rows: NDArray[np.void], row: int) -> Damage:
    """The column that a single wrong bit of row `row` sits in, with the value found and the value that the check
    proves.
    """
    bits = 8 * rows.dtype.itemsize
    tries = np.repeat(rows[row : row + 1], bits)
    words = tries.view("<u8").reshape(bits, -1)
    flat = np.arange(bits)
    words[flat, flat // 64] ^= np.left_shift(np.uint64(1), (flat % 64).astype(np.uint64))
    fits = np.flatnonzero(_mix(tries)[1] == tries["check"])
    tick = int(rows["tick"][row])
    if len(fits) != 1:
        return Damage(row, tick, None, None, None)
    repaired = tries[fits[0]]
    changed = [name for name in rows.dtype.names or () if rows[row][name].tobytes() != repaired[name].tobytes()]
    column = changed[0]
    return Damage(row, int(repaired["tick"]), column, rows[row][column].item(), repaired[column].item())


def content_hash(rows: NDArray[np.void]) -> str:
    """Hash of rows without the wall clock's columns: equal for two runs of equal content."""
    return hashlib.sha256(_mix(rows)[0].tobytes()).hexdigest()


def _mix(rows: NDArray[np.void]) -> tuple[NDArray[np.uint64], NDArray[np.uint32]]:
    words = np.ascontiguousarray(rows).view("<u8").reshape(len(rows), rows.dtype.itemsize // 8)
    last = words.shape[1] - 1
    state = np.full(len(rows), _START)
    content = state
    for place in range(last + 1):
        state ^= words[:, place] if place < last else words[:, place] & _LOWER
        state *= _MULTIPLIER
        state ^= state >> _HALF
        if place + 1 == CONTENT_WORDS[rows.dtype]:
            content = state.copy()
    return content, state.astype(np.uint32)
