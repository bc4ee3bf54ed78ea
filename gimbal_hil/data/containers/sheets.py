"""Tables that pandas owns: Excel workbooks (with `openpyxl`), and Parquet with lists in its cells, as LeRobot has."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.containers.contents import Contents, Floats, SampledGroup, missing
from gimbal_hil.data.containers.naming import time_among
from gimbal_hil.data.tables import text_of_lines

_FEWEST = 10
_EPISODE = "episode_index"


def is_workbook(path: Path, start: bytes) -> bool:
    """A zip with the parts of a workbook in it."""
    if not start.startswith(b"PK\x03\x04"):
        return False
    try:
        with ZipFile(path) as archive:
            return "[Content_Types].xml" in archive.namelist()
    except (BadZipFile, OSError):
        return path.suffix.lower() in (".xlsx", ".xlsm")


def read_workbook(path: Path) -> Contents:
    """Every sheet with numbers, read as a text of its cells is: wherever the header is, with units, marks and dates."""
    try:
        import openpyxl  # noqa: F401
        import pandas as pd
    except ImportError:
        raise missing(path, "an Excel workbook", "openpyxl", "xlsx") from None
    sheets = pd.read_excel(path, sheet_name=None, engine="openpyxl", header=None, dtype=object)
    groups, notes, refused = [], [], []
    for name, frame in sheets.items():
        if len(frame) < _FEWEST:
            continue
        lines = ["\t".join(map(_cell, row)) for row in frame.itertuples(index=False)]
        try:
            raw = text_of_lines(path, lines)
        except BadInputError as error:
            # a sheet of words beside the data
            refused.append(error)
            continue
        columns = {head: values for head, values in raw.values.items() if np.isfinite(values).mean() > 0.5}
        if columns:
            units = {head: raw.units[head] for head in columns if head in raw.units}
            groups.append(replace(_group(str(name), columns), units=units))
            notes += [note if len(sheets) == 1 else f"sheet {name}: {note}" for note in raw.notes]
    if refused and not groups:
        raise refused[0]
    return Contents(path, "Excel workbook", tuple(groups), tuple(notes))


def _cell(value: Any) -> str:
    """What a cell of a sheet would be in a text: nothing where it is empty, dates as they are written."""
    text = value.isoformat() if hasattr(value, "isoformat") else str(value)
    return "" if text in ("nan", "NaT", "None") else " ".join(text.split())


def has_lists(path: Path, start: bytes) -> bool:
    """A Parquet file with lists of numbers in its cells; others are tables as they stand."""
    if not start.startswith(b"PAR1"):
        return False
    try:
        import pyarrow as pa
        import pyarrow.parquet as parquet
    except ImportError:
        return False
    try:
        schema = parquet.read_schema(path)
    except (pa.ArrowException, OSError, ValueError):
        return False
    return any(_is_list(pa, one.type) for one in schema)


def read_lists(path: Path) -> Contents:
    """Lists as columns `observation.state[0]`, under the names of `meta/info.json` where a LeRobot data set has it.

    A file of several episodes is several groups, as each begins its clock anew.
    """
    import pyarrow as pa
    import pyarrow.parquet as parquet

    table = parquet.read_table(path)
    words = _feature_names(path)
    columns: dict[str, Floats] = {}
    for name in table.column_names:
        cells = table.column(name)
        if _is_list(pa, cells.type):
            columns |= _spread(name, cells.to_pylist(), words.get(name, ()))
        elif pa.types.is_integer(cells.type) or pa.types.is_floating(cells.type) or pa.types.is_boolean(cells.type):
            columns[name] = np.array([np.nan if one is None else float(one) for one in cells.to_pylist()])
    episodes = columns.get(_EPISODE)
    if episodes is None or len(np.unique(episodes)) == 1:
        return Contents(path, "Parquet file with lists", (_group("rows", columns),))
    groups = tuple(
        _group(f"episode {int(one)}", {name: values[episodes == one] for name, values in columns.items()})
        for one in np.unique(episodes)
    )
    return Contents(path, "Parquet file with lists", groups)


def _is_list(pa: Any, kind: Any) -> bool:
    is_one = pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind) or pa.types.is_large_list(kind)
    return is_one and (pa.types.is_floating(kind.value_type) or pa.types.is_integer(kind.value_type))


def _spread(name: str, rows: list[Any], words: tuple[str, ...]) -> dict[str, Floats]:
    width = max((len(row) for row in rows if row is not None), default=0)
    values = np.full((len(rows), width), np.nan)
    for place, row in enumerate(rows):
        if row is not None:
            values[place, : len(row)] = row
    called = words if len(words) == width else tuple(map(str, range(width)))
    return {f"{name}[{word}]": values[:, place] for place, word in enumerate(called)}


def _feature_names(path: Path) -> dict[str, tuple[str, ...]]:
    """What a data set calls the entries of its lists: `meta/info.json` in a folder above the file."""
    for folder in path.resolve().parents[:4]:
        info = folder / "meta" / "info.json"
        if info.exists():
            try:
                features = json.loads(info.read_text(encoding="utf-8")).get("features", {})
            except (OSError, ValueError, AttributeError):
                return {}
            return {name: _words(one) for name, one in features.items() if isinstance(one, dict)}
    return {}


def _words(feature: dict[str, object]) -> tuple[str, ...]:
    names = feature.get("names")
    if isinstance(names, dict):
        names = next(iter(names.values()), None)
    return tuple(map(str, names)) if isinstance(names, list) else ()


def _group(name: str, columns: dict[str, Floats]) -> SampledGroup:
    time, unit = time_among(columns)
    time_s = None if time is None else (columns[time] - columns[time][0]) * unit
    own = {head: values for head, values in columns.items() if head != time}
    return SampledGroup(name, time_s, own, timed_by=time or "")
