"""Rows that no joint can make: positions that the actuator cannot have led to, and torques that cannot have been.

A read of an encoder that went wrong, a counter that wrapped behind a gear, a column that got stuck, a cell that was
cut: one such row in thousands hides what is missing, or becomes an all-clear. A step of position counts as impossible
where it differs from those around it by more than the actuator's acceleration, the log's own scatter and three times
the way that the joint goes in a row all allow.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.preflight.impossible import MOST_REPAIRED, ColumnFault, Floats, Impossible
from gimbal_hil.data.preflight.position_rows import impossible_positions
from gimbal_hil.data.preflight.rate_rows import impossible_rates
from gimbal_hil.data.preflight.slow_rows import require_fast_rows
from gimbal_hil.data.preflight.stating import stated_wrap
from gimbal_hil.data.preflight.torque_rows import impossible_torques, torques_lost_beside
from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel

_LISTED = 3


def questioned(
    model: AntennaModel, tables: Sequence[SignalsTable], repair: bool = False, among_others: bool = False
) -> tuple[SignalsTable, ...]:
    """The tables, with impossible rows made up from their neighbours where `repair` says so, which a note then tells.

    Of logs `among_others` that are not given here, one may be of a joint that coasts or is held. BadInputError names
    file, column, row, time and value of what cannot be.
    """
    if not among_others:
        _require_both_change(model, tables)
    return tuple(_questioned(model, table, repair) for table in tables)


def _require_both_change(model: AntennaModel, tables: Sequence[SignalsTable]) -> None:
    """Raise BadInputError where the joints move and no torque ever changes, or the other way round; where nothing
    happens at all there is nothing to refuse.
    """
    changes = {
        signal: any(float(np.ptp(getattr(table, signal)(axis))) > 0.0 for table in tables for axis in model.axes)
        for signal in ("position", "torque")
    }
    for signal, other in (("position", "torque"), ("torque", "position")):
        if changes[other] and not changes[signal]:
            where = ", ".join(dict.fromkeys(table.source or "log" for table in tables))
            problem = f"never changes, and the {other} does"
            raise BadInputError(f"{where}: {signal}", problem, "the column in which it was logged")


def impossible_rows(model: AntennaModel, table: SignalsTable) -> list[Impossible]:
    """What cannot be in a table, column by column."""
    found: list[Impossible] = []
    for axis in model.axes:
        positions = list(impossible_positions(model, table, axis))
        torques = list(impossible_torques(model, table, axis)) or list(torques_lost_beside(table, axis, positions))
        found += [*positions, *torques, *impossible_rates(model, table, axis)]
    return found


def _questioned(model: AntennaModel, table: SignalsTable, repair: bool) -> SignalsTable:
    require_fast_rows(table)
    asked, made_up = table, 0
    # what one column's rows hid in another is seen once they are made up
    while found := impossible_rows(model, asked):
        spikes = [one for one in found if one.can_be_made_up]
        rows = made_up + sum(len(one.rows) for one in spikes)
        if not repair or len(spikes) < len(found) or rows > MOST_REPAIRED * len(table):
            first = next((one for one in found if not one.can_be_made_up), found[0])
            raise BadInputError(_place(asked, first), _said(asked, first), _remedy(model, asked, first, rows))
        columns, notes, made_up = {one.column: asked.columns[one.column] for one in spikes}, [], rows
        for one in spikes:
            columns[one.column] = _made_up(columns[one.column], one.rows)
            notes.append(
                f"{one.column}: {len(one.rows)} of {len(table)} rows {one.what}, made up from their neighbours: "
                + ", ".join(_where(asked, row) for row in one.rows[:_LISTED])
                + (" ..." if len(one.rows) > _LISTED else "")
            )
        asked = asked.but(columns, notes)
    return asked


def _made_up(values: Floats, rows: Sequence[int]) -> Floats:
    good = np.ones(len(values), dtype=np.bool_)
    good[list(rows)] = False
    places = np.arange(len(values))
    return np.asarray(np.interp(places, places[good], values[good]))


def _where(table: SignalsTable, row: int) -> str:
    return f"row {row + 1} at {table.time_s[row]:.6g} s"


def _place(table: SignalsTable, one: Impossible) -> str:
    row, origin = one.rows[0], table.origins.get(one.column)
    column = "" if origin is None or origin.name == one.column else f", column {origin.name}"
    line = "" if table.lines is None else f" line {table.lines[row]}{column}:"
    return f"{table.source or 'log'}:{line} {one.column}, {_where(table, row)}"


def _said(table: SignalsTable, one: Impossible) -> str:
    value = float(table.columns[one.column][one.rows[0]])
    if one.fault in (ColumnFault.JUMP, ColumnFault.STILL):
        return f"reads {value:.6g} and {one.what}"
    more = f" ({len(one.rows)} rows in all)" if len(one.rows) > 1 else ""
    return f"reads {value:.6g}, {one.what}{more}"


def _remedy(model: AntennaModel, table: SignalsTable, one: Impossible, rows: int) -> str:
    if one.fault is ColumnFault.STILL:
        return "a column that is refreshed, within its range, and a joint that is at no stop; else the log cut there"
    if one.fault is ColumnFault.ZERO:
        middle = float(np.mean(table.columns[one.column]))
        return f"a torque or current that is zero where the drive gives none, here about {middle:.3g} less"
    if not one.can_be_made_up:
        stated = stated_wrap(model, table, one)
        if stated:
            return f"a column that does not begin again: {stated} carries it on"
        return f"a column that does not wrap or restart: {_wrap_of(one)}, or the log cut there"
    if rows > MOST_REPAIRED * len(table):
        return f"at most {MOST_REPAIRED:.0%} of such rows, which --repair makes up from their neighbours"
    return "the log without such rows; --repair makes them up from their neighbours and says so"


def _wrap_of(one: Impossible) -> str:
    """How `--column` says where a counter begins again."""
    name = f"{one.column} (or .current)" if one.column.endswith(".torque") else one.column
    return f"{name}=COLUMN%WRAP:UNIT in --column, WRAP the count at which it begins again, as 65536 of 16 bits"


__all__ = ["MOST_REPAIRED", "Impossible", "impossible_rows", "questioned"]
