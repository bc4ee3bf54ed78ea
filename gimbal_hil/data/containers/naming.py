"""What columns of strangers are likely to be, from their names and units; which of them is the time."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from gimbal_hil.data.containers.contents import Floats

#: words for time -> seconds in one of it, None where only the step can say
_TIMES: Mapping[str, float | None] = {
    "time_s": 1.0,
    "time": None,
    "t": None,
    "timestamp": None,
    "tout": 1.0,
    "stamp": None,
    "t_s": 1.0,
    "seconds": 1.0,
    "zeit": None,
    "zeit_s": 1.0,
    "zeit_ms": 1e-3,
    "t_ms": 1e-3,
    "time_ms": 1e-3,
    "timestamp_ms": 1e-3,
    "t_us": 1e-6,
    "time_us": 1e-6,
    "timestamp_us": 1e-6,
    "t_ns": 1e-9,
    "time_ns": 1e-9,
    "timestamp_ns": 1e-9,
}
#: usual steps of a log, s
_USUAL_STEP_S = (1e-5, 0.2)


def time_among(columns: Mapping[str, Floats]) -> tuple[str | None, float]:
    """The column that is the time, and seconds in one of its units; None where none is.

    A name without a unit is in the largest unit in which the step is that of a usual log.
    """
    for name, values in columns.items():
        word = name.rpartition(".")[2].strip("%#:, ").lower().replace(",", "")
        bare, _, unit = re.sub(r"[\s\[\](){}]+", " ", word).strip().partition(" ")
        key = f"{bare}_{unit}" if unit and f"{bare}_{unit}" in _TIMES else bare
        if key not in _TIMES or len(values) < 2:
            continue
        step = float(np.median(np.diff(values)))
        if not step > 0.0:
            continue
        stated = _TIMES[key]
        if stated is not None:
            return name, stated
        low, high = _USUAL_STEP_S
        return name, next((unit for unit in (1.0, 1e-3, 1e-6, 1e-9) if low <= step * unit <= high), 1.0)
    return None, 1.0
