"""The form of a law before it has numbers: its axis, what it acts on, and its variables."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.twin import Floats, Record
from sim_backend.effects import OPERATION_SIZE, Operation
from sim_backend.layout import EFFECT_STATES, STEP_S
from sim_backend.model import ActsOn, AntennaModel, LawProgram, Over, put_variable

#: slacks that are tried, shares of the travel; times over which recent motion is remembered, s
_SLACKS, _MEMORIES_S = (0.01, 0.05, 0.15, 0.4), (1.5, 5.0, 15.0)
#: softness of what hangs back at which its slack is first tried
_SOFT = 0.5
#: a straight line over them is what the catalogue has numbers for: an offset or a level, and a spring, a viscosity, a
#: gain or friction that grows with the load
_NAMED_STRAIGHT = {
    ActsOn.TORQUE: (Over.POSITION, Over.RATE, Over.SPEED),
    ActsOn.COMMAND: (Over.TORQUE,),
    ActsOn.FRICTION: (Over.SPEED, Over.LOAD),
}
#: variables that remember
WITH_MEMORY = (Over.HANGS_BACK, Over.RECENT_SPEED)
#: where the program lies in the small arrays that carry a variable along a record
_AT = 8


@dataclass(frozen=True)
class LawShape:
    """One kind of law on an axis; values at knots make it a curve."""

    axis: str
    acts_on: ActsOn
    over: tuple[Over, ...]
    by_direction: bool = False
    #: half the travel over which the direction turns, rad (m)
    direction_travel: float = 0.0
    slack: float | None = None
    #: how early what hangs back comes along: 0 only at its slack, 1 from the start
    softness: float = 0.0
    memory_s: float | None = None

    @property
    def has_memory(self) -> bool:
        """Whether it is written over what was a moment ago."""
        return self.slack is not None or self.memory_s is not None

    @property
    def without_numbers(self) -> LawShape:
        """The same whatever it remembers."""
        return replace(self, slack=None, softness=0.0, memory_s=None)

    @property
    def has_a_name_straight(self) -> bool:
        """Whether a straight line of this shape is no law but numbers of the catalogue."""
        return len(self.over) == 1 and self.over[0] in _NAMED_STRAIGHT.get(self.acts_on, ())

    @property
    def plainness(self) -> tuple[bool, int, bool]:
        """What comes first is preferred where data do not tell: no memory, one variable, the same either way."""
        return self.has_memory, len(self.over), self.by_direction

    @property
    def text(self) -> str:
        """In words."""
        over = " and ".join(one.value.replace("_", " ") for one in self.over)
        return f"{self.acts_on.value} on {self.axis} over {over}" + (", by direction" if self.by_direction else "")


def shapes_of(model: AntennaModel, axis: str, records: tuple[Record, ...]) -> tuple[LawShape, ...]:
    """Shapes with one variable that these records can show on an axis."""
    i = model.axes.index(axis)
    travel = max(float(np.ptp(record.motion[:, i])) for record in records)
    stiffness = model.number(axis, "friction.sigma0")
    turns = model.number(axis, "friction.breakaway") / stiffness if stiffness > 0.0 else 0.0
    plain = [Over.POSITION, Over.RATE]
    friction = [Over.POSITION, Over.SPEED, Over.LOAD]
    if all(record.has_temperature for record in records):
        plain.append(Over.TEMPERATURE)
        friction.append(Over.TEMPERATURE)
    found = [LawShape(axis, ActsOn.TORQUE, (over,)) for over in plain]
    found.append(LawShape(axis, ActsOn.COMMAND, (Over.TORQUE,)))
    found += [LawShape(axis, ActsOn.FRICTION, (over,), direction_travel=turns) for over in friction]
    found += [LawShape(axis, ActsOn.TORQUE, (over,), True, turns) for over in (Over.POSITION, Over.SPEED)]
    found += [
        LawShape(axis, ActsOn.TORQUE, (Over.HANGS_BACK,), slack=share * travel, softness=_SOFT) for share in _SLACKS
    ]
    found += [
        LawShape(axis, ActsOn.FRICTION, (Over.RECENT_SPEED,), direction_travel=turns, memory_s=s) for s in _MEMORIES_S
    ]
    return tuple(found)


def crossed(first: LawShape, shapes: tuple[LawShape, ...]) -> Iterator[LawShape]:
    """Shapes with two variables, one of them that of the first; both act on the same thing in the same way. What holds
    by direction is crossed with the rate, which says the direction; so is friction, which may act through the bristles
    or beside them.
    """
    met: set[frozenset[object]] = set()
    turns, first = first.by_direction, replace(first, by_direction=False)
    beside = replace(first, acts_on=ActsOn.TORQUE, direction_travel=0.0)
    turning = first.acts_on is ActsOn.FRICTION and first.over[0] not in (Over.SPEED, Over.LOAD)
    for second in shapes:
        rate = second.acts_on is ActsOn.TORQUE and second.over == (Over.RATE,)
        one = beside if turning and rate else first
        alike = one.acts_on is second.acts_on and one.over != second.over
        pair: frozenset[object] = frozenset(
            {(each.over, each.slack, each.softness, each.memory_s) for each in (one, second)}
        )
        apart = second.by_direction or (one.has_memory and second.has_memory)
        if alike and not apart and pair not in met and (not turns or rate):
            met.add(pair)
            slack, memory_s = one.slack or second.slack, one.memory_s or second.memory_s
            both = tuple(sorted((*one.over, *second.over), key=list(Over).index))
            softness = max(one.softness, second.softness)
            yield replace(second, over=both, slack=slack, softness=softness, memory_s=memory_s)


def variables(shape: LawShape, records: tuple[Record, ...], axis: int) -> list[tuple[Floats, ...]]:
    """Of every record the variables that a shape is written over, (n,) each, by the operations that the plant runs."""
    return [tuple(_along(record, axis, shape, over) for over in shape.over) for record in records]


def direction(shape: LawShape, record: Record, axis: int) -> Floats:
    """Which way the joint goes, as the plant has it, (n,)."""
    return _run(LawProgram().add(Operation.DIRECTION, shape.direction_travel), record, axis)


def _along(record: Record, axis: int, shape: LawShape, over: Over) -> Floats:
    return _run(put_variable(LawProgram(), over, shape.slack, shape.memory_s, softness=shape.softness), record, axis)


def _run(program: LawProgram, record: Record, axis: int) -> Floats:
    from gimbal_hil.knowledge.discrepancy.laws.along import law_along

    P = np.concatenate([np.zeros(_AT + OPERATION_SIZE), np.array(program.floats)])
    P[STEP_S], P[_AT], P[_AT + 1] = record.bands.period_s, _AT + OPERATION_SIZE, len(program.operations)
    out = np.zeros(len(record.motion))
    X = np.zeros(EFFECT_STATES + program.states)
    law_along(P, _AT, X, EFFECT_STATES, axis, record.motion, record.torque, record.heat, out)
    return out
