"""Messages and records with fields in fields, as columns of numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from gimbal_hil.data.containers.contents import Floats

#: more entries of one list are an image or a point cloud, no signals
_LONGEST_LIST = 256


def flat(value: object, name: str = "") -> Iterator[tuple[str, float]]:
    """Numbers in a record by dotted name: `a.b`, `position[0]`; entries of lists beside a list `name` of as many words
    are called by those words, as in a JointState: `position[shoulder]`.
    """
    if isinstance(value, bool | int | float | np.number):
        yield name, float(value)
    elif isinstance(value, Mapping):
        yield from _of_fields(value, name)
    elif isinstance(value, np.ndarray):
        yield from _of_list(value.ravel(), name, ())
    elif isinstance(value, list | tuple):
        yield from _of_list(value, name, ())
    elif hasattr(value, "__dataclass_fields__"):
        yield from _of_fields({key: getattr(value, key) for key in value.__dataclass_fields__}, name)


def columns_of(records: Sequence[object]) -> dict[str, Floats]:
    """Columns (n,) of n records; NaN where a record has no such number."""
    found: dict[str, Floats] = {}
    for row, record in enumerate(records):
        for name, value in flat(record):
            if name not in found:
                found[name] = np.full(len(records), np.nan)
            found[name][row] = value
    return found


def _of_fields(fields: Mapping[str, object], name: str) -> Iterator[tuple[str, float]]:
    words = fields.get("name", fields.get("joint_names"))
    called = tuple(words) if isinstance(words, list | tuple) and all(isinstance(word, str) for word in words) else ()
    for key, value in fields.items():
        below = f"{name}.{key}" if name else str(key)
        if isinstance(value, list | tuple | np.ndarray):
            yield from _of_list(value, below, called)
        else:
            yield from flat(value, below)


def _of_list(values: Any, name: str, called: tuple[str, ...]) -> Iterator[tuple[str, float]]:
    if len(values) > _LONGEST_LIST:
        return
    words = called if len(called) == len(values) else ()
    for place, value in enumerate(values):
        yield from flat(value, f"{name}[{words[place] if words else place}]")
