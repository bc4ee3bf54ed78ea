"""Laws that a model file states itself, `kind: curve`: knots and values, which become a program that the plant runs
(`sim_backend/effects/law_program.py`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from firmware_protocol.documents import Strict, validated
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from sim_backend.effects import OPERATION_SIZE, Given, Operation, states_of

#: knots of a curve, and of either variable of a surface
_MOST_KNOTS, MOST_ACROSS = 200, 40


class LawKind(StrEnum):
    """How a law is written."""

    CURVE = "curve"
    FORMULA = "formula"


class ActsOn(StrEnum):
    """What a law adds to: torque at the joint, level of dry friction, commanded torque, or what an encoder reads."""

    TORQUE = "torque"
    FRICTION = "friction"
    COMMAND = "command"
    ENCODER = "encoder"


class Over(StrEnum):
    """What a law is written over."""

    POSITION = "position"
    RATE = "rate"
    #: modulus of the rate
    SPEED = "speed"
    #: torque that is commanded, or (friction) applied
    TORQUE = "torque"
    #: modulus of that
    LOAD = "load"
    TEMPERATURE = "temperature"
    TIME = "time"
    #: how far what is dragged along with slack hangs back
    HANGS_BACK = "hangs_back"
    #: mean speed over the time that is remembered
    RECENT_SPEED = "recent_speed"


#: unit of each variable on a rotary axis and on a linear one
UNIT_OVER: dict[Over, tuple[str, str]] = {
    Over.POSITION: ("rad", "m"),
    Over.RATE: ("rad/s", "m/s"),
    Over.SPEED: ("rad/s", "m/s"),
    Over.TORQUE: ("N m", "N"),
    Over.LOAD: ("N m", "N"),
    Over.TEMPERATURE: ("degC", "degC"),
    Over.TIME: ("s", "s"),
    Over.HANGS_BACK: ("rad", "m"),
    Over.RECENT_SPEED: ("rad/s", "m/s"),
}
#: unit of what a law adds
UNIT_OF: dict[ActsOn, tuple[str, str]] = {
    ActsOn.TORQUE: ("N m", "N"),
    ActsOn.FRICTION: ("N m", "N"),
    ActsOn.COMMAND: ("N m", "N"),
    ActsOn.ENCODER: ("rad", "m"),
}
#: variables that what a law acts on does not know
_UNKNOWN: dict[ActsOn, frozenset[Over]] = {
    ActsOn.TORQUE: frozenset({Over.TORQUE, Over.LOAD}),
    ActsOn.FRICTION: frozenset(),
    ActsOn.COMMAND: frozenset(),
    ActsOn.ENCODER: frozenset(Over) - {Over.POSITION},
}
Row = tuple[float, ...]


def known_to(acts_on: ActsOn) -> frozenset[Over]:
    """Variables that what acts there may be written over."""
    return frozenset(Over) - _UNKNOWN[acts_on]


class CurveSection(Strict):
    """A measured curve; `values`, or `forward` and `backward` where it is another one in each direction."""

    kind: Literal[LawKind.CURVE]
    name: str = ""
    axis: str
    acts_on: ActsOn
    over: Over | tuple[Over, Over]
    unit: str | None = None
    knots: Row | tuple[Row, Row]
    values: Row | tuple[Row, ...] | None = None
    forward: Row | None = None
    backward: Row | None = None
    #: of `values`, or of `forward` and `backward` one after the other; only for the reader
    low: tuple[float | Row, ...] | None = None
    high: tuple[float | Row, ...] | None = None
    #: half the travel over which the direction turns; 0 the sign of the rate
    direction_travel: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    slack: Annotated[float, Field(gt=0.0, le=100.0)] | None = None
    softness: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    memory_s: Annotated[float, Field(gt=0.0, le=1e5)] | None = None
    period_s: Annotated[float, Field(gt=0.0, le=1e6)] | None = None
    source: str | None = None


@dataclass
class LawProgram:
    """Operations, and the tables that they read; `floats` is how it lies in P."""

    operations: list[tuple[Operation, float]] = field(default_factory=list)
    tables: list[tuple[int, Row]] = field(default_factory=list)

    def add(self, operation: Operation, number: float = 0.0) -> LawProgram:
        """One more operation."""
        self.operations.append((operation, float(number)))
        return self

    def read(self, operation: Operation, table: Row) -> LawProgram:
        """One more operation, which reads a table."""
        self.tables.append((len(self.operations), table))
        return self.add(operation)

    @property
    def floats(self) -> Row:
        """Operations, then tables; a table's place counts from the program's first float."""
        numbers = [number for _, number in self.operations]
        behind: list[float] = []
        for at, table in self.tables:
            numbers[at] = float(OPERATION_SIZE * len(self.operations) + len(behind))
            behind += table
        codes = (float(code) for code, _ in self.operations)
        return (*(x for pair in zip(codes, numbers, strict=True) for x in pair), *behind)

    @property
    def states(self) -> int:
        """States in X that it needs."""
        return states_of(tuple(code for code, _ in self.operations))


@dataclass(frozen=True)
class Law:
    """A law of a model file, ready to run."""

    acts_on: ActsOn
    program: Row
    operations: int
    states: int


def curve_of(document: Json, where: str, is_linear: bool) -> Law:
    """A `kind: curve` entry as a law; BadInputError names the key that is wrong."""
    section = validated(CurveSection, document, where)
    over = section.over if isinstance(section.over, tuple) else (section.over,)
    unit = UNIT_OF[section.acts_on][is_linear]
    if section.unit is not None and section.unit != unit:
        raise BadInputError(f"{where}: unit", f"unit {section.unit!r}", f"{unit}, of what acts on {section.acts_on}")
    for one in over:
        if one not in known_to(section.acts_on):
            known = ", ".join(other for other in Over if other in known_to(section.acts_on))
            raise BadInputError(f"{where}: over", f"{section.acts_on} does not know {one}", f"one of {known}")
    program = LawProgram()
    if len(over) == 2:
        _surface(program, section, over, where)
    elif section.values is not None:
        _put(program, over[0], section, where)
        program.read(Operation.SPLINE, _spline_table(section, "values", where))
    else:
        _by_direction(program, section, over[0], where)
    return Law(section.acts_on, program.floats, len(program.operations), program.states)


def _surface(program: LawProgram, section: CurveSection, over: tuple[Over, ...], where: str) -> None:
    knots = section.knots
    if len(knots) != 2 or not all(isinstance(row, tuple) for row in knots):
        raise BadInputError(f"{where}: knots", "is one list", "two lists, of the first variable and of the second")
    first, second = (_ascending(row, f"{where}: knots", MOST_ACROSS) for row in knots if isinstance(row, tuple))
    rows = section.values or ()
    if len(rows) != len(first) or any(not isinstance(row, tuple) or len(row) != len(second) for row in rows):
        raise BadInputError(
            f"{where}: values", "has another shape than the knots", f"{len(first)} rows of {len(second)} values"
        )
    for one in over:
        _put(program, one, section, where)
    table = (float(len(first)), float(len(second)), *first, *second)
    program.read(Operation.SURFACE, (*table, *(x for row in rows if isinstance(row, tuple) for x in row)))


def _by_direction(program: LawProgram, section: CurveSection, over: Over, where: str) -> None:
    """Their mean, and half their difference times the direction."""
    forward, backward = (_spline_table(section, key, where) for key in ("forward", "backward"))
    for table, sign in ((forward, Operation.ADD), (backward, Operation.SUBTRACT)):
        _put(program, over, section, where)
        program.read(Operation.SPLINE, table)
        program.add(Operation.NUMBER, 0.5).add(Operation.NUMBER, 0.5)
        program.add(Operation.DIRECTION, section.direction_travel)
        program.add(Operation.MULTIPLY).add(sign).add(Operation.MULTIPLY)
    program.add(Operation.ADD)


def put_variable(
    program: LawProgram,
    over: Over,
    slack: float | None = None,
    memory_s: float | None = None,
    period_s: float | None = None,
    where: str = "a law",
    softness: float = 0.0,
) -> LawProgram:
    """A program that puts a variable on the stack; BadInputError for one with memory that does not say how much."""
    if over is Over.HANGS_BACK:
        return hanging_back(program, _stated(slack, "slack", over, where), softness)
    if over is Over.RECENT_SPEED:
        return program.add(Operation.RECENT_SPEED, _stated(memory_s, "memory_s", over, where))
    if over is Over.TIME and period_s is not None:
        return program.add(Operation.PHASE_TIME, period_s)
    given = {Over.SPEED: Given.RATE, Over.LOAD: Given.TORQUE}.get(over)
    program.add(Operation.VARIABLE, Given[over.name] if given is None else given)
    return program if given is None else program.add(Operation.ABS)


def hanging_back(program: LawProgram, slack: float, softness: float) -> LawProgram:
    """A program that puts on the stack how far something hangs back: a softness of 0 is play, of 1 Dahl's."""
    if softness <= 0.0:
        return program.add(Operation.HANGS_BACK, slack)
    return program.add(Operation.NUMBER, 1.0 / softness).add(Operation.GIVES_WAY, slack)


def _put(program: LawProgram, over: Over, section: CurveSection, where: str) -> None:
    put_variable(program, over, section.slack, section.memory_s, section.period_s, where, section.softness)


def _stated(number: float | None, key: str, over: Over, where: str) -> float:
    if number is None:
        raise BadInputError(f"{where}: {key}", "is missing", f"a number above zero: the curve is over {over}")
    return number


def _ascending(knots: Row, place: str, most: int) -> Row:
    if not 2 <= len(knots) <= most:
        raise BadInputError(place, f"{len(knots)} knots", f"2 to {most}")
    if np.any(np.diff(knots) <= 0.0):
        raise BadInputError(place, "do not ascend", "each knot above the one before")
    return knots


def _spline_table(section: CurveSection, key: str, where: str) -> Row:
    """(count, knots, values, slopes) of the natural cubic spline through the knots."""
    values = getattr(section, key)
    if values is None:
        raise BadInputError(f"{where}: {key}", "is missing", "`values`, or `forward` and `backward`")
    knots = tuple(x for x in section.knots if isinstance(x, float | int))
    if len(knots) != len(section.knots):
        raise BadInputError(f"{where}: knots", "is no list of numbers", "one list: the curve has one variable")
    _ascending(knots, f"{where}: knots", _MOST_KNOTS)
    if len(values) != len(knots) or any(isinstance(value, tuple) for value in values):
        raise BadInputError(f"{where}: {key}", f"{len(values)} values", f"{len(knots)}, one for each knot")
    return (float(len(knots)), *knots, *values, *spline_slopes(knots, values))


def spline_slopes(knots: Row, values: Row) -> Row:
    """Slopes of the natural cubic spline at its knots."""
    if len(knots) == 2:
        slope = (values[1] - values[0]) / (knots[1] - knots[0])
        return slope, slope
    from scipy.interpolate import CubicSpline

    return tuple(float(slope) for slope in CubicSpline(knots, values, bc_type="natural")(knots, 1))


__all__ = [
    "MOST_ACROSS",
    "UNIT_OF",
    "UNIT_OVER",
    "ActsOn",
    "Law",
    "LawKind",
    "LawProgram",
    "Over",
    "curve_of",
    "hanging_back",
    "known_to",
    "put_variable",
    "spline_slopes",
]
