"""What a person may choose of a sequence on the command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from firmware_protocol.errors import BadInputError

if TYPE_CHECKING:
    from sim_backend.model import AntennaModel


def breakaway_torques(model: AntennaModel) -> dict[str, float]:
    """Break-away torque by axis as a model has it, N m: what the torques of presliding are scaled by."""
    return {axis: model.number(axis, "friction.breakaway") for axis in model.axes}


@dataclass(frozen=True)
class SequenceOptions:
    """Choices that all sequences understand; each takes what concerns it."""

    rate_hz: float
    axes: tuple[str, ...] = ("outer", "inner")
    #: a short variant for CI and demonstrations instead of the whole sequence
    short: bool = False
    #: keep one tick in so many in the log; None leaves it to the sequence
    every: int | None = None
    #: break-away torque as far as known, N m, by axis; presliding needs it
    breakaway_nm: Mapping[str, float] = field(default_factory=dict)
    #: how the base moves where the antenna is virtual: `table/case` of the thesis (3.1/1 to 3.2/4), or a CSV file with a recorded motion
    base: str | None = None

    def breakaway_of(self, axis: str) -> float:
        """Break-away torque of an axis, N m; BadInputError where nobody has said it."""
        if self.breakaway_nm.get(axis, 0.0) <= 0.0:
            raise BadInputError("--breakaway", f"no break-away torque of {axis} is known", f"{axis}=TORQUE in N m, or a model that has it")
        return self.breakaway_nm[axis]
