"""One door for measured data: run folders, CSV and Parquet files in, checked signals tables out, on one grid where they
must be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError, DamagedRunError
from gimbal_hil.data.runs import RecordedRun, damage_of, is_run_folder, open_run
from gimbal_hil.data.signals.column_map import ColumnMap
from gimbal_hil.data.signals.container_file import read_container
from gimbal_hil.data.signals.form import AxisNames, checked_table
from gimbal_hil.data.signals.kept_rows import Repair
from gimbal_hil.data.signals.refreshed import on_refreshed_rows
from gimbal_hil.data.signals.repeated_reads import without_repeated_reads
from gimbal_hil.data.signals.resampling import on_grid
from gimbal_hil.data.signals.run_signals import run_columns
from gimbal_hil.data.signals.table import REPEAT, TIME, SignalsTable
from gimbal_hil.data.tables import RawColumns, read_table
from sim_backend.model import AntennaModel

#: periods of logs that differ by less are one period
_SAME_PERIOD = 0.01
_AS_CALLED = ColumnMap({})


@dataclass(frozen=True)
class LogReading:
    """How logs are read: what their columns are, the grid that rows are put on (`Repair`), whether invalid rows may be
    dropped, and whether rows that no joint can make may be made up (`data.preflight.questioned`).
    """

    columns: ColumnMap = _AS_CALLED
    resample: bool = False
    rate_hz: float | None = None
    drop_invalid: bool = False
    repair: bool = False


_AS_IT_IS = LogReading()


def read_together(
    paths: Sequence[Path], model: AntennaModel, reading: LogReading = _AS_IT_IS
) -> tuple[SignalsTable, ...]:
    """The logs of one question about a model, all at one rate; of a run folder, the rows under control.

    Logs of different rates are refused unless a grid is asked for; then all get `rate_hz`, or the rate of the slowest
    log, at which no log has rows that were not measured. Raises BadInputError as `read_signals` does.
    """
    repair, columns = Repair(reading.resample, reading.drop_invalid, reading.rate_hz), reading.columns
    tables = [_under_control(path, model, repair, columns) for path in paths]
    slowest = max((table.period_s for table in tables), default=0.0)
    apart = [table for table in tables if abs(table.period_s - slowest) > _SAME_PERIOD * slowest]
    if apart and not repair.to_grid:
        first, other = (
            tables[0],
            next(t for t in tables if abs(t.period_s - tables[0].period_s) > _SAME_PERIOD * slowest),
        )
        raise BadInputError(
            f"{other.source}: time_s",
            f"has a period of {other.period_s:.6g} s where {first.source} has {first.period_s:.6g} s",
            "one rate for all logs; --resample or --rate HZ puts them on one grid",
        )
    if repair.to_grid and repair.rate_hz is None and slowest > 0.0:
        # once more from the file: rows are put on a grid once, not twice
        wanted = replace(repair, rate_hz=1.0 / slowest)
        tables = [
            table if abs(table.period_s - slowest) < 1e-9 * slowest else _under_control(path, model, wanted, columns)
            for path, table in zip(paths, tables, strict=True)
        ]
    return tuple(tables)


def read_signals(
    path: Path,
    axes: Sequence[str] | AntennaModel,
    *,
    resample: bool = False,
    drop_invalid: bool = False,
    rate_hz: float | None = None,
    columns: ColumnMap = _AS_CALLED,
    passive: Sequence[str] = (),
) -> SignalsTable:
    """The signals of the model's axes in a run folder, CSV or Parquet file; with the model itself, currents become
    torques. `columns` says what files of somebody else call them, and in which units; run folders need none. Of the
    axes in `passive` a position is enough.

    Raises BadInputError that names file, row and column for anything that docs/reference/signals-table.md refuses; what
    was accepted by way of `resample`, `drop_invalid` and `rate_hz` (see `Repair`), and columns that were not
    understood, stands in the table's `notes`.
    """
    named = replace(axis_names(axes), passive=tuple(passive))
    return _read(Path(path), named, Repair(resample, drop_invalid, rate_hz), columns)


def signals_of_run(
    run: RecordedRun,
    axes: Sequence[str] | None = None,
    *,
    resample: bool = False,
    drop_invalid: bool = False,
    rate_hz: float | None = None,
) -> SignalsTable:
    """The signals of a run that is already open, under the same rules; of the run's own axes where none are named."""
    return _of_run(run, axes or run.record.header.axes, Repair(resample, drop_invalid, rate_hz))


def _read(path: Path, named: AxisNames, repair: Repair, columns: ColumnMap) -> SignalsTable:
    if is_run_folder(path):
        return _of_run(open_run(path), named.axes, repair)
    contained = read_container(path, named, columns)
    if contained is None:
        raw = columns.read(read_table(path), named.axes, not named.rotary)
        return _of_reads(checked_table(raw, named, repair), repair)
    table = checked_table(contained.called.read(contained.raw, named.axes, not named.rotary), named, repair)
    return _of_reads(replace(table, notes=(*contained.notes, *table.notes)), repair)


def _of_reads(table: SignalsTable, repair: Repair) -> SignalsTable:
    """The table with no position that the encoder did not read then."""
    refreshed = on_refreshed_rows(table)
    return without_repeated_reads(table, repair) if refreshed is table else refreshed


def _of_run(run: RecordedRun, axes: Sequence[str], repair: Repair) -> SignalsTable:
    own = run.record.header.axes
    if set(axes) != set(own):
        raise BadInputError(
            str(run.folder), f"is a run of the axes {', '.join(own)}", f"a log of the model's axes {', '.join(axes)}"
        )
    _require_sound(run, repair)
    time_s, columns, laps, notes = run_columns(run)
    values = {TIME: time_s, **columns} | ({} if laps is None else {REPEAT: laps.astype(float)})
    raw = RawColumns(run.folder, values, {name: {} for name in values})
    table = checked_table(raw, AxisNames(tuple(axes)), repair)
    return SignalsTable.of(table.axes, table.time_s, table.columns, table.repeat, table.source, (*notes, *table.notes))


def _require_sound(run: RecordedRun, repair: Repair) -> None:
    """A run with lost or changed rows is taken where the caller has asked for repair; a damaged event changes no
    signal.
    """
    if repair.to_grid or repair.drop_invalid:
        return
    for found in damage_of(run):
        if not found.signal.startswith("events"):
            remedy = "expected the run as it was recorded, or --drop-invalid (--resample) to work with what is left"
            raise DamagedRunError(f"{run.folder}: the log is damaged: {found.in_words()}; {remedy}")


def axis_names(of: Sequence[str] | AntennaModel) -> AxisNames:
    """The axes to read, with the torque constants that a model states."""
    if not isinstance(of, AntennaModel):
        return AxisNames(tuple(of))
    constants = {axis: of.number(axis, "actuator.torque_constant") for axis in of.axes}
    known = {axis: constant for axis, constant in constants.items() if constant > 0.0}
    return AxisNames(of.axes, known, not of.is_linear, of.name)


def _under_control(path: Path, model: AntennaModel, repair: Repair, columns: ColumnMap) -> SignalsTable:
    """Of a run, the rows under control: before them the joints fall freely, after them an experiment's teardown only
    holds still.
    """
    if not is_run_folder(path):
        return _read(path, axis_names(model), repair, columns)
    run = open_run(path)
    # rows are counted in the run's own periods, so they are cut out before they are put on another grid
    table = _of_run(run, model.axes, replace(repair, rate_hz=None, resample=repair.to_grid))
    active = np.flatnonzero(run.ticks["segment"] >= 0)
    if len(active):
        ends = [e.tick for e in run.events if e.begins_teardown]
        # the table's last row is the run's; a tick that the host skipped has a row, so ticks are counted, not rows
        start = int(run.ticks["tick"][-1]) - len(table) + 1
        first = max(0, int(run.ticks["tick"][active[0]]) - start)
        last = (ends[0] if ends else int(run.ticks["tick"][active[-1]])) - start
        table = table.rows(first, min(len(table), max(last, first + 2)))
    return table if repair.period_s is None else on_grid(table, repair.period_s)
