"""The torque of each axis from the column that a log has of it: held, sampled, or a current."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.signals.table import mean_over_rows


def with_torques(
    columns: dict[str, NDArray[np.float64]], axes: Sequence[str], constants: Mapping[str, float], notes: list[str]
) -> dict[str, NDArray[np.float64]]:
    """The columns with `torque` for every axis; a note says what it was made of. `constants` are N m/A (N/A)."""
    found = dict(columns)
    for axis in axes:
        if f"{axis}.torque" in columns:
            continue
        if f"{axis}.torque_sampled" in columns:
            found[f"{axis}.torque"] = mean_over_rows(columns[f"{axis}.torque_sampled"])
            notes.append(f"{axis}.torque is the mean of {axis}.torque_sampled over each row")
        else:
            found[f"{axis}.torque"] = constants[axis] * columns[f"{axis}.current"]
            notes.append(f"{axis}.torque is {axis}.current times the model's {constants[axis]:.6g} per ampere")
    return found
