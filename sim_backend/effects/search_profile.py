"""How an effect is searched for: which numbers move, on what scale and within what bounds, and from where.

An effect's file answers a `SearchProfile` for an axis; the search itself knows no effect by name.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

Vector = tuple[float, ...]
#: order of a ripple whose coordinate is zero
NEUTRAL_ORDER = 1.0


class Move(Enum):
    """How a coordinate x moves a number."""

    #: by x times the knob's size
    ADD = 0
    #: by the factor exp(x)
    FACTOR = 1
    #: to the knob's size times exp(x), wherever it was
    LEVEL = 2


@dataclass(frozen=True)
class Knob:
    """One coordinate of a hypothesis: x moves the named parameters of the effect, and the number `along` of the model
    with them.
    """

    parameters: tuple[str, ...]
    move: Move = Move.ADD
    #: ADD: change per unit of x; LEVEL: the number at x = 0
    size: float = 1.0
    low: float = -math.inf
    high: float = math.inf
    #: path of a number of the model that is not the effect's own and moves with it, e.g. "body.own_inertia"
    along: str | None = None
    #: the data need not decide it for the name to stand: being at its bound says nothing about the cause
    nuisance: bool = False
    #: but for its upper bound, beyond which the effect is no longer what its name says
    named_up_to_high: bool = False
    #: ADD: the coordinate at which the number does nothing; a model that states the effect begins elsewhere
    nothing: float = 0.0

    @property
    def telling_ends(self) -> tuple[float, ...]:
        """Bounds at which the cause is in doubt."""
        if self.nuisance:
            return (self.high,) if self.named_up_to_high else ()
        return self.low, self.high

    def moved(self, value: float, x: float) -> float:
        """A number that stood at `value`, at coordinate x."""
        if self.move is Move.ADD:
            return value + self.size * x
        return (value if self.move is Move.FACTOR else self.size) * math.exp(x)

    def beginning_at(self, base: float, neutral: float) -> Knob:
        """The same knob, ADD, of a number that stands at `base` in place of neutral: bounds go on about neutral."""
        nothing = (neutral - base) / self.size
        return replace(self, low=self.low + nothing, high=self.high + nothing, nothing=nothing)

    def within(self, low: float, high: float, base: float) -> Knob:
        """The same knob, held where a number that stands at `base` stays between `low` and `high`."""
        if self.move is Move.ADD:
            ends = ((low - base) / self.size, (high - base) / self.size)
        else:
            start = base if self.move is Move.FACTOR else self.size
            ends = (
                (math.log(low / start) if low > 0.0 else -math.inf, math.log(high / start))
                if start > 0.0
                else (-math.inf, math.inf)
            )
        return replace(self, low=max(self.low, ends[0]), high=min(self.high, ends[1]))


class Reading(Enum):
    """How least-squares coefficients of a start's probes become coordinates."""

    #: base + sum of coefficient times (probe - base)
    LINEAR = 0
    #: amplitude and phase of a ripple from its responses at phase 0 and a quarter turn: first and last coordinate
    POLAR = 1
    #: stiffness and rest position from a spring's pull and its constant part
    SPRING = 2


@dataclass(frozen=True)
class Start:
    """A point from which a profile is tried: the response to `probes` (coordinates) spans what it can do near there."""

    probes: tuple[Vector, ...]
    base: Vector
    reading: Reading = Reading.LINEAR

    def coordinates(self, c: np.ndarray) -> Vector:
        """Where the coefficients of the probes point."""
        if self.reading is Reading.POLAR:
            return (float(np.hypot(c[0], c[1])) * self.probes[0][0], *self.base[1:-1], float(math.atan2(c[1], c[0])))
        if self.reading is Reading.SPRING:
            stiffness = float(c[0] + c[1])
            return stiffness, float(np.clip(c[1] / stiffness, -20.0, 20.0)) if abs(stiffness) > 1e-9 else 0.0
        move = sum(float(k) * (np.array(probe) - np.array(self.base)) for k, probe in zip(c, self.probes, strict=True))
        return tuple(float(x) for x in np.array(self.base) + move)


class Ripple(Enum):
    """What a ripple over position is a ripple of; its orders are read from the residual, its knobs are amplitude, order
    and phase.
    """

    TORQUE = 0
    #: times the sign of the rate
    FRICTION = 1


@dataclass(frozen=True)
class SearchProfile:
    """Knobs of an effect on an axis, and the starts from which it is tried; a ripple's starts are read from the
    residual.
    """

    knobs: tuple[Knob, ...]
    starts: tuple[Start, ...]
    ripple: Ripple | None = None


def line(probe: float = 1.0) -> Start:
    """A start from neutral along the only knob."""
    return Start(((probe,),), (0.0,))


def plane(dimensions: int, probe: float = 1.0) -> Start:
    """A start from neutral along every knob on its own."""
    return Start(
        tuple(tuple(probe if i == j else 0.0 for j in range(dimensions)) for i in range(dimensions)),
        (0.0,) * dimensions,
    )


def point(*at: float) -> Start:
    """A start where only the finite change itself is tried, as it is."""
    return Start((at,), at)


def one_knob(
    parameter: str, size: float, low: float = -math.inf, high: float = math.inf, probes: Sequence[float] = (1.0,)
) -> SearchProfile:
    """One number that moves by sizes, tried from neutral."""
    return SearchProfile((Knob((parameter,), size=size, low=low, high=high),), tuple(line(probe) for probe in probes))


def ripple_profile(amplitude: str, size: float, over: Ripple) -> SearchProfile:
    """A ripple over position: amplitude, order and phase; the order's coordinate counts from NEUTRAL_ORDER."""
    return SearchProfile((Knob((amplitude,), size=size), Knob(("order",)), Knob(("phase",))), (), ripple=over)


def ripple_start(order: float, probe: float = 1.0) -> Start:
    """A ripple of one order with free amplitude and phase."""
    x = order - NEUTRAL_ORDER
    return Start(((probe, x, 0.0), (probe, x, 0.5 * math.pi)), (0.0, x, 0.0), Reading.POLAR)
