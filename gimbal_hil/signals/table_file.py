"""CSV and Parquet files as columns of numbers, every cell that is none remembered by row and text."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError
from gimbal_hil.signals.table import REPEAT, TIME, SignalsTable
from gimbal_hil.signals.units import units_of

_EXPECTED = "a CSV or Parquet file with a header row and one row per sample"
_EMPTY_WORDS = frozenset(("", "nan", "na", "n/a", "null", "none"))


@dataclass(frozen=True)
class RawColumns:
    """A file as it is: `values` (n,) by column name with NaN where there is no finite number, `texts` what stood there
    instead.

    `lines` are the rows' numbers in the file, for messages; `ragged` lists rows that have too few or too many cells
    (left out).
    """

    path: Path
    values: Mapping[str, NDArray[np.float64]]
    texts: Mapping[str, Mapping[int, str]]
    first_line: int
    ragged: tuple[tuple[int, int, int], ...] = field(default=())
    #: what the file calls columns that were given another name, by that name
    called: Mapping[str, str] = field(default_factory=dict)

    def where(self, row: int, column: str) -> str:
        """Names file, row and column of a cell."""
        unit = "line" if self.first_line == 2 else "row"
        return f"{self.path}: {unit} {row + self.first_line}, column {self.called.get(column, column)}"


def read_file(path: Path) -> RawColumns:
    """Read a table file, by its content; raises BadInputError when it is none."""
    try:
        with path.open("rb") as file:
            start = file.read(4)
    except OSError as error:
        raise BadInputError(str(path), _reason(error), _EXPECTED) from error
    if not start:
        raise BadInputError(str(path), "is empty", _EXPECTED)
    return _read_parquet(path) if start == b"PAR1" or path.suffix.lower() in (".parquet", ".pq") else _read_csv(path)


class TableKind(Enum):
    """Kinds of table files."""

    CSV = "csv"
    PARQUET = "parquet"


def write_signals(table: SignalsTable, path: Path, kind: TableKind | None = None, *, force: bool = False) -> None:
    """Write a table as CSV or Parquet, by the name's ending unless `kind` is given; a reader gets every number back
    exactly.

    Raises BadInputError when the file is there and `force` is false, and when it cannot be written; never leaves half a
    file.
    """
    import pyarrow as pa
    import pyarrow.csv
    import pyarrow.parquet

    if kind is None:
        kinds = {".csv": TableKind.CSV, ".parquet": TableKind.PARQUET, ".pq": TableKind.PARQUET}
        if path.suffix.lower() not in kinds:
            raise BadInputError(str(path), f"has the ending {path.suffix!r}", "the ending .csv or .parquet")
        kind = kinds[path.suffix.lower()]
    columns = {TIME: table.time_s, **table.columns} | ({} if table.repeat is None else {REPEAT: table.repeat})
    units = units_of(list(columns))
    fields = [pa.field(name, pa.array(values).type, metadata={"unit": units[name]}) for name, values in columns.items()]
    content = pa.table([pa.array(values) for values in columns.values()], schema=pa.schema(fields))
    with replacing(path, force) as temporary:
        if kind is TableKind.CSV:
            with temporary.open("wb") as file:
                file.write((",".join(columns) + "\n").encode())
                pa.csv.write_csv(content, file, pa.csv.WriteOptions(include_header=False))
        else:
            pa.parquet.write_table(content, temporary)


def csv_metadata(table: SignalsTable, name: str) -> str:
    """What the W3C calls metadata of tabular data, for a CSV file of that name: the unit of every column, which its
    header has no place for. It lies beside the file as `NAME-metadata.json`.
    """
    import json

    columns = [TIME, *table.columns, *([] if table.repeat is None else [REPEAT])]
    described = [
        {"name": column, "titles": column, "datatype": "integer" if column == REPEAT else "double"}
        | ({"schema:unitText": unit} if unit else {})
        for column, unit in units_of(columns).items()
    ]
    content = {"@context": "http://www.w3.org/ns/csvw", "url": name, "tableSchema": {"columns": described}}
    return json.dumps(content, indent=1) + "\n"


class replacing:
    """A file that appears whole or not at all: write to the path given, it takes the name when the block ends well."""

    def __init__(self, path: Path, force: bool) -> None:
        self._path, self._force = path, force
        self._temporary = path.with_name(f".{os.getpid()}.{path.name}")

    def __enter__(self) -> Path:
        if self._path.exists() and not self._force:
            raise BadInputError(str(self._path), "already exists", "a new name, or --force to overwrite it")
        if not self._path.parent.is_dir():
            raise BadInputError(str(self._path.parent), "is not a folder", "a folder to write to")
        return self._temporary

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if error is None:
            try:
                self._temporary.replace(self._path)
            except OSError as failed:
                error = failed
        if error is not None:
            self._temporary.unlink(missing_ok=True)
            if isinstance(error, OSError):
                raise BadInputError(str(self._path), _reason(error), "a place that can be written to") from error


def _read_csv(path: Path) -> RawColumns:
    import pyarrow as pa
    import pyarrow.csv as csv

    ragged: list[tuple[int, int, int]] = []

    def note_ragged(row: Any) -> str:
        ragged.append((row.number, row.expected_columns, row.actual_columns))
        return "skip"

    reading = csv.ReadOptions(use_threads=False)
    try:
        content = path.read_bytes()
        text = content.decode("utf-8-sig")
        between, point = _separators(text)
        parsing = csv.ParseOptions(delimiter=between, invalid_row_handler=note_ragged)
        names = _header(text, between)
        try:
            table = csv.read_csv(
                pa.BufferReader(content),
                reading,
                parsing,
                csv.ConvertOptions(column_types=dict.fromkeys(names, pa.float64()), decimal_point=point),
            )
        except pa.ArrowInvalid:
            ragged.clear()
            options = csv.ConvertOptions(column_types=dict.fromkeys(names, pa.string()))
            table = csv.read_csv(pa.BufferReader(content), reading, parsing, options)
    except (pa.ArrowException, UnicodeDecodeError, ValueError, OSError) as error:
        raise BadInputError(str(path), f"is no CSV file: {_one_line(error)}", _EXPECTED) from error
    return _raw_columns(path, [name.strip() for name in names], table, 2, tuple(ragged), point)


def _separators(text: str) -> tuple[str, str]:
    """What stands between cells and before decimals. Where a header has no comma but semicolons or tabs, those part the
    cells, and numbers may have commas.
    """
    head, first = (*text.split("\n", 2), "", "")[:2]
    between = next((mark for mark in ",;\t" if mark in head), ",")
    return between, "," if between != "," and "," in first and "." not in first else "."


def _header(text: str, between: str) -> list[str]:
    import csv

    return next(csv.reader(text.splitlines()[:1], delimiter=between), [])


def _read_parquet(path: Path) -> RawColumns:
    import pyarrow as pa
    import pyarrow.parquet

    try:
        table = pa.parquet.read_table(path)
    except (pa.ArrowException, OSError, ValueError) as error:
        raise BadInputError(str(path), f"is no whole Parquet file: {_one_line(error)}", _EXPECTED) from error
    return _raw_columns(path, table.column_names, table, 1, ())


def _raw_columns(
    path: Path,
    names: list[str],
    table: Any,
    first_line: int,
    ragged: tuple[tuple[int, int, int], ...],
    point: str = ".",
) -> RawColumns:
    repeated = [name for name, count in Counter(names).items() if count > 1]
    if repeated:
        raise BadInputError(str(path), f"has two columns named {repeated[0]!r}", "every name once")
    values: dict[str, NDArray[np.float64]] = {}
    texts: dict[str, dict[int, str]] = {}
    for place, name in enumerate(names):
        values[name], texts[name] = _numbers(table.column(place), point)
    return RawColumns(path, values, texts, first_line, ragged)


def _numbers(column: Any, point: str) -> tuple[NDArray[np.float64], dict[int, str]]:
    import pyarrow as pa

    if pa.types.is_integer(column.type) or pa.types.is_floating(column.type) or pa.types.is_decimal(column.type):
        values = np.array(column.cast(pa.float64(), safe=False).to_numpy(), np.float64)
        texts = {int(row): str(values[row]) for row in np.flatnonzero(np.isinf(values))}
    else:
        cells = [None if cell is None else str(cell) for cell in column.to_pylist()]
        numbers = [_number(cell if point == "." or cell is None else cell.replace(point, ".")) for cell in cells]
        values = np.array(numbers, np.float64)
        texts = {
            row: cell
            for row, cell in enumerate(cells)
            if cell is not None and not math.isfinite(numbers[row]) and cell.strip().lower() not in _EMPTY_WORDS
        }
    values[~np.isfinite(values)] = np.nan
    return values, texts


def _number(cell: str | None) -> float:
    try:
        return float(cell) if cell is not None and "_" not in cell else math.nan
    except ValueError:
        return math.nan


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def _reason(error: OSError) -> str:
    return error.strerror.lower() if error.strerror else str(error)
