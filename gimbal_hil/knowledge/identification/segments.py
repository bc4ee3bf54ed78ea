"""Cuts a run or a table into stretches that identification can use, by how the axis was controlled in them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np

from gimbal_hil.data.runs import AXES, EventKind, RecordedRun, columns_of
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.loop.control import Mode

#: without references, a change of block speed by this share of the larger one starts a new stretch
_SPEED_CHANGE = 0.2
_BLOCK_S = 0.25
#: a reference belongs to a level while it is within this share of it: one that was logged with noise, or resampled, is
#: no other speed
_LEVEL_SHARE, _LEVEL_LEAST = 0.01, 1e-9
#: a reference of which less than this share of the time belongs to levels that last so long, s, says nothing about
#: levels: it moves all the time, or was logged with noise
_OF_LEVELS, _LEVEL_S = 0.5, 0.5


class TorqueSource(Enum):
    """Who set the torque in a stretch."""

    #: torque was commanded directly
    TORQUE = "torque"
    #: a loop followed a reference, or nobody knows
    LOOP = "loop"
    #: the axis was off
    OFF = "off"


@dataclass(frozen=True)
class Stretch:
    """Rows `start` (first) to `stop` (one past the last) of a table, with the axis driven one way throughout."""

    label: str
    start: int
    stop: int
    drive: TorqueSource


def stretches_of_run(run: RecordedRun, table: SignalsTable, axis: str) -> tuple[Stretch, ...]:
    """Stretches of a recorded run: one a step of its plan, cut further where the mode of the axis changes.

    Steps begin where the log has a `segment` event, whose text is their name, or where the tick log's segment label
    changes.
    """
    ticks = run.ticks
    first = int(columns_of(run.frames, "drive_status", run.protocol).tick[0])
    named = {event.tick: event.text for event in run.events if event.kind is EventKind.SEGMENT}
    begun = np.isin(ticks["tick"][1:], np.array(list(named), dtype=np.int64))
    mode = ticks[f"mode_{AXES[run.record.header.axes.index(axis)]}"]
    change = np.flatnonzero(begun | (np.diff(ticks["segment"]) != 0) | (np.diff(mode) != 0)) + 1
    edges = np.concatenate([[0], change, [len(ticks)]])
    stretches, name = [], ""
    for start, stop in pairwise(edges.tolist()):
        name = named.get(int(ticks["tick"][start]), name or f"segment {int(ticks['segment'][start])}")
        low = int(np.clip(ticks["tick"][start] - first, 0, len(table)))
        high = int(np.clip(ticks["tick"][stop] - first, 0, len(table))) if stop < len(ticks) else len(table)
        if high > low:
            drive = _DRIVES.get(int(mode[start]), TorqueSource.LOOP)
            stretches.append(Stretch(f"{name} ({table.time_s[low]:.1f} s)", low, high, drive))
    return tuple(stretches)


_DRIVES = {int(Mode.OFF): TorqueSource.OFF, int(Mode.TORQUE): TorqueSource.TORQUE}


def stretches_of_table(table: SignalsTable, axis: str) -> tuple[Stretch, ...]:
    """Stretches of a bare table: where a rate reference holds levels, those; else pieces of even measured speed."""
    reference = table.signal(axis, "rate_ref")
    edges = None if reference is None else _level_edges(reference)
    if edges is None or not _holds_levels(edges, table.period_s):
        edges = _speed_edges(table.position(axis), table.period_s)
    found = []
    for start, stop in pairwise(edges):
        if stop - start > 1:
            found.append(Stretch(f"{axis} from {table.time_s[start]:.2f} s", int(start), int(stop), TorqueSource.LOOP))
    return tuple(found)


def _holds_levels(edges: np.ndarray, period_s: float) -> bool:
    """Whether pieces between edges that last are most of the time."""
    lengths = np.diff(edges)
    lasting = lengths[lengths * period_s >= _LEVEL_S]
    return bool(np.sum(lasting) >= _OF_LEVELS * np.sum(lengths))


def _level_edges(reference: Vector) -> np.ndarray:
    """Rows at which a reference leaves the level that it had in the first row of its piece, and both ends."""
    edges, level = [0], float(reference[0])
    allowed = _LEVEL_SHARE * abs(level) + _LEVEL_LEAST
    for row, value in enumerate(reference.tolist()):
        if abs(value - level) > allowed:
            edges.append(row)
            level, allowed = value, _LEVEL_SHARE * abs(value) + _LEVEL_LEAST
    return np.array([*edges, len(reference)])


def _speed_edges(position: Vector, period_s: float) -> np.ndarray:
    length = max(2, int(round(_BLOCK_S / period_s)))
    edges = np.arange(0, len(position), length)
    if len(edges) < 3:
        return np.array([0, len(position)])
    speeds = np.diff(position[edges])
    scale = np.maximum(np.abs(speeds[1:]), np.abs(speeds[:-1]))
    moving = scale > 0.0
    change = np.zeros(len(speeds) - 1, dtype=bool)
    change[moving] = np.abs(np.diff(speeds))[moving] > _SPEED_CHANGE * scale[moving]
    return np.unique(np.concatenate([[0], edges[1:-1][change], [len(position)]]))
