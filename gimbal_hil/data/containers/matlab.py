"""MATLAB files up to version 7 (`scipy` reads them): vectors of one length are a group, with the time among them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.containers.contents import Contents, Floats, SampledGroup
from gimbal_hil.data.containers.naming import time_among

#: shorter vectors are gains and settings
_FEWEST = 10
_HDF5 = b"MATLAB 7.3"


def is_matlab(path: Path, start: bytes) -> bool:
    """By the text that such files begin with; version 4 has none and is known by its ending."""
    return start.startswith(b"MATLAB ") or path.suffix.lower() == ".mat"


def read_matlab(path: Path) -> Contents:
    """Vectors and matrices of numbers, structs as `a.b`; columns of a matrix as `q[0]`, `q[1]`."""

    from scipy.io import loadmat

    with path.open("rb") as file:
        if file.read(len(_HDF5)) == _HDF5:
            raise BadInputError(str(path), "is a MATLAB file of version 7.3 (HDF5)", "save(..., '-v7') in MATLAB")
    found = loadmat(path, simplify_cells=True)
    vectors = dict(_vectors({name: value for name, value in found.items() if not name.startswith("__")}, ""))
    groups = []
    for length in sorted({len(values) for values in vectors.values()}, reverse=True):
        columns = {name: values for name, values in vectors.items() if len(values) == length}
        time, unit = time_among(columns)
        time_s = None if time is None else (columns[time] - columns[time][0]) * unit
        own = {n: x for n, x in columns.items() if n != time}
        groups.append(SampledGroup(f"{length} rows", time_s, own, timed_by=time or ""))
    return Contents(path, "MATLAB file", tuple(group for group in groups if group.columns))


def _vectors(value: object, name: str) -> Iterator[tuple[str, Floats]]:
    if isinstance(value, dict):
        for key, below in value.items():
            yield from _vectors(below, f"{name}.{key}" if name else str(key))
    elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub":
        array = np.squeeze(value)
        if array.ndim == 1 and len(array) >= _FEWEST:
            yield name, array.astype(np.float64)
        elif array.ndim == 2 and max(array.shape) >= _FEWEST:
            rows = array if array.shape[0] >= array.shape[1] else array.T
            for place in range(rows.shape[1]):
                yield f"{name}[{place}]", rows[:, place].astype(np.float64)
