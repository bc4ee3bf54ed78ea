"""Tables as they stand in files, of text, Parquet and numpy: named columns of numbers, and what they are in."""

from gimbal_hil.data.tables.arrays import numbers_in, parquet_module
from gimbal_hil.data.tables.file import is_text_table, read_table
from gimbal_hil.data.tables.moments import BETWEEN_ROWS_S, DAY_S
from gimbal_hil.data.tables.raw import FileColumn, Floats, OddLine, RawColumns, listed
from gimbal_hil.data.tables.text import text_of_lines
from gimbal_hil.data.tables.unit_words import RAW_WORDS, UNITS, knows_all_units, unit_in_name, unit_size

__all__ = [
    "BETWEEN_ROWS_S",
    "DAY_S",
    "RAW_WORDS",
    "UNITS",
    "FileColumn",
    "Floats",
    "OddLine",
    "RawColumns",
    "is_text_table",
    "knows_all_units",
    "listed",
    "numbers_in",
    "parquet_module",
    "read_table",
    "text_of_lines",
    "unit_in_name",
    "unit_size",
]
