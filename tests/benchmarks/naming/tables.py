"""Tables of a case as text, and the motion in them: all that an adapter needs, with numpy and scipy alone."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from scipy.signal import butter, sosfiltfilt

Array = np.ndarray
Columns = dict[str, Array]
#: in which torques are compared
BAND_HZ = 30.0
#: in which motion is taken from the encoder: laws see reversals sharper than they are compared
MOTION_HZ = 60.0


def smooth(values: Array, step_s: float, band_hz: float = BAND_HZ) -> Array:
    """Low-passed without delay, along time."""
    return np.asarray(sosfiltfilt(butter(4, band_hz, fs=1.0 / step_s, output="sos"), values, axis=0))


def motion_of(columns: dict[str, Array], axes: tuple[str, ...], step_s: float) -> tuple[Array, Array, Array]:
    """Joint position, rate and acceleration, (n, axes) each."""
    position = smooth(np.stack([columns[f"{axis}.position"] for axis in axes], axis=1), step_s, MOTION_HZ)
    rate = np.gradient(position, step_s, axis=0)
    return position, rate, np.gradient(rate, step_s, axis=0)


def write_csv(path: Path, columns: Columns) -> None:
    """A header row, and a row for each sample."""
    table = np.stack([np.asarray(column, dtype=float) for column in columns.values()], axis=1)
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.10g")


def read_csv(path: Path) -> Columns:
    """The reverse."""
    with path.open(newline="") as file:
        header = next(csv.reader(file))
    table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    return {name: table[:, k] for k, name in enumerate(header)}
