"""Rows that were stamped as they arrived, several at once: what a serial port or a network makes of an even log.

On such stamps a joint stands still for a while and then goes the whole way in an instant.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals.table import TIME
from gimbal_hil.data.tables import RawColumns

#: rows arrive in bursts where this share of the steps at most is longer than half the longest, these are of one length
#: within half of it, and the others together take this share of the time at most; so many bursts at least, mostly of so
#: many rows: two at once may be the two frames of a drive's cycle, and one after the other is a clock that changes
_MOST_FAR, _HALF, _AT_ONCE, _FEWEST, _ROWS_AT_ONCE = 0.5, 0.5, 0.1, 8, 3
#: a stated rate agrees with that of the rows to this share
_AGREES = 0.05


def times_of_bursts(
    raw: RawColumns, rows: NDArray[np.int64], period_s: float | None, notes: list[str]
) -> NDArray[np.float64] | None:
    """Even times (n,) at the stated period for rows that arrived in bursts, which a note tells; None for other rows.

    Raises BadInputError for such rows where no period is stated, or another than theirs.
    """
    found = _bursts(np.diff(raw.values[TIME][rows]))
    if found is None:
        return None
    usual_s, rows_each = found
    if period_s is None or abs(period_s - usual_s) > _AGREES * usual_s:
        raise BadInputError(
            raw.where(int(rows[1]), TIME),
            f"stamps rows as they arrived: about {rows_each:.3g} at once, and then none for "
            f"{1e3 * rows_each * usual_s:.4g} ms",
            f"times at which rows were measured, or --rate HZ with the rows a second (about {1.0 / usual_s:.4g}), "
            "which counts them and leaves these times alone",
        )
    notes.append(
        f"the stamps are those of rows that arrived about {rows_each:.3g} at once: times were counted from the rows, "
        f"{1.0 / period_s:.6g} Hz from zero"
    )
    return np.asarray(period_s * np.arange(len(rows)), np.float64)


def _bursts(steps: NDArray[np.float64]) -> tuple[float, float] | None:
    """Seconds a row and rows at once, of rows that come several at once and then not for as long as they took; None of
    others.
    """
    if len(steps) < _FEWEST or np.any(steps <= 0.0):
        return None
    places = np.flatnonzero(steps > _HALF * np.max(steps))
    far = np.sort(steps[places])
    if not _FEWEST <= len(far) <= _MOST_FAR * len(steps) or np.median(np.diff(places)) < _ROWS_AT_ONCE:
        return None
    even = far[int(0.9 * len(far))] - far[int(0.1 * len(far))] < _HALF * float(np.median(far))
    if not even or float(np.sum(steps) - np.sum(far)) > _AT_ONCE * float(np.sum(steps)):
        return None
    first, last = places[[0, -1]]
    return float(np.mean(steps[first + 1 : last + 1])), float(last - first) / (len(far) - 1)
