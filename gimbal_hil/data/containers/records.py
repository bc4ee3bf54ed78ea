"""JSON: one record a line, or one document with a list of records, or with lists of one length in it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.containers.contents import Contents, Floats, SampledGroup
from gimbal_hil.data.containers.flattening import columns_of
from gimbal_hil.data.containers.naming import time_among
from gimbal_hil.data.tables import numbers_in

_FEWEST = 10
#: share of words that have to be numbers
_MOST_NUMBERS = 0.5
_EXPECTED = "one record a line, or a list of records, or lists of one length"


def is_json(path: Path, start: bytes) -> bool:
    """Whether it begins as an object or a list of objects does."""
    bare = start.lstrip(b"\xef\xbb\xbf \t\r\n")
    return bare.startswith(b"{") or (bare.startswith(b"[") and bare[1:].lstrip(b" \t\r\n")[:1] in (b"{", b"["))


def read_json(path: Path) -> Contents:
    """The numbers of all records. A last line that was cut is left out and told."""
    text = path.read_text(encoding="utf-8-sig")
    notes: list[str] = []
    found = dict(_lists(_document(path, text, notes)))
    if not found:
        raise BadInputError(str(path), "is JSON without a list of records in it", _EXPECTED)
    groups = []
    for name, columns in found.items():
        time, unit = time_among(columns)
        time_s = None if time is None else (columns[time] - columns[time][0]) * unit
        own = {n: x for n, x in columns.items() if n != time}
        groups.append(SampledGroup(name or "records", time_s, own, timed_by=time or ""))
    return Contents(path, "JSON file", tuple(groups), tuple(notes))


def _document(path: Path, text: str, notes: list[str]) -> object:
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
        records = []
        for number, line in lines:
            try:
                records.append(json.loads(line))
            except json.JSONDecodeError as wrong:
                if number == lines[-1][0] and len(records) >= _FEWEST:
                    notes.append(f"line {number}, the last one, is cut and was left out")
                    break
                where = f"{path}: line {number}" if records else f"{path}: line {error.lineno}"
                raise BadInputError(where, f"is no JSON: {wrong.msg if records else error.msg}", _EXPECTED) from wrong
        return records


def _lists(value: object, name: str = "") -> Iterator[tuple[str, dict[str, Floats]]]:
    """Columns of every list of records in a document, by where it stands."""
    if isinstance(value, list):
        if len(value) >= _FEWEST and all(isinstance(one, dict) for one in value):
            columns = _of_words(value) | columns_of(value)
            prefix = f"{name}." if name else ""
            if columns:
                yield name, {f"{prefix}{key}": values for key, values in columns.items()}
    elif isinstance(value, dict):
        vectors = {key: one for key, one in value.items() if _is_vector(one)}
        for length in sorted({len(one) for one in vectors.values()}, reverse=True):
            rows = {key: one for key, one in vectors.items() if len(one) == length}
            records = [dict(zip(rows, row, strict=True)) for row in zip(*rows.values(), strict=True)]
            yield name or f"{length} rows", columns_of(records)
        for key, one in value.items():
            if key not in vectors:
                yield from _lists(one, f"{name}.{key}" if name else str(key))


def _of_words(records: list[dict[str, object]]) -> dict[str, Floats]:
    """Columns whose numbers or times were written as words."""
    found = {}
    for key in (key for key, value in records[0].items() if isinstance(value, str)):
        cells = [value if isinstance(value := one.get(key), str) else None for one in records]
        values = numbers_in(cells)
        if np.isfinite(values).mean() > _MOST_NUMBERS:
            found[key] = values
    return found


def _is_vector(value: object) -> bool:
    return isinstance(value, list) and len(value) >= _FEWEST and isinstance(value[0], int | float)
