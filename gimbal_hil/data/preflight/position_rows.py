"""Positions that no torque of the axis can have led to: single reads that are off, jumps that stay, and a motion that
stands still from one row to the next.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gimbal_hil.data.preflight.impossible import AROUND, ColumnFault, Floats, Impossible, median_around, scatter_of
from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel

#: times the acceleration of the largest torque; gravity and friction help or hold, and a model is off by a factor
_ACCELERATIONS = 5.0
#: times the log's own scatter of second differences, from their median size
_SCATTERS = 12.0
#: and times the way of a row around it: a sample that is missing or came twice is no impossible place
_WAYS = 3.0
#: encoder steps that two steps of position may differ by whatever the torque
_STEPS = 4.0
#: positions lie on a grid to this share of its step, more than this share of those that move
_ON_GRID, _ALMOST_ALL_ON_GRID = 0.02, 0.9
#: rows in a row that are a spike and no motion
_LONGEST_SPIKE = 5
#: both steps of a spike together are less than this share of one
_CANCELS = 0.3
#: a position that is the same to the last digit for so many rows stands still; the share of the torques around it below
#: which the largest of them is taken
_STILL_ROWS, _ALMOST_ALL = 10, 0.98


def impossible_positions(model: AntennaModel, table: SignalsTable, axis: str) -> Iterator[Impossible]:
    """What cannot be in the position of one axis."""
    column, position = f"{axis}.position", table.position(axis)
    if len(position) <= 4 * AROUND:
        return
    limit, step = model.number(axis, "actuator.limit"), max(model.number(axis, "encoder.step"), _grid_of(position))
    torque = np.abs(table.torque(axis))
    per_torque = table.period_s**2 / max(model.number(axis, model.own_inertia_path(axis)), 1e-12)
    strongest = limit if limit > 0.0 else float(np.quantile(torque, _ALMOST_ALL))
    yield from _stills(column, position, _ACCELERATIONS * per_torque * _largest_around(torque), step)
    yield from _places(column, position, _ACCELERATIONS * per_torque * strongest + _STEPS * step)


def _grid_of(position: Floats) -> float:
    """The step of the encoder where almost all positions lie on one: a log may be coarser than its model; else 0."""
    steps = np.abs(np.diff(position))
    steps = steps[steps > 0.0]
    # with a few reads that are off the smallest change is no step, but the usual one of a coarse encoder is
    for step in (float(np.min(steps)), float(np.median(steps))) if len(steps) else ():
        counts = steps / step
        if np.mean(np.abs(counts - np.round(counts)) < _ON_GRID) > _ALMOST_ALL_ON_GRID:
            return step
    return 0.0


def _stills(column: str, position: Floats, allowed: Floats, step: float) -> Iterator[Impossible]:
    """Where the joint stands from one row to the next, or moves off so, by more than the torques around there could do
    to it (`allowed`, (n,), change of its way in a row): a column that is held or at its rail, or a stop.
    """
    steps = np.diff(position)
    bends = _SCATTERS * scatter_of(np.diff(steps))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (steps == 0.0).astype(np.int8), [0]])))
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if last - first < _STILL_ROWS:
            continue
        before, after = steps[max(0, first - AROUND) : first], steps[last : last + AROUND]
        ways = [abs(float(np.median(side))) for side in (before, after) if len(side) == AROUND]
        limit = max(float(np.max(allowed[first : last + 1])), bends) + _STEPS * step
        if ways and max(ways) > limit:
            rows = tuple(range(first + 1, last + 1))
            way = "stops" if len(before) == AROUND and abs(float(np.median(before))) == max(ways) else "moves off"
            yield Impossible(
                column,
                rows,
                f"is the same in {last - first + 1} rows and {way} within one row, faster than the torque there allows",
                ColumnFault.STILL,
            )
            return


def _places(column: str, position: Floats, longest: float) -> Iterator[Impossible]:
    steps = np.diff(position)
    usual = median_around(steps)
    scatter = _SCATTERS * scatter_of(np.diff(steps))
    allowed = np.maximum(max(longest, scatter), _WAYS * np.abs(usual))
    off = steps - usual
    outliers = np.flatnonzero(np.abs(off) > allowed)
    spikes: list[int] = []
    k = 0
    while k < len(outliers):
        at = int(outliers[k])
        if _catches_up(steps, usual, at):
            k += 1
            continue
        # the step out or the step back may be just small enough to pass by itself
        other = _other_step(off, at)
        if other is None and at in (0, len(off) - 1):
            # a first row from before the sensor was read, a last one that was cut off or still in the making
            other = at - 1 if at == 0 else at + 1
        if other is None:
            what = f"jumps by {off[at]:.4g} in one row, which no torque of this axis can do"
            yield Impossible(column, (at + 1,), what, ColumnFault.JUMP)
            return
        spikes += range(min(at, other) + 1, max(at, other) + 1)
        k = int(np.searchsorted(outliers, max(at, other), side="right"))
    if spikes:
        yield Impossible(column, tuple(spikes), "where the joint cannot have been")


def _other_step(off: Floats, at: int) -> int | None:
    """The step that takes back the one at `at`: the next one that does, else the one before it; None for a jump that
    stays.
    """
    after = range(at + 1, min(at + _LONGEST_SPIKE, len(off) - 1) + 1)
    before = range(at - 1, max(at - _LONGEST_SPIKE, 0) - 1, -1)
    return next((j for j in (*after, *before) if abs(off[at] + off[j]) < _CANCELS * abs(off[at])), None)


def _catches_up(steps: Floats, usual: Floats, at: int) -> bool:
    """Whether a step only makes up for the rows before it, which were the same read again: with them it goes no other
    way than the rows around them.
    """
    held = at
    while held > max(0, at - _LONGEST_SPIKE) and steps[held - 1] == 0.0:
        held -= 1
    way = float(steps[at]) / (at - held + 1)
    around = usual[max(0, held - AROUND) : at + AROUND + 1] * np.sign(way)
    room = _CANCELS * abs(way)
    return held < at and float(np.min(around)) - room <= abs(way) <= float(np.max(around)) + room


def _largest_around(torque: Floats) -> Floats:
    from scipy.ndimage import maximum_filter1d

    return np.asarray(maximum_filter1d(torque, 4 * AROUND + 1, mode="nearest"))
