"""What a person may choose of a sequence on the command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.host import AXIS_NAMES, AxisCommand

if TYPE_CHECKING:
    from sim_backend.model import AntennaModel

Value = TypeVar("Value")


def breakaway_torques(model: AntennaModel) -> dict[str, float]:
    """Break-away torque by axis as a model has it, N m: what the torques of presliding are scaled by."""
    return {axis: model.number(axis, "friction.breakaway") for axis in model.axes}


@dataclass(frozen=True)
class SequenceOptions:
    """Choices that all sequences understand; each takes what concerns it."""

    rate_hz: float
    #: those that are asked for; all where none is named
    axes: tuple[str, ...] = ()
    #: a short variant for CI and demonstrations instead of the whole sequence
    short: bool = False
    #: keep one tick in so many in the log; None leaves it to the sequence
    every: int | None = None
    #: break-away torque as far as known, N m, by axis; presliding needs it
    breakaway_nm: Mapping[str, float] = field(default_factory=dict)
    #: how the base moves where the antenna is virtual: `table/case` of the thesis (3.1/1 to 3.2/4), or a CSV file with
    #: a recorded motion
    base: str | None = None
    #: names of the antenna's axes, the carrying one first
    names: tuple[str, str] = AXIS_NAMES

    def __post_init__(self) -> None:
        object.__setattr__(self, "axes", self.axes or self.names)

    def by_axis(self, pair: tuple[Value, Value]) -> dict[str, Value]:
        """What is given for the carrying axis and for the carried one, by their names."""
        return dict(zip(self.names, pair, strict=True))

    def other(self, axis: str) -> str:
        """The other axis."""
        return self.names[1 - self.names.index(axis)]

    def on_axis(self, axis: str, command: AxisCommand, other: AxisCommand) -> tuple[AxisCommand, AxisCommand]:
        """Commands of both axes: one for the axis under test, one for the other."""
        return (command, other) if axis == self.names[0] else (other, command)

    def breakaway_of(self, axis: str) -> float:
        """Break-away torque of an axis, N m; BadInputError where nobody has said it."""
        if self.breakaway_nm.get(axis, 0.0) <= 0.0:
            raise BadInputError(
                "--breakaway",
                f"no break-away torque of {axis} is known",
                f"{axis}=TORQUE in N m, or a model that has it",
            )
        return self.breakaway_nm[axis]
