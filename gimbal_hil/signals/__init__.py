"""The signals table: measured data from run folders, CSV and Parquet, checked at the door."""

from gimbal_hil.signals.reading import read_signals, signals_of_run
from gimbal_hil.signals.table import SignalsTable, column_names
from gimbal_hil.signals.table_file import TableKind, replacing, write_signals

__all__ = ["SignalsTable", "TableKind", "column_names", "read_signals", "replacing", "signals_of_run", "write_signals"]
