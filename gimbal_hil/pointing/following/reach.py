"""Whether a target can be reached: joint positions that look at it, against the joints' soft limits and the cable."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.pointing.arena import boresight
from gimbal_hil.pointing.following.base import BaseTruth, in_base
from gimbal_hil.pointing.following.geodesy import Table
from gimbal_hil.pointing.following.way import Way, catmull_rom
from sim_backend.boresight import Boresight

_TURN = 2.0 * math.pi
#: positions are looked at so often (s), and may be off by so much (rad)
_STEP_S, _ALLOWED_RAD = 0.5, 1e-3


def reach_of(settings: DaemonSettings, axis: str) -> tuple[float, float]:
    """Lowest and highest position (rad) that an axis may be led to: soft limits and cable."""
    limits = settings.axes[axis].limits
    turns = math.inf if limits.cable_wrap_turns is None else limits.cable_wrap_turns * _TURN
    low = -math.inf if limits.position_low_rad is None else limits.position_low_rad
    high = math.inf if limits.position_high_rad is None else limits.position_high_rad
    return max(low, -turns), min(high, turns)


def joints_needed(way: Way, duration_s: float, base: BaseTruth) -> tuple[Table, Table]:
    """Times (n,) from the start and joint positions (n, 2) that look along a way from a base; the outer joint without
    jumps. A base whose motion is not known counts as it is at the start.
    """
    time_s = np.linspace(0.0, duration_s, max(2, math.ceil(duration_s / _STEP_S) + 1))
    asked = np.column_stack([catmull_rom(rows, way.row_s, time_s) for rows in (way.outer, way.inner)])
    x, y, z = in_base(boresight(asked), base.at(time_s)).T
    return time_s, np.column_stack([np.unwrap(np.arctan2(y, x)), -np.arcsin(np.clip(z, -1.0, 1.0))])


def require_reach(way: Way, duration_s: float, settings: DaemonSettings, base: BaseTruth, target: str) -> None:
    """BadInputError, before anything moves, where a joint cannot look at the target all the time: which one, where it
    would have to be and when, and how far it may go.
    """
    time_s, joints = joints_needed(way, duration_s, base)
    looks = settings.pointing.boresight or Boresight.AHEAD
    outer, inner = settings.axis_names
    for axis, positions, turns in ((outer, joints[:, 0], True), (inner, joints[:, 1], False)):
        low, high = reach_of(settings, axis)
        reached = _within(positions, low, high, turns)
        if reached.all():
            continue
        first = int(np.argmin(reached))
        position = math.degrees(_nearest(float(positions[first]), low, high) if turns else float(positions[first]))
        problem = f"needs {axis} at {position:.1f} degrees after {time_s[first]:.1f} s"
        if not turns:
            problem += f" ({looks.raises} positions look up, as `boresight: {looks}` of the model says)"
        reach = f"{math.degrees(low):.1f} to {math.degrees(high):.1f} degrees"
        raise BadInputError(f"--target {target}", problem, f"{axis} within its reach of {reach} (axes.{axis}.limits)")


def _within(positions: Table, low: float, high: float, turns: bool) -> NDArray[np.bool_]:
    """Which positions lie within the limits, as they are or by whole turns."""
    laps: Sequence[int] = (0,)
    if turns and math.isfinite(low) and math.isfinite(high):
        laps = range(math.floor((low - positions.max()) / _TURN), math.ceil((high - positions.min()) / _TURN) + 1)
    turned = np.array([positions + lap * _TURN for lap in laps])
    return np.asarray(((turned >= low - _ALLOWED_RAD) & (turned <= high + _ALLOWED_RAD)).any(axis=0))


def _nearest(position: float, low: float, high: float) -> float:
    """The turn of a position nearest to the middle of its reach."""
    middle = 0.5 * (low + high)
    return position + _TURN * round((middle - position) / _TURN) if math.isfinite(middle) else position
