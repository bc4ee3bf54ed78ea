"""A table file, whatever it is: read by its content."""

from __future__ import annotations

from pathlib import Path

from firmware_protocol.documents import require_regular
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.tables.arrays import read_numpy, read_parquet
from gimbal_hil.data.tables.raw import RawColumns
from gimbal_hil.data.tables.text import looks_like_rows, read_text

_EXPECTED = "a CSV, Parquet or npz file with a header row and one row per sample"
_NUMPY_STARTS = (b"PK\x03\x04", b"\x93NUM")
#: a text is judged by so much of its beginning
_ENOUGH = 1 << 18


def read_table(path: Path) -> RawColumns:
    """Read a table file, by its content; raises BadInputError when it is none."""
    require_regular(path, _EXPECTED)
    try:
        with path.open("rb") as file:
            start = file.read(4)
        if not start:
            raise BadInputError(str(path), "is empty", _EXPECTED)
        if start == b"PAR1" or path.suffix.lower() in (".parquet", ".pq"):
            return read_parquet(path)
        if start in _NUMPY_STARTS or path.suffix.lower() in (".npz", ".npy"):
            return read_numpy(path)
        return read_text(path, path.read_bytes())
    except OSError as error:
        reason = error.strerror.lower() if error.strerror else str(error)
        raise BadInputError(str(path), reason, _EXPECTED) from error


def is_text_table(path: Path) -> bool:
    """Whether a file of any ending is a table of text."""
    try:
        with path.open("rb") as file:
            return looks_like_rows(file.read(_ENOUGH), path)
    except OSError:
        return False
