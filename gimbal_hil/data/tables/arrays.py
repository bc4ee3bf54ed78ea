"""Parquet, npz and npy files as columns of numbers."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any
from zipfile import BadZipFile

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.tables.moments import seconds_of, seconds_of_array
from gimbal_hil.data.tables.raw import EMPTY_WORDS, Floats, RawColumns, cleaned, told_apart

_EXPECTED = "a CSV, Parquet or npz file with a header row and one row per sample"
#: what numpy runs into in a file that was cut or changed
_BROKEN = (
    ArithmeticError,
    BadZipFile,
    EOFError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    SyntaxError,
    TypeError,
    ValueError,
    struct.error,
    zlib.error,
)
Cells = np.ndarray | Sequence[str | None]


def parquet_module(path: Path) -> ModuleType:
    """pyarrow's module for it; raises BadInputError where it is not installed."""
    try:
        import pyarrow.parquet
    except ImportError:
        raise BadInputError(
            str(path), "Parquet needs the package pyarrow, which is not installed", "pip install 'gimbal-hil[parquet]'"
        ) from None
    return pyarrow.parquet


def read_parquet(path: Path) -> RawColumns:
    """A Parquet file of plain columns; times and spans of time are seconds from the first."""
    parquet = parquet_module(path)
    import pyarrow as pa

    try:
        table = parquet.read_table(path)
    except (pa.ArrowException, OSError, ValueError) as error:
        raise BadInputError(str(path), f"is no whole Parquet file: {one_line(error)}", _EXPECTED) from error
    return _columns(path, table.column_names, [_arrow_cells(column) for column in table.columns])


def read_numpy(path: Path) -> RawColumns:
    """An archive of arrays of one length, as `numpy.savez` leaves it, or one array: records are a column each field,
    arrays of two dimensions one each place.
    """
    try:
        loaded = np.load(path, allow_pickle=False)
        if isinstance(loaded, np.ndarray):
            found = {"": loaded}
        else:
            with loaded:
                found = {name: loaded[name] for name in loaded.files}
    except _BROKEN as error:
        raise BadInputError(str(path), f"is no whole npz file: {one_line(error)}", _EXPECTED) from error
    arrays = [pair for name, values in found.items() for pair in _spread(_own_name(name, found), np.asarray(values))]
    lengths = {values.shape for _, values in arrays}
    if len(lengths) != 1 or len(lengths.pop()) != 1:
        raise BadInputError(str(path), "holds arrays of several shapes, or none", "one value a row in each")
    return _columns(path, [name for name, _ in arrays], [_cells(values) for _, values in arrays])


def _own_name(name: str, found: Mapping[str, object]) -> str:
    """What an array is called; one alone that nobody named has no name of its own."""
    return "" if len(found) == 1 and name == "arr_0" else name


def _spread(name: str, values: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    if values.dtype.names:
        for field in values.dtype.names:
            yield from _spread(f"{name}.{field}" if name else field, np.asarray(values[field]))
    elif values.ndim == 2:
        for place in range(min(values.shape[1], 1000)):
            yield f"{name}[{place}]" if name else str(place + 1), values[:, place]
    else:
        yield name, values


def _cells(values: np.ndarray) -> Cells:
    if values.dtype.kind in "fiub":
        return np.asarray(values, np.float64)
    return seconds_of_array(values) if values.dtype.kind in "Mm" else values.astype(str).tolist()


def _arrow_cells(column: Any) -> Cells:
    import pyarrow as pa

    if pa.types.is_integer(column.type) or pa.types.is_floating(column.type) or pa.types.is_decimal(column.type):
        return np.array(column.cast(pa.float64(), safe=False).to_numpy(), np.float64)
    if pa.types.is_timestamp(column.type) or pa.types.is_duration(column.type):
        return seconds_of_array(column.to_numpy())
    return [None if cell is None else str(cell) for cell in column.to_pylist()]


def _columns(path: Path, names: Sequence[str], columns: Sequence[Cells]) -> RawColumns:
    called, doubts = told_apart(names)
    values: dict[str, Floats] = {}
    texts: dict[str, dict[int, str]] = {}
    for name, column in zip(called, columns, strict=True):
        values[name], texts[name] = _numbers(column)
    return RawColumns(path, values, texts, first_row=1, doubts=doubts)


def numbers_in(cells: Cells) -> Floats:
    """Cells as numbers (n,), NaN for what is none; where no cell is one, dates and times of day as seconds."""
    return _numbers(cells)[0]


def _numbers(cells: Cells) -> tuple[Floats, dict[int, str]]:
    if isinstance(cells, np.ndarray):
        return cleaned(cells)
    found = np.array([_number(cell) for cell in cells], np.float64)
    if len(found) and not np.isfinite(found).any() and (seconds := seconds_of(cells)) is not None:
        return seconds, {}
    values, texts = cleaned(found)
    texts |= {
        row: cell
        for row, cell in enumerate(cells)
        if cell is not None and not math.isfinite(found[row]) and cell.strip().lower() not in EMPTY_WORDS
    }
    return values, texts


def _number(cell: str | None) -> float:
    try:
        return float(cell) if cell is not None and "_" not in cell else math.nan
    except ValueError:
        return math.nan


def one_line(error: Exception) -> str:
    """What an error says, in one line."""
    return " ".join(str(error).split())
