"""Rows that no joint can make: positions that the actuator cannot have led to, and torques that no other row comes
near.

A read of an encoder that went wrong, a counter that wrapped behind a gear, a cell that was cut: one such row in
thousands hides what is missing, or becomes an all-clear. A step of position counts as impossible where it differs from
those around it by more than the actuator's acceleration, the log's own scatter and three times the way that the joint
goes in a row all allow.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel

Floats = NDArray[np.float64]

#: times the acceleration of the largest torque; gravity and friction help or hold, and a model is off by a factor
_ACCELERATIONS = 5.0
#: times the log's own scatter of second differences, from their median size
_SCATTERS = 12.0
#: and times the way of a row around it: a sample that is missing or came twice is no impossible place
_WAYS = 3.0
#: rows to either side whose median is what a row is held against; rows in a row that are a spike and no motion
_AROUND, _LONGEST_SPIKE = 5, 5
#: both steps of a spike together are less than this share of one
_CANCELS = 0.3
#: torque: times the actuator's limit, or where none is stated times the size that all but one row in fifty have; a loop
#: answers a step with many times what it asks for afterwards
_LIMITS, _TORQUES, _ALMOST_ALL = 1.2, 20.0, 0.98
#: share of the rows that a repair may make up
MOST_REPAIRED = 0.02
_LISTED = 3
_MEDIAN_TO_SIGMA = 1.4826


@dataclass(frozen=True)
class Impossible:
    """Rows of one column that cannot be; a jump is a row from which on everything lies elsewhere."""

    column: str
    rows: tuple[int, ...]
    what: str
    is_jump: bool = False


def questioned(model: AntennaModel, tables: Sequence[SignalsTable], repair: bool = False) -> tuple[SignalsTable, ...]:
    """The tables, with impossible rows made up from their neighbours where `repair` says so, which a note then tells.

    BadInputError names file, column, row, time and value of what cannot be.
    """
    return tuple(_questioned(model, table, repair) for table in tables)


def impossible_rows(model: AntennaModel, table: SignalsTable) -> list[Impossible]:
    """What cannot be in a table, column by column."""
    found = []
    for axis in model.axes:
        found += list(_places(f"{axis}.position", table.position(axis), _longest_step(model, table, axis)))
        torque = table.commanded(axis)
        found += list(_far_off(f"{axis}.torque", torque, model.number(axis, "actuator.limit")))
    return found


def _questioned(model: AntennaModel, table: SignalsTable, repair: bool) -> SignalsTable:
    found = impossible_rows(model, table)
    if not found:
        return table
    spikes = [one for one in found if not one.is_jump]
    rows = sum(len(one.rows) for one in spikes)
    if not repair or len(spikes) < len(found) or rows > MOST_REPAIRED * len(table):
        first = next((one for one in found if one.is_jump), found[0])
        raise BadInputError(_place(table, first), _said(table, first), _remedy(first, rows, len(table)))
    columns, notes = dict(table.columns), list(table.notes)
    for one in spikes:
        columns[one.column] = _made_up(columns[one.column], one.rows)
        notes.append(
            f"{one.column}: {len(one.rows)} of {len(table)} rows {one.what}, made up from their neighbours: "
            + ", ".join(_where(table, row) for row in one.rows[:_LISTED])
            + (" ..." if len(one.rows) > _LISTED else "")
        )
    return SignalsTable.of(table.axes, table.time_s, columns, table.repeat, table.source, notes)


def _longest_step(model: AntennaModel, table: SignalsTable, axis: str) -> float:
    """By how much two steps in a row may differ: what the largest torque makes of the inertia."""
    limit = model.number(axis, "actuator.limit")
    torque = limit if limit > 0.0 else float(np.quantile(np.abs(table.torque(axis)), _ALMOST_ALL))
    inertia = model.number(axis, model.own_inertia_path(axis))
    step = model.number(axis, "encoder.step")
    return _ACCELERATIONS * torque / max(inertia, 1e-12) * table.period_s**2 + 4.0 * step


def _places(column: str, position: Floats, longest: float) -> Iterator[Impossible]:
    steps = np.diff(position)
    if len(steps) < 4 * _AROUND:
        return
    usual = _median_around(steps)
    bends = np.diff(steps)
    scatter = _SCATTERS * _MEDIAN_TO_SIGMA * float(np.median(np.abs(bends)))
    allowed = np.maximum(max(longest, scatter), _WAYS * np.abs(usual))
    off = steps - usual
    outliers = np.flatnonzero(np.abs(off) > allowed)
    spikes: list[int] = []
    k = 0
    while k < len(outliers):
        at = int(outliers[k])
        back = next(
            (
                j
                for j in outliers[k + 1 :]
                if j - at <= _LONGEST_SPIKE and abs(off[at] + off[j]) < _CANCELS * abs(off[at])
            ),
            None,
        )
        if back is None and at + 2 == len(position):
            # a last row that was cut off, or still in the making
            back = at + 1
        if back is None:
            yield Impossible(
                column, (at + 1,), f"jumps by {off[at]:.4g} in one row, which no torque of this axis can do", True
            )
            return
        spikes += range(at + 1, int(back) + 1)
        k = int(np.searchsorted(outliers, back, side="right"))
    if spikes:
        yield Impossible(column, tuple(spikes), "where the joint cannot have been")


def _far_off(column: str, torque: Floats, limit: float) -> Iterator[Impossible]:
    size = _LIMITS * limit if limit > 0.0 else _TORQUES * float(np.quantile(np.abs(torque), _ALMOST_ALL))
    most = float(np.max(np.abs(torque)))
    if len(torque) < 4 * _AROUND or size == 0.0:
        return
    rows = np.flatnonzero(np.abs(torque) > size)
    if len(rows) and len(rows) <= MOST_REPAIRED * len(torque):
        yield Impossible(column, tuple(map(int, rows)), "with a torque that the actuator cannot give")
        return
    # a negative number that was read without its sign: never below zero, all small or all near the top
    high = torque > 0.9 * most
    if torque.min() >= 0.0 and 0.02 < high.mean() < 0.98 and np.all(high | (torque < 0.1 * most)):
        row = int(np.argmax(high))
        yield Impossible(
            column,
            (row,),
            "is never negative and jumps to the top of its range, as a signed number does "
            "that is read without its sign",
            True,
        )


def _median_around(values: Floats) -> Floats:
    from scipy.ndimage import median_filter

    return np.asarray(median_filter(values, 2 * _AROUND + 1, mode="mirror"))


def _made_up(values: Floats, rows: Sequence[int]) -> Floats:
    good = np.ones(len(values), dtype=np.bool_)
    good[list(rows)] = False
    places = np.arange(len(values))
    return np.asarray(np.interp(places, places[good], values[good]))


def _where(table: SignalsTable, row: int) -> str:
    return f"row {row + 1} at {table.time_s[row]:.6g} s"


def _place(table: SignalsTable, one: Impossible) -> str:
    return f"{table.source or 'log'}: {one.column}, {_where(table, one.rows[0])}"


def _said(table: SignalsTable, one: Impossible) -> str:
    value = float(table.columns[one.column][one.rows[0]])
    more = f" ({len(one.rows)} rows in all)" if len(one.rows) > 1 else ""
    if one.is_jump:
        return f"reads {value:.6g} and {one.what}"
    return f"reads {value:.6g}, {one.what}{more}"


def _remedy(one: Impossible, rows: int, of: int) -> str:
    if one.is_jump:
        return f"a column that does not wrap or restart: {_wrap_of(one)}, or the log cut there"
    if rows > MOST_REPAIRED * of:
        return f"at most {MOST_REPAIRED:.0%} of such rows, which --repair makes up from their neighbours"
    other = f"; a signed number that was read without its sign is {_wrap_of(one)}" if _is_torque(one) else ""
    return f"the log without such rows; --repair makes them up from their neighbours and says so{other}"


def _is_torque(one: Impossible) -> bool:
    return one.column.endswith(".torque")


def _wrap_of(one: Impossible) -> str:
    """How `--column` says where a counter begins again."""
    name = f"{one.column} (or .current)" if _is_torque(one) else one.column
    return f"{name}=COLUMN%WRAP:UNIT in --column, WRAP the count at which it begins again, as 65536 of 16 bits"


__all__ = ["MOST_REPAIRED", "Impossible", "impossible_rows", "questioned"]
