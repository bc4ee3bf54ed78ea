"""A run's signals for MATLAB and Octave: a struct an axis, so that a signal is spelled as everywhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable, unit_of

_LONGEST_NAME = 63


def export_mat(table: SignalsTable, path: Path) -> int:
    """`time_s`, `azimuth.position` ..., and `units.azimuth.position` ...; answers the number of signals."""
    from scipy.io import savemat

    content: dict[str, Any] = {"time_s": table.time_s[:, None]}
    units: dict[str, Any] = {"time_s": "s"}
    for column, values in table.columns.items():
        group, _, name = column.rpartition(".")
        if not (group.isidentifier() and group.isascii()) or len(group) > _LONGEST_NAME:
            raise BadInputError(
                f"--format mat: axis {group!r}", "is no name that MATLAB takes", "letters, digits and underscores"
            )
        content.setdefault(group, {})[name] = values[:, None]
        units.setdefault(group, {})[name] = unit_of(column)
    if table.repeat is not None:
        content["repeat"] = table.repeat[:, None]
    with path.open("wb") as file:
        savemat(file, content | {"units": units}, long_field_names=True, do_compression=True)
    return len(table.columns)
