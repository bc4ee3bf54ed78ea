"""A target's way over the sky as what the host follows: a timetable of azimuth and elevation for mode `pointing`.

The earth's axes of the host are x to true north, y to the west, z up. Along boresight x the outer joint is minus the
azimuth, the inner one minus the elevation. Along -x it is the other end of that line that is led to the target: half a
turn less the azimuth, and the elevation itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.loop.host import AxisCommand, Mode, Segment, Shape
from gimbal_hil.pointing.arena import between, boresight
from gimbal_hil.pointing.following.geodesy import Table
from gimbal_hil.pointing.following.targets import Target
from sim_backend.boresight import Boresight

#: seconds between rows, the longest first
_ROWS_S = (20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05)
#: rows are close enough when what lies between is off by less than this (rad)
_CLOSE_RAD = 1e-6
#: the table goes on for so long behind the end
_AFTER_S = 1.0
#: points between two rows at which the way is compared
_BETWEEN = 8


@dataclass(frozen=True)
class Way:
    """Joint positions (rad) from a level base that looks north, a row every `row_s` seconds; `off_rad` is how far the
    cubics between them are off at most.
    """

    row_s: float
    outer: Table
    inner: Table
    off_rad: float

    def segment(self, first_tick: int, duration_ticks: int, label: int = 0) -> Segment:
        """The way as a segment, its first row at a tick of the host, or -1 - n: n ticks before the segment begins."""
        outer, inner = (
            AxisCommand(Mode.POINTING, Shape.TIMETABLE, (self.row_s, 1.0, float(first_tick)), table=rows)
            for rows in (self.outer, self.inner)
        )
        return Segment(outer, inner, duration_ticks, label=label)


def joints_seen(target: Target, time_s: Table, boresight: Boresight = Boresight.AHEAD) -> Table:
    """Joint positions (n, 2) from a level base whose x looks north."""
    azimuth, elevation = target.directions(time_s)
    if boresight is Boresight.ASTERN:
        return np.column_stack([math.pi - azimuth, elevation])
    return np.column_stack([-azimuth, -elevation])


def way_of(target: Target, duration_s: float, boresight: Boresight = Boresight.AHEAD) -> Way:
    """The way in as few rows as it takes; where the target passes the zenith of the earth, the closest rows there
    are.
    """
    ways = (_way(target, duration_s, row_s, boresight) for row_s in _ROWS_S if row_s <= max(duration_s, _ROWS_S[-1]))
    way = next(ways)
    for closer in ways:
        if way.off_rad <= _CLOSE_RAD:
            break
        way = closer
    return way


def _way(target: Target, duration_s: float, row_s: float, looks: Boresight) -> Way:
    rows = math.ceil((duration_s + _AFTER_S) / row_s) + 2
    time_s = row_s * np.arange(rows, dtype=np.float64)
    if math.isfinite(target.lasts_s):
        time_s = np.minimum(time_s, target.lasts_s)
    joints = joints_seen(target, time_s, looks)
    fine_s = np.arange(0.0, duration_s, row_s / _BETWEEN)
    way = Way(row_s, np.ascontiguousarray(joints[:, 0]), np.ascontiguousarray(joints[:, 1]), 0.0)
    found = np.column_stack([catmull_rom(column, row_s, fine_s) for column in (way.outer, way.inner)])
    off = between(boresight(found), boresight(joints_seen(target, fine_s, looks)))
    return replace(way, off_rad=float(off.max()))


def catmull_rom(rows: Table, row_s: float, time_s: Table) -> Table:
    """What shape TIMETABLE makes of rows at times (s) within them."""
    longer = np.concatenate([[2.0 * rows[0] - rows[1]], rows, [2.0 * rows[-1] - rows[-2]]])
    place = np.clip(time_s / row_s, 0.0, len(rows) - 1 - 1e-9)
    row = place.astype(np.int64)
    x = place - row
    before, a, b, after = (longer[row + k] for k in range(4))
    m, n, d = 0.5 * (b - before), 0.5 * (after - a), b - a
    return np.asarray(a + x * (m + x * (3.0 * d - 2.0 * m - n + x * (m + n - 2.0 * d))))
