"""CSV, Parquet and npz files as columns of numbers, every cell that is none remembered by row and text."""

from __future__ import annotations

import csv
import io
import math
import os
import warnings
import zlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile, ZipInfo

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.documents import LARGEST_NUMBER, require_regular
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals.table import REPEAT, TIME, SignalsTable
from gimbal_hil.data.signals.units import units_of

#: rows of a file that are written in one go
#: lines below which a file is no log that was cut off
_LEAST_LINES = 10
_ROWS_AT_ONCE = 50_000
_EXPECTED = "a CSV, Parquet or npz file with a header row and one row per sample"
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
    #: what a reader of results should know of how the file was read
    notes: tuple[str, ...] = ()

    def where(self, row: int, column: str) -> str:
        """Names file, row and column of a cell."""
        unit = "line" if self.first_line == 2 else "row"
        return f"{self.path}: {unit} {row + self.first_line}, column {self.called.get(column, column)}"


def read_file(path: Path) -> RawColumns:
    """Read a table file, by its content; raises BadInputError when it is none."""
    require_regular(path, _EXPECTED)
    try:
        with path.open("rb") as file:
            start = file.read(4)
    except OSError as error:
        raise BadInputError(str(path), _reason(error), _EXPECTED) from error
    if not start:
        raise BadInputError(str(path), "is empty", _EXPECTED)
    if start == b"PAR1" or path.suffix.lower() in (".parquet", ".pq"):
        return _read_parquet(path)
    return _read_npz(path) if start == b"PK\x03\x04" or path.suffix.lower() == ".npz" else _read_csv(path)


class TableKind(Enum):
    """Kinds of table files."""

    CSV = "csv"
    PARQUET = "parquet"
    NPZ = "npz"


def write_signals(table: SignalsTable, path: Path, kind: TableKind | None = None, *, force: bool = False) -> None:
    """Write a table as CSV, Parquet or numpy's npz, by the name's ending unless `kind` is given; a reader gets every
    number back exactly.

    Raises BadInputError when the file is there and `force` is false, and when it cannot be written; never leaves half a
    file.
    """
    if kind is None:
        kinds = {".pq": TableKind.PARQUET} | {f".{kind.value}": kind for kind in TableKind}
        if path.suffix.lower() not in kinds:
            raise BadInputError(str(path), f"has the ending {path.suffix!r}", "the ending .csv, .parquet or .npz")
        kind = kinds[path.suffix.lower()]
    columns = {TIME: table.time_s, **table.columns} | ({} if table.repeat is None else {REPEAT: table.repeat})
    with replacing(path, force) as temporary:
        _WRITERS[kind](columns, temporary)


def _write_csv(columns: Mapping[str, NDArray[np.generic]], path: Path) -> None:
    rows = len(columns[TIME])
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(",".join(columns) + "\n")
        for first in range(0, rows, _ROWS_AT_ONCE):
            cells = [map(repr, values[first : first + _ROWS_AT_ONCE].tolist()) for values in columns.values()]
            file.writelines(",".join(row) + "\n" for row in zip(*cells, strict=True))


def _write_parquet(columns: Mapping[str, NDArray[np.generic]], path: Path) -> None:
    parquet = _parquet(path)
    import pyarrow as pa

    units = units_of(list(columns))
    arrays = [pa.array(values) for values in columns.values()]
    fields = [
        pa.field(name, array.type, metadata={"unit": units[name]}) for name, array in zip(columns, arrays, strict=True)
    ]
    parquet.write_table(pa.table(arrays, schema=pa.schema(fields)), path)


def _write_npz(columns: Mapping[str, NDArray[np.generic]], path: Path) -> None:
    # level 1: three times as fast as numpy's, 5 % larger; without a date, so that the same rows are the same bytes
    with ZipFile(path, "w", ZIP_DEFLATED, compresslevel=1) as archive:
        for name, values in columns.items():
            entry = ZipInfo(f"{name}.npy")
            entry.compress_type = ZIP_DEFLATED
            with archive.open(entry, "w") as file:
                np.lib.format.write_array(file, np.ascontiguousarray(values), allow_pickle=False)


_WRITERS = {TableKind.CSV: _write_csv, TableKind.PARQUET: _write_parquet, TableKind.NPZ: _write_npz}


def _parquet(path: Path) -> Any:
    """pyarrow's module for it; raises BadInputError where it is not installed."""
    try:
        import pyarrow.parquet
    except ImportError:
        raise BadInputError(
            str(path), "Parquet needs the package pyarrow, which is not installed", "pip install 'gimbal-hil[parquet]'"
        ) from None
    return pyarrow.parquet


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
    try:
        text = path.read_bytes().decode("utf-8-sig")
        text, notes = _whole_lines(text)
        between, point = _separators(text)
        names = [name.strip() for name in next(csv.reader(text.splitlines()[:1], delimiter=between), [])]
        found = _all_numbers(text, between, point, len(names))
        if found is not None:
            cells: list[Any] = list(found)
            ragged: list[tuple[int, int, int]] = []
        else:
            cells, ragged = _cells(text, between, len(names))
    except (csv.Error, UnicodeDecodeError, OSError) as error:
        raise BadInputError(str(path), f"is no CSV file: {_one_line(error)}", _EXPECTED) from error
    return replace(_raw_columns(path, names, cells, 2, tuple(ragged), point), notes=notes)


def _whole_lines(text: str) -> tuple[str, tuple[str, ...]]:
    """The text up to its last line end: a number that was cut off is still a number, of another size."""
    whole = text[: text.rfind("\n") + 1]
    if whole == text or whole.count("\n") < _LEAST_LINES:
        return text, ()
    return whole, (f"line {whole.count(chr(10)) + 1}, the last one, has no line end and was left out: it may be cut",)


def _all_numbers(text: str, between: str, point: str, width: int) -> NDArray[np.float64] | None:
    """Columns of a file in which every cell is a number; None for another one."""
    lines = io.StringIO(text if point == "." else text.replace(point, "."))
    lines.readline()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # of a file without rows
            found = np.loadtxt(lines, np.float64, comments=None, delimiter=between, ndmin=2)
    except (ValueError, UserWarning):
        return None
    return found.T if found.shape[1] == width else None


def _cells(text: str, between: str, width: int) -> tuple[list[list[str]], list[tuple[int, int, int]]]:
    """Cells of each column, and (line, wanted, found) of the rows with too few or too many, which are left out."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=between)
    next(reader, None)
    rows: list[list[str]] = []
    ragged = []
    for row in reader:
        if len(row) == width:
            rows.append(row)
        elif row:
            ragged.append((reader.line_num, width, len(row)))
    return [list(column) for column in zip(*rows, strict=True)] or [[] for _ in range(width)], ragged


def _separators(text: str) -> tuple[str, str]:
    """What stands between cells and before decimals. Where a header has no comma but semicolons or tabs, those part the
    cells, and numbers may have commas.
    """
    head, first = (*text.split("\n", 2), "", "")[:2]
    between = next((mark for mark in ",;\t" if mark in head), ",")
    return between, "," if between != "," and "," in first and "." not in first else "."


def _read_parquet(path: Path) -> RawColumns:
    parquet = _parquet(path)
    import pyarrow as pa

    try:
        table = parquet.read_table(path)
    except (pa.ArrowException, OSError, ValueError) as error:
        raise BadInputError(str(path), f"is no whole Parquet file: {_one_line(error)}", _EXPECTED) from error
    return _raw_columns(path, table.column_names, [_arrow_cells(column) for column in table.columns], 1, ())


def _read_npz(path: Path) -> RawColumns:
    """An archive of arrays of one length, as `numpy.savez` leaves it."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            found = {name: archive[name] for name in archive.files}
    except (ValueError, OSError, EOFError, BadZipFile, zlib.error) as error:
        raise BadInputError(str(path), f"is no whole npz file: {_one_line(error)}", _EXPECTED) from error
    lengths = {values.shape for values in found.values()}
    if len(lengths) != 1 or len(lengths.pop()) != 1:
        raise BadInputError(str(path), "holds arrays of several shapes, or none", "one value a row in each")
    cells = [
        np.asarray(values, np.float64) if values.dtype.kind in "fiu" else values.astype(str).tolist()
        for values in found.values()
    ]
    return _raw_columns(path, list(found), cells, 1, ())


def _arrow_cells(column: Any) -> Any:
    import pyarrow as pa

    if pa.types.is_integer(column.type) or pa.types.is_floating(column.type) or pa.types.is_decimal(column.type):
        return np.array(column.cast(pa.float64(), safe=False).to_numpy(), np.float64)
    return [None if cell is None else str(cell) for cell in column.to_pylist()]


def _raw_columns(
    path: Path,
    names: list[str],
    cells: Sequence[NDArray[np.float64] | Sequence[str | None]],
    first_line: int,
    ragged: tuple[tuple[int, int, int], ...],
    point: str = ".",
) -> RawColumns:
    repeated = [name for name, count in Counter(names).items() if count > 1]
    if repeated:
        raise BadInputError(str(path), f"has two columns named {repeated[0]!r}", "every name once")
    values: dict[str, NDArray[np.float64]] = {}
    texts: dict[str, dict[int, str]] = {}
    for name, column in zip(names, cells, strict=True):
        values[name], texts[name] = _numbers(column, point)
    return RawColumns(path, values, texts, first_line, ragged)


def _numbers(
    cells: NDArray[np.float64] | Sequence[str | None], point: str
) -> tuple[NDArray[np.float64], dict[int, str]]:
    if isinstance(cells, np.ndarray):
        values = np.array(cells)
        texts = {int(row): str(values[row]) for row in np.flatnonzero(np.isinf(values))}
    else:
        numbers = [_number(cell if point == "." or cell is None else cell.replace(point, ".")) for cell in cells]
        values = np.array(numbers, np.float64)
        texts = {
            row: cell
            for row, cell in enumerate(cells)
            if cell is not None and not math.isfinite(numbers[row]) and cell.strip().lower() not in _EMPTY_WORDS
        }
    # what nobody measures overflows in the first square
    beyond = np.isfinite(values) & (np.abs(values) > LARGEST_NUMBER)
    texts |= {int(row): f"{values[row]:g}" for row in np.flatnonzero(beyond)}
    values[beyond | ~np.isfinite(values)] = np.nan
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
