"""A log whose columns somebody smoothed before they were saved: which of them, how, and what a reader does about it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from gimbal_hil.knowledge.estimation import Smoothing
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.estimate import DataWarning
from gimbal_hil.knowledge.identification.least_squares import Matrix


class SmoothedColumn(Enum):
    """What was smoothed."""

    TORQUE = "the torque column seems"
    POSITION = "the position column seems"
    BOTH = "torque and position seem"


@dataclass(frozen=True)
class SmoothedLog:
    """Columns that went through a smoothing without delay."""

    which: SmoothedColumn
    smoothing: Smoothing

    def times(self, factor: float) -> SmoothedLog:
        """The same at a cut-off so many times as high."""
        return replace(self, smoothing=replace(self.smoothing, half_hz=factor * self.smoothing.half_hz))

    def sharp(self, position: Vector, step_s: float) -> Vector:
        """The position (n,) as it was before."""
        if self.which is SmoothedColumn.TORQUE:
            return position
        return self.smoothing.undone(position, step_s)

    def as_torque(self, values: Matrix, step_s: float) -> Matrix:
        """What explains the torque, (n,) or (n, k), as the torque was."""
        return values if self.which is SmoothedColumn.POSITION else self.smoothing.of(values, step_s)

    @property
    def text(self) -> str:
        """What a person reads."""
        return (
            f"{self.which.value} to be smoothed, by {self.smoothing.shape.value} (half is left at about "
            f"{self.smoothing.half_hz:.2g} Hz)"
        )

    def finding(self, axis: str) -> DataWarning:
        """What a reader must know of it."""
        text = f"{self.text}: the numbers and their intervals allow for it; a log that was not smoothed says more"
        return DataWarning("smoothed", text, axis)

    def as_record(self) -> dict[str, object]:
        """Plain types for `identification.json`."""
        return {
            "columns": self.which.name.lower(),
            "shape": self.smoothing.shape.name.lower(),
            "half_hz": self.smoothing.half_hz,
        }
