"""One number of an effect: name, unit, bounds, and the value at which it does nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    With every parameter of a hook effect neutral, the plant's bits are those without it. A number effect that is absent
    leaves the model's own number; its `neutral` is only what stands in an entry whose file leaves the parameter out,
    and is not put in force.
    """

    name: str
    unit: str
    low: float
    high: float
    neutral: float
    text: str
    #: unit on a linear axis where it differs from the rotary one
    linear_unit: str | None = None
    #: the parameter is an angle that wraps at 2 pi
    periodic: bool = False
    #: number effects: dotted path of the number in an axis (or body) of the model file, e.g. "friction.viscous"
    path: str | None = None
    #: an angle of which half a turn is the same as this parameter with the other sign
    half_turn_of: str | None = None

    def check(self, value: float) -> bool:
        """Whether a value may be used: finite and inside the bounds, or neutral."""
        return math.isfinite(value) and (self.low <= value <= self.high or value == self.neutral)
