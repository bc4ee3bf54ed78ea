"""Rows of a run in real time for which no answer came: a few short ones are bridged, and the table says so.

A bus that is late, or a machine that stands still for a moment, leaves ticks without feedback. They are no damage, and
every run through real drives has some. What the host sent is known for them, what it measured is not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: share of rows without an answer, and rows in a row, up to which they are bridged; a longer gap parts the run. What a
#: gap does to a curve is a matter of its length: with 28 % of the rows bridged a ripple of 100 mN m was 100.1 (0250)
MOST_MISSED, LONGEST_GAP = 0.25, 10
#: of a run that is parted, the share that its longest part has to have
_LEAST_PART = 0.25
#: share of the period by which a question may be late, against the usual, for its answer to count as that of its tick
_LATE_SHARE = 0.25


def asked_late_rows(ticks: NDArray[np.void], row_tick: NDArray[np.int64], period_ns: int) -> NDArray[np.bool_]:
    """Rows (n,) whose drives were asked late by a host that woke or computed too long: what they answered is the motion
    of later. `ticks` are the host's rows, `row_tick` (n,) the host's tick at which each row begins.
    """
    if not len(ticks):
        return np.zeros(len(row_tick), bool)
    sent_ns = ticks["wake_latency_ns"] + ticks["computing_ns"]
    late = sent_ns - np.median(sent_ns) > _LATE_SHARE * period_ns
    return np.isin(row_tick, ticks["tick"][late])


@dataclass(frozen=True)
class Bridged:
    """Rows `start` to `stop` of a run, their columns (n,) without a gap, and what was done about gaps in words."""

    start: int
    stop: int
    columns: Mapping[str, Floats]
    notes: tuple[str, ...]


def bridged(columns: Mapping[str, Floats], sent: Mapping[str, Floats], period_s: float) -> Bridged:
    """The longest part of a run without a long gap, its short ones bridged: what is sampled by cubic splines, torques
    by those that the host `sent` (columns of the same names), references by the last one.

    Runs with more gaps than a good link and machine leave are answered as they are; whoever checks them refuses them.
    """
    whole = Bridged(0, len(next(iter(columns.values()))), columns, ())
    positions = [values for name, values in columns.items() if name.endswith(".position")]
    # what acted in the first row of a log may have been sent before it
    untold = [np.isnan(columns[name]) & np.isnan(torque) for name, torque in sent.items() if name in columns]
    missed = np.any([*(np.isnan(values) for values in positions), *untold], axis=0)
    start, stop, longest = _longest_part(missed)
    missed = missed[start:stop]
    if stop - start < _LEAST_PART * whole.stop or np.count_nonzero(missed) > MOST_MISSED * len(missed):
        return whole
    part = {name: values[start:stop] for name, values in columns.items()}
    filled = {name: _filled(name, values, sent, start) for name, values in part.items()}
    notes = []
    if longest > LONGEST_GAP:
        notes.append(
            f"no answer for {longest * period_s:.3g} s: the table is the longest part without such a gap, "
            f"{start * period_s:.3g} to {stop * period_s:.3g} s"
        )
    if missed.any():
        notes.append(
            f"{np.count_nonzero(missed)} of {len(missed)} rows had no answer in time: their positions were bridged, "
            "and their torques are those that were sent"
        )
    return Bridged(start, stop, filled, tuple(notes))


def _longest_part(missed: NDArray[np.bool_]) -> tuple[int, int, int]:
    """Begin and end of the longest part of the rows without a long gap, answered rows at both ends, and how many rows
    the longest gap has.
    """
    answered = np.flatnonzero(~missed)
    if len(answered) < 2:
        return 0, 0, len(missed)
    gaps = np.diff(answered) - 1
    edges = np.concatenate(([-1], np.flatnonzero(gaps > LONGEST_GAP), [len(answered) - 1]))
    best = int(np.argmax(answered[edges[1:]] - answered[edges[:-1] + 1]))
    return int(answered[edges[best] + 1]), int(answered[edges[best + 1]]) + 1, int(gaps.max())


def _filled(name: str, values: Floats, sent: Mapping[str, Floats], start: int) -> Floats:
    missing = np.isnan(values)
    if not missing.any() or missing.all():
        return values
    if name in sent:
        return np.where(missing, sent[name][start : start + len(values)], values)
    rows = np.arange(len(values))
    known = rows[~missing]
    if name.endswith("_ref"):
        return values[known[np.maximum(np.searchsorted(known, rows, side="right") - 1, 0)]]
    from scipy.interpolate import CubicSpline

    # smooth in its second derivative, because a kink in a position is a torque
    return np.where(missing, CubicSpline(known, values[known])(np.clip(rows, known[0], known[-1])), values)
