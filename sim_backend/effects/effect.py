"""What an effect is: a name, where it enters the plant, its parameters, its law, its source, and the run that excites it.

Two kinds. A **hook** effect adds physics: a compiled law at one of the places below. A **number** effect is a number that
the model already has being wrong; its law is the model's own, and its parameters name slots of the plant's parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any


class Hook(IntEnum):
    """The places where an effect can enter, in the order of a plant step.

    Every law begins with (P, o, X, s): parameter i is P[o + i], state i is X[s + i].
    """

    #: (P, o, X, s, K, u, q, v) -> torque after the actuator's command changed; u is the command held over this step
    COMMAND = 0
    #: (P, o, X, s, q, v, torque, temperature, ts, tc, sigma2) -> (ts, tc, sigma2) in force during this step
    FRICTION = 1
    #: (P, o, X, s, q, v, h) -> torque added at the joint
    TORQUE = 2
    #: (P, o, X, s, torque, own_inertia, inertial_acceleration_bias) -> (torque on the joint side, inertia taken off the joint)
    STRUCTURE = 3
    #: (P, o, X, s, position) -> added to the encoder's position
    ENCODER = 4
    #: (P, o, X, s, axis, wx, wy, wz) -> added to the gyro's rate; w are the body's inertial rates
    GYRO = 5


class Domain(IntEnum):
    """What part of the antenna an effect belongs to."""

    FRICTION = 0
    MASS = 1
    DRIVE = 2
    STRUCTURE = 3
    TIMING = 4
    SENSOR = 5


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    With every parameter of a hook effect neutral, the plant's bits are those without it. A number effect that is absent leaves
    the model's own number; its `neutral` is only what stands in an entry whose file leaves the parameter out, and is not put in force.
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

    def check(self, value: float) -> bool:
        """Whether a value may be used: finite and inside the bounds, or neutral."""
        return math.isfinite(value) and (self.low <= value <= self.high or value == self.neutral)


@dataclass(frozen=True)
class Effect:
    """One entry of the catalogue; the file that defines it holds its physics."""

    name: str
    domain: Domain
    parameters: tuple[Parameter, ...]
    text: str
    equation: str
    source: str
    #: the run that excites it, and what must move for it to be testable
    excited_by: str
    hook: Hook | None = None
    law: Callable[..., Any] | None = None
    #: STRUCTURE only: (P, o, X, s, torque, own_inertia, inertial_acceleration, h) advances the hidden state after the joint is solved
    advance: Callable[..., Any] | None = None
    states: int = 0
    #: order among effects of the same hook
    rank: int = 0
    #: axes on which it makes sense: "any", or only on a rotary one
    rotary_only: bool = False
    two_axis_only: bool = False

    @property
    def is_number(self) -> bool:
        """Whether the model already has this effect's numbers."""
        return self.hook is None
