"""The signals table: measured data from anywhere, one row per sample at a constant rate
(docs/reference/signals-table.md).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.tables import FileColumn

TIME = "time_s"
REPEAT = "repeat"
#: share of the period by which the times of an even table may scatter
JITTER_LIMIT = 0.05
#: what an axis may carry, as in `outer.torque`
REQUIRED_SIGNALS = ("torque", "position")
OPTIONAL_SIGNALS = (
    "torque_measured",
    "rate",
    "position_ref",
    "rate_ref",
    "temperature",
    "current",
    "torque_known",
    "torque_sampled",
)
SIGNALS = (*REQUIRED_SIGNALS, *OPTIONAL_SIGNALS)
#: columns that say what torque was in force; the first that is there counts
TORQUES = ("torque", "torque_sampled", "current")
#: commanded values: the one in row k is in force from t_k until the next
HELD_SIGNALS = ("torque", "current", "position_ref", "rate_ref")
BASE_ANGLES = ("base.roll", "base.pitch", "base.yaw")
BASE_RATES = ("base.p", "base.q", "base.r")
BASE_ACCELERATIONS = ("base.ax", "base.ay", "base.az")
BASE_COLUMNS = (*BASE_ANGLES, *BASE_RATES, *BASE_ACCELERATIONS)


@dataclass(frozen=True)
class SignalsTable:
    """Columns of shape (n,), float64, read-only. Units are SI for the axis' kind.

    `columns` is keyed as in the file (`outer.position`, `base.roll`), without time and `repeat`; optional columns that
    were not measured are absent. Where the drive was logged in amperes, `axis.torque` is what they make with the
    model's torque constant. `lines` (n,) are those of a file of text in which the rows stand, or the last one before,
    `origins` the columns of the file that were read from one. `notes` say in words what a reader of results should
    know: columns left out, rows dropped or made up.
    """

    axes: tuple[str, ...]
    period_s: float
    time_s: NDArray[np.float64]
    columns: Mapping[str, NDArray[np.float64]]
    repeat: NDArray[np.int64] | None = None
    source: str = ""
    notes: tuple[str, ...] = ()
    lines: NDArray[np.int64] | None = None
    origins: Mapping[str, FileColumn] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        axes: Sequence[str],
        time_s: NDArray[np.float64],
        columns: Mapping[str, NDArray[np.float64]],
        repeat: NDArray[np.int64] | None = None,
        source: str = "",
        notes: Sequence[str] = (),
    ) -> SignalsTable:
        """A table of data that is known to be sound; the period is the mean one. Raises ValueError when shapes
        differ.
        """
        names = column_names(axes)
        time_s = _frozen(time_s)
        if any(
            np.shape(values) != time_s.shape for values in (*columns.values(), *(() if repeat is None else (repeat,)))
        ):
            raise ValueError("all columns of a signals table have one value a row")
        if len(time_s) < 2:
            raise ValueError("a signals table has at least two rows")
        ordered = {name: _frozen(columns[name]) for name in names if name in columns}
        laps = None if repeat is None else np.array(repeat, np.int64)
        if laps is not None:
            laps.setflags(write=False)
        period_s = float(time_s[-1] - time_s[0]) / (len(time_s) - 1)
        return cls(tuple(axes), period_s, time_s, MappingProxyType(ordered), laps, source, tuple(notes))

    def __len__(self) -> int:
        return len(self.time_s)

    def signal(self, axis: str, name: str) -> NDArray[np.float64] | None:
        """One signal of one axis, shape (n,); None when it was not measured."""
        return self.columns.get(f"{axis}.{name}")

    def torque(self, axis: str) -> NDArray[np.float64]:
        """What the model has to explain of the commanded torque or force, (n,): the command without its known part.

        The value in row k acts over [t_k, t_k+1).
        """
        known = self.signal(axis, "torque_known")
        return self.commanded(axis) if known is None else self.commanded(axis) - mean_over_rows(known)

    def commanded(self, axis: str) -> NDArray[np.float64]:
        """Commanded torque or force as logged, known part included; the value in row k acts over [t_k, t_k+1)."""
        return self.columns[f"{axis}.torque"]

    def position(self, axis: str) -> NDArray[np.float64]:
        """Joint position at t_k."""
        return self.columns[f"{axis}.position"]

    def base(self, name: str) -> NDArray[np.float64] | None:
        """One of roll, pitch, yaw (rad), p, q, r (rad/s), ax, ay, az (m/s^2); None when it was not measured (level and
        fixed).
        """
        return self.columns.get(f"base.{name}")

    def rows(self, start: int, stop: int) -> SignalsTable:
        """The rows from `start` up to `stop`."""
        part = slice(start, stop)
        columns = {name: values[part] for name, values in self.columns.items()}
        laps = None if self.repeat is None else self.repeat[part]
        some = SignalsTable.of(self.axes, self.time_s[part], columns, laps, self.source, self.notes)
        return replace(some, lines=None if self.lines is None else self.lines[part], origins=self.origins)

    def but(self, columns: Mapping[str, NDArray[np.float64]], notes: Sequence[str] = ()) -> SignalsTable:
        """The same with some columns in place of its own, and further notes."""
        changed = {name: _frozen(values) for name, values in columns.items()}
        return replace(self, columns=MappingProxyType({**self.columns, **changed}), notes=(*self.notes, *notes))


def column_names(axes: Sequence[str]) -> tuple[str, ...]:
    """Every column that a table of these axes may have besides time and `repeat`, in the order of a written file."""
    return (*(f"{axis}.{signal}" for axis in axes for signal in SIGNALS), *BASE_COLUMNS)


def mean_over_rows(sampled: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean over [t_k, t_k+1) of a signal sampled at t_k, shape kept; the last row keeps its sample."""
    return np.append(0.5 * (sampled[1:] + sampled[:-1]), sampled[-1:])


def _frozen(values: NDArray[np.float64]) -> NDArray[np.float64]:
    array = np.array(values, np.float64)
    array.setflags(write=False)
    return array
