"""A rig on disk: a model file and its logs, written the way a stranger's own tools would write them."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml


@dataclass(frozen=True)
class Rig:
    """Paths of a model file and of the logs by name."""

    model: Path
    logs: Mapping[str, Path]


def measured(value: float, unit: str, uncertainty: str) -> dict[str, Any]:
    """A number of a model file as somebody who measured it would write it."""
    return {"value": value, "unit": unit, "source": "measured", "uncertainty": uncertainty}


def write_log(path: Path, columns: Mapping[str, np.ndarray]) -> Path:
    """A CSV file with a header row and one row a sample."""
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(columns)
        rows.writerows(zip(*(np.asarray(values, float).tolist() for values in columns.values()), strict=True))
    return path


def write_model(
    path: Path, document: Mapping[str, Any], scaled: Mapping[str, float] | None = None, of: str | None = None
) -> Path:
    """A model file; `scaled` multiplies numbers of an axis, of its first one if none is said (path -> factor), to plant
    an error.
    """
    axis = document["axes"][of or next(iter(document["axes"]))]
    for place, factor in (scaled or {}).items():
        *parents, key = place.split(".")
        section = axis
        for parent in parents:
            section = section[parent]
        number = section[key]
        section[key] = {**number, "value": factor * number["value"]} if isinstance(number, dict) else factor * number
    path.write_text(yaml.safe_dump(dict(document), sort_keys=False, allow_unicode=True))
    return path
