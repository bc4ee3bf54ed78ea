"""One door for measured data: a run folder, a CSV or a Parquet file in, a checked signals table out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from firmware_protocol.errors import BadInputError
from gimbal_hil.runs import AXES, Run, is_run_folder, open_run
from gimbal_hil.signals.preflight import checked_table
from gimbal_hil.signals.run_signals import run_columns
from gimbal_hil.signals.table import REPEAT, TIME, SignalsTable
from gimbal_hil.signals.table_file import RawColumns, read_file


def read_signals(path: Path, axes: Sequence[str], *, resample: bool = False, drop_invalid: bool = False) -> SignalsTable:
    """The signals of the model's `axes` in a run folder, CSV or Parquet file.

    Raises BadInputError that names file, row and column for anything that CONTRACTS section 4 refuses; what was accepted by way of
    `resample` and `drop_invalid`, and columns that were not understood, stands in the table's `notes`.
    """
    path = Path(path)
    if is_run_folder(path):
        return signals_of_run(open_run(path), axes, resample=resample, drop_invalid=drop_invalid)
    return checked_table(read_file(path), axes, resample=resample, drop_invalid=drop_invalid)


def signals_of_run(run: Run, axes: Sequence[str] = AXES, *, resample: bool = False, drop_invalid: bool = False) -> SignalsTable:
    """The signals of a run that is already open, under the same rules."""
    if set(axes) != set(AXES):
        raise BadInputError(str(run.folder), f"is a run of the axes {', '.join(AXES)}", f"a log of the model's axes {', '.join(axes)}")
    time_s, columns, laps, notes = run_columns(run)
    values = {TIME: time_s, **columns} | ({} if laps is None else {REPEAT: laps.astype(float)})
    raw = RawColumns(run.folder, values, {name: {} for name in values}, first_line=0)
    table = checked_table(raw, axes, resample=resample, drop_invalid=drop_invalid)
    return SignalsTable.of(table.axes, table.time_s, table.columns, table.repeat, table.source, (*notes, *table.notes))
