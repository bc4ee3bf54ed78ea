"""What an effect is: a name, where it enters the plant, its parameters, its law, its source, and the run that excites
it.

Two kinds. A **hook** effect adds physics: a compiled law at one of the places below. A **number** effect is a number
that the model already has being wrong; its law is the model's own, and its parameters name slots of the plant's
parameters.

An effect also says how it is looked for in data: what it acts through, what data must have for it to show, which run
tells it from what looks alike, and how its numbers are searched. Whoever searches asks the effect and knows none by
name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from typing import Any

from sim_backend.effects.axis_scale import AxisScale, Need
from sim_backend.effects.default_search import default_profile, strengths
from sim_backend.effects.parameter import Parameter
from sim_backend.effects.search_profile import Knob, Move, SearchProfile
from sim_backend.effects.separating_runs import SeparatingRun


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
    #: (P, o, X, s, torque, own_inertia, inertial_acceleration_bias) -> (torque on the joint side, inertia taken off the
    #: joint)
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


class Variable(Enum):
    """What a cause acts through: with everything of it taken out, what is left must no longer depend on that."""

    #: which way it moves, whatever else: of motion that goes one way, place by place, position and torque say no more
    DIRECTION = "direction"
    POSITION = "position"
    #: its direction included
    RATE = "rate"
    ACCELERATION = "acceleration"
    #: commanded or applied
    TORQUE = "torque"
    TEMPERATURE = "temperature"
    #: a constant, which may drift
    TIME = "time"
    #: rates and angular accelerations of the base
    BASE_MOTION = "base motion"
    #: what the other axis is commanded
    OTHER_TORQUE = "torque of the other axis"
    #: which way gravity points, seen from the base
    ATTITUDE = "attitude"
    #: the same a moment ago: the effect has memory
    PAST = "past"


#: what a law at each place is given, for an effect that does not say what it acts through
_GIVEN = {
    None: frozenset({Variable.TIME}),
    Hook.COMMAND: frozenset({Variable.TORQUE, Variable.POSITION, Variable.RATE}),
    Hook.FRICTION: frozenset({Variable.POSITION, Variable.RATE, Variable.TORQUE, Variable.TEMPERATURE}),
    Hook.TORQUE: frozenset({Variable.POSITION, Variable.RATE}),
    Hook.STRUCTURE: frozenset({Variable.TORQUE, Variable.ACCELERATION}),
    Hook.ENCODER: frozenset({Variable.POSITION, Variable.RATE, Variable.ACCELERATION}),
    Hook.GYRO: frozenset({Variable.RATE, Variable.BASE_MOTION}),
}


@dataclass(frozen=True)
class FittedNumber:
    """A fitted parameter: value, interval, unit, and the model's own value where it has one."""

    value: float
    low: float
    high: float
    unit: str
    nominal: float | None


@dataclass(frozen=True)
class RateForm:
    """A law over the rate that an effect may stand for: its name, and the power of abs(v) in it."""

    text: str
    power: int


@dataclass(frozen=True)
class PlainerEffect:
    """An effect with fewer numbers that this one contains, where these parameters lie between these values."""

    name: str
    where: tuple[tuple[str, float, float], ...] = ()

    def holds(self, values: Mapping[str, float]) -> bool:
        """Whether it is contained at these parameters."""
        return all(low <= values[name] <= high for name, low, high in self.where)


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
    #: STRUCTURE only: (P, o, X, s, torque, own_inertia, inertial_acceleration, h) advances the hidden state after the
    #: joint is solved
    advance: Callable[..., Any] | None = None
    states: int = 0
    #: order among effects of the same hook
    rank: int = 0
    #: axes on which it makes sense: "any", or only on a rotary one
    rotary_only: bool = False
    two_axis_only: bool = False
    #: how it is searched on an axis, None where this data cannot show it; left out: from bounds and units of the
    #: parameters
    search: Callable[[AxisScale], SearchProfile | None] | None = None
    #: left out: what its place in the plant step is given
    acts_through: frozenset[Variable] = frozenset()
    needs: Need = Need.NOTHING
    #: why data that has all it needs may still have no trace of it
    unseen: str = "this data does not excite it"
    #: runs that tell it from what looks alike: every effect that names the same run
    separated_by: tuple[SeparatingRun, ...] = ()
    #: the effect that no run with commanded torque alone tells from it: either name is right
    same_by_command: str | None = None
    plainer: PlainerEffect | None = None
    #: laws over the rate that one log may not tell apart
    forms: tuple[RateForm, ...] = ()
    #: what fitted numbers say against the law that they belong to; empty where nothing does
    objection: Callable[[Mapping[str, FittedNumber]], str] | None = None
    #: (parameters, break-away torque, travel) -> largest torque that it adds from one place to another
    torque_over_position: Callable[[Mapping[str, float], float, float], float] | None = None
    #: steps into which a millisecond is divided where it is followed along measured motion: for states that move faster
    fine_steps: int = 1
    #: followed along measured motion, it swings on the encoder's own error
    rings_on_encoder_noise: bool = False
    #: what people call the number where they ask how well it is known; empty for what is not asked about
    asked_as: str = ""
    #: a model is judged only by data that would show an error of a factor of two in it
    must_show: bool = False

    def __post_init__(self) -> None:
        if not self.acts_through:
            object.__setattr__(
                self, "acts_through", _GIVEN[self.hook] | ({Variable.PAST} if self.states else frozenset())
            )

    @property
    def is_number(self) -> bool:
        """Whether the model already has this effect's numbers."""
        return self.hook is None

    @property
    def is_before_the_joint(self) -> bool:
        """Whether it stands between the command and the joint: in the drive or in the structure."""
        in_the_drive = any((parameter.path or "").startswith("actuator.") for parameter in self.parameters)
        return self.hook in (Hook.COMMAND, Hook.STRUCTURE) or in_the_drive

    @property
    def strengths(self) -> tuple[Parameter, ...]:
        """The parameters that carry what it does: with all of them neutral (a number as the model has it) there is
        nothing.
        """
        return tuple(strengths(self.parameters))

    @property
    def moves_in_place(self) -> bool:
        """Whether a model that states it needs no second instance: with strengths alone, nothing about it differs but
        how much of it there is.

        Two instances are not their sum: of (1 + a sign v)(1 + b sign v) the level is 1 + ab, which another cause would
        have to make up for.
        """
        return self.hook is not None and 0 < len(self.strengths) == len(self.parameters)

    def profile(self, scale: AxisScale) -> SearchProfile | None:
        """How it is searched on an axis, every knob within the parameters' bounds; None where the axis or its data
        cannot have it.
        """
        if (self.rotary_only and scale.is_linear) or (self.two_axis_only and scale.axis_count < 2):
            return None
        if (Need.GYRO | Need.SLIDING) & self.needs & ~scale.present:
            return None
        found = self.search(scale) if self.search is not None else default_profile(self.parameters, scale)
        return (
            None if found is None else replace(found, knobs=tuple(self._bounded(knob, scale) for knob in found.knobs))
        )

    def bounds(self, name: str, base: float) -> tuple[float, float]:
        """Between what a search may move a parameter that stands at `base` now, which is never out of bounds itself."""
        parameter = next(p for p in self.parameters if p.name == name)
        if parameter.periodic:
            return -math.inf, math.inf
        low, high = min(parameter.low, base), max(parameter.high, base)
        # a ripple may pass through nothing to the other sign: half a turn of its phase
        return (-high, high) if any(p.half_turn_of == name for p in self.parameters) else (low, high)

    def _bounded(self, knob: Knob, scale: AxisScale) -> Knob:
        for parameter in self.parameters:
            if parameter.name in knob.parameters:
                base = self._base(parameter, scale)
                if parameter.path is None and knob.move is Move.ADD:
                    knob = knob.beginning_at(base, parameter.neutral)
                knob = knob.within(*self.bounds(parameter.name, base), base)
        return knob

    def _base(self, parameter: Parameter, scale: AxisScale) -> float:
        if parameter.path is not None:
            return scale.numbers[parameter.path]
        return scale.stated.get((self.name, parameter.name), parameter.neutral)
