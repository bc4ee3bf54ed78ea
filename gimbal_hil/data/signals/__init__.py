"""The signals table: measured data from run folders, CSV and Parquet, checked when read; logs on one time grid."""

from gimbal_hil.data.signals.by_motion import words_by_motion
from gimbal_hil.data.signals.clock import LONGEST_PERIOD_S, smaller_unit
from gimbal_hil.data.signals.column_map import ColumnMap
from gimbal_hil.data.signals.form import STATED_RATE
from gimbal_hil.data.signals.guessing import contents_of_table, guessed_words, is_read_by
from gimbal_hil.data.signals.reading import LogReading, read_signals, read_together, signals_of_run
from gimbal_hil.data.signals.resampling import on_grid
from gimbal_hil.data.signals.rigid_body import RigidBody, RigidMotion, base_rows, body_rates
from gimbal_hil.data.signals.table import SignalsTable, column_names
from gimbal_hil.data.signals.table_file import TableKind, csv_metadata, replacing, write_signals
from gimbal_hil.data.signals.units import unit_of, units_of

__all__ = [
    "LONGEST_PERIOD_S",
    "STATED_RATE",
    "ColumnMap",
    "LogReading",
    "RigidBody",
    "RigidMotion",
    "SignalsTable",
    "TableKind",
    "base_rows",
    "body_rates",
    "column_names",
    "contents_of_table",
    "csv_metadata",
    "guessed_words",
    "is_read_by",
    "on_grid",
    "read_signals",
    "read_together",
    "replacing",
    "signals_of_run",
    "smaller_unit",
    "unit_of",
    "units_of",
    "words_by_motion",
    "write_signals",
]
