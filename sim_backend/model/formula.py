"""Formulas of a model file: a small grammar, units that have to fit, and operations that the plant runs.

    sum     = product (("+" | "-") product)*
    product = signed (("*" | "/") signed)*
    signed  = "-" signed | power
    power   = atom ("^" signed)?
    atom    = number | name | name "(" sum ("," sum)* ")" | "(" sum ")"

Names are variables (`position`, `rate`, ...), numbers that the entry states, and functions. Nothing else is understood,
and nothing is ever executed as code.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from firmware_protocol.documents import LARGEST_NUMBER, Strict, validated
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from sim_backend.effects import STACK, Operation
from sim_backend.model.laws import (
    UNIT_OF,
    UNIT_OVER,
    ActsOn,
    Law,
    LawKind,
    LawProgram,
    Over,
    hanging_back,
    known_to,
    put_variable,
)

#: powers of N, m, s, rad, degC; what has none is a plain number
Dimension = tuple[int, int, int, int, int]
PLAIN: Dimension = (0, 0, 0, 0, 0)
_BASE = ("N", "m", "s", "rad", "degC")
_ANGLE: Dimension = (0, 0, 0, 1, 0)
_TOKEN = re.compile(r"\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*)|([-+*/^(),]))")
#: longest formula, how deep it may nest, and how many numbers it may have
_MOST_CHARACTERS, _DEEPEST, _MOST_NUMBERS = 400, 10, 12
_ONE_ARGUMENT = {
    "abs": Operation.ABS,
    "sign": Operation.SIGN,
    "sin": Operation.SINE,
    "cos": Operation.COSINE,
    "exp": Operation.EXPONENTIAL,
    "tanh": Operation.TANH,
    "sqrt": Operation.SQUARE_ROOT,
}
_TWO_ARGUMENTS = {"min": Operation.LEAST, "max": Operation.MOST}
#: functions with memory, of one number that the entry states, the first of a second one as well
_WITH_MEMORY = {
    "hangs_back": Operation.HANGS_BACK,
    "recent_speed": Operation.RECENT_SPEED,
    "direction": Operation.DIRECTION,
}
_TAKES_TWO = (
    Operation.ADD,
    Operation.SUBTRACT,
    Operation.MULTIPLY,
    Operation.DIVIDE,
    Operation.POWER,
    Operation.LEAST,
    Operation.MOST,
)
#: variables that are a name alone
_VARIABLES = {one.value: one for one in Over if one not in (Over.HANGS_BACK, Over.RECENT_SPEED)}


class FormulaNumber(Strict):
    """A number of a formula; `low` and `high` are for the reader."""

    value: float
    unit: str
    low: float | None = None
    high: float | None = None


class FormulaSection(Strict):
    """A formula and its numbers by name."""

    kind: Literal[LawKind.FORMULA]
    name: str = ""
    axis: str
    acts_on: ActsOn
    form: str
    numbers: Annotated[dict[str, FormulaNumber], Field(max_length=_MOST_NUMBERS)]
    source: str | None = None


def formula_of(document: Json, where: str, is_linear: bool) -> Law:
    """A `kind: formula` entry as a law; BadInputError names the key that is wrong."""
    section = validated(FormulaSection, document, where)
    numbers = {name: (number.value, number.unit) for name, number in section.numbers.items()}
    taken = sorted(set(numbers) & {*_VARIABLES, *_ONE_ARGUMENT, *_TWO_ARGUMENTS, *_WITH_MEMORY})
    if taken:
        raise BadInputError(f"{where}: numbers", f"{', '.join(taken)} is taken", "another name")
    wanted = UNIT_OF[section.acts_on][is_linear]
    program = formula_program(section.form, numbers, wanted, is_linear, known_to(section.acts_on), where)
    return Law(section.acts_on, program.floats, len(program.operations), program.states)


@dataclass(frozen=True)
class _Part:
    """Operations, the dimension of what they leave, and their value where it is a number as it stands."""

    operations: tuple[tuple[Operation, float], ...]
    dimension: Dimension
    constant: float | None = None


def dimension_of(unit: str, place: str) -> Dimension:
    """The dimension of a unit such as `N m/rad^3`; BadInputError for one that is none."""
    found = [0] * len(_BASE)
    sign = 1
    for side in unit.replace("*", " ").replace("²", "^2").replace("³", "^3").split("/"):
        for word in side.split():
            name, _, power = word.partition("^")
            if name in _BASE and re.fullmatch(r"-?\d*", power):
                found[_BASE.index(name)] += sign * int(power or 1)
            elif name != "1" or power:
                raise BadInputError(place, f"unit {unit!r}", "powers of " + ", ".join(_BASE) + ", or 1")
        sign = -1
    return found[0], found[1], found[2], found[3], found[4]


def unit_text(dimension: Dimension) -> str:
    """A unit of that dimension in words that `dimension_of` reads."""

    def side(powers: list[tuple[str, int]]) -> str:
        return " ".join(name if power == 1 else f"{name}^{power}" for name, power in powers)

    both = list(zip(_BASE, dimension, strict=True))
    above, below = [(n, p) for n, p in both if p > 0], [(n, -p) for n, p in both if p < 0]
    return (side(above) or "1") + "".join(f"/{side([one])}" for one in below)


def formula_program(
    form: str,
    numbers: Mapping[str, tuple[float, str]],
    wanted: str,
    is_linear: bool,
    known: frozenset[Over],
    where: str,
) -> LawProgram:
    """The operations of a formula whose `numbers` are (value, unit), and whose value has the unit `wanted`.

    `known` are the variables that are there. BadInputError says at which character, or which unit does not fit.
    """
    place = f"{where}: form"
    if len(form) > _MOST_CHARACTERS:
        raise BadInputError(place, f"{len(form)} characters", f"at most {_MOST_CHARACTERS}")
    reader = _Reader(form, numbers, is_linear, known, place, where)
    part = reader.sum(0)
    reader.end()
    if part.dimension != dimension_of(wanted, place):
        raise BadInputError(place, f"is in {unit_text(part.dimension)}", wanted)
    unused = sorted(set(numbers) - reader.used)
    if unused:
        raise BadInputError(f"{where}: numbers", f"{', '.join(unused)} stand in no place of the form", "names of it")
    program = LawProgram()
    for operation, number in part.operations:
        program.add(operation, number)
    if _depth(part.operations) > STACK:
        raise BadInputError(place, "needs too many results at once", f"{STACK} at most: fewer brackets on the right")
    return program


def _depth(operations: tuple[tuple[Operation, float], ...]) -> int:
    """Largest number of values that lie on the stack at a time."""
    now = most = 0
    for operation, _ in operations:
        if operation in (Operation.NUMBER, Operation.VARIABLE, *_WITH_MEMORY.values()):
            now += 1
        elif operation in _TAKES_TWO:
            now -= 1
        most = max(most, now)
    return most


class _Reader:
    """Recursive descent over the grammar; each rule answers a `_Part`."""

    def __init__(
        self,
        form: str,
        numbers: Mapping[str, tuple[float, str]],
        is_linear: bool,
        known: frozenset[Over],
        place: str,
        where: str,
    ) -> None:
        self.form, self.numbers, self.is_linear, self.known = form, numbers, is_linear, known
        self.place, self.where = place, where
        self.at = 0
        self.used: set[str] = set()

    def sum(self, depth: int) -> _Part:
        """Products, added."""
        part = self.product(depth)
        while (sign := self._taken("+", "-")) is not None:
            other = self.product(depth)
            operation = Operation.ADD if sign == "+" else Operation.SUBTRACT
            part = self._joined(part, other, operation, self._alike(part, other, sign))
        return part

    def product(self, depth: int) -> _Part:
        """Signed powers, multiplied."""
        part = self.signed(depth)
        while (sign := self._taken("*", "/")) is not None:
            other, way = self.signed(depth), 1 if sign == "*" else -1
            dimension = _combined(part.dimension, other.dimension, way)
            part = self._joined(part, other, Operation.MULTIPLY if way > 0 else Operation.DIVIDE, dimension)
        return part

    def signed(self, depth: int) -> _Part:
        """A power, or what is under a minus."""
        if self._taken("-") is None:
            return self.power(depth)
        part = self.signed(self._deeper(depth))
        constant = None if part.constant is None else -part.constant
        return _Part((*part.operations, (Operation.NEGATE, 0.0)), part.dimension, constant)

    def power(self, depth: int) -> _Part:
        """An atom, or one to a power: a whole odd power keeps the sign, any other is of the modulus."""
        part = self.atom(depth)
        if self._taken("^") is None:
            return part
        power = self.signed(self._deeper(depth))
        if power.dimension != PLAIN:
            raise self._refused(f"a power in {unit_text(power.dimension)}", "a plain number")
        raised = (*part.operations, *power.operations, (Operation.POWER, 0.0))
        if part.dimension == PLAIN and power.constant is None:
            return _Part(raised, PLAIN)
        whole = power.constant
        if whole is None or (part.dimension != PLAIN and whole != int(whole)):
            raise self._refused(f"{unit_text(part.dimension)} to a power that is no whole number", "a whole number")
        dimension = _combined(PLAIN, part.dimension, int(whole)) if part.dimension != PLAIN else PLAIN
        if whole == int(whole) and int(whole) % 2:
            sign = (*part.operations, (Operation.SIGN, 0.0), (Operation.MULTIPLY, 0.0))
            return _Part((*raised, *sign), dimension)
        return _Part(raised, dimension)

    def atom(self, depth: int) -> _Part:
        """A number, a name, a function, or what is in brackets."""
        kind, text = self._next()
        if kind == "number":
            return _Part(((Operation.NUMBER, float(text)),), PLAIN, float(text))
        if text == "(":
            part = self.sum(self._deeper(depth))
            self._expected(")")
            return part
        if kind != "name":
            raise self._refused(f"{text or 'nothing'!r}", "a number, a name or a bracket")
        return self._function(text, depth) if self._taken("(") is not None else self._name(text)

    def end(self) -> None:
        """Nothing may follow."""
        if self.form[self.at :].strip():
            raise self._refused(f"{self.form[self.at :].strip()!r}", "the end, or + - * / ^")

    def _name(self, name: str) -> _Part:
        if name in self.numbers:
            self.used.add(name)
            value, unit = self.numbers[name]
            return _Part(((Operation.NUMBER, value),), dimension_of(unit, f"{self.where}: numbers.{name}"))
        over = _VARIABLES.get(name)
        if over is None or over not in self.known:
            there = [*sorted(self.numbers), *(one.value for one in Over if one in self.known)]
            raise self._refused(f"no number or variable {name!r} here", "one of " + ", ".join(there))
        unit = UNIT_OVER[over][self.is_linear]
        return _Part(tuple(put_variable(LawProgram(), over).operations), dimension_of(unit, self.place))

    def _function(self, name: str, depth: int) -> _Part:
        if name in _WITH_MEMORY:
            return self._memory(name)
        arguments = [self.sum(self._deeper(depth))]
        while self._taken(",") is not None:
            arguments.append(self.sum(self._deeper(depth)))
        self._expected(")")
        if name in _TWO_ARGUMENTS and len(arguments) == 2:
            first, second = arguments
            return self._joined(first, second, _TWO_ARGUMENTS[name], self._alike(first, second, name))
        if name not in _ONE_ARGUMENT or len(arguments) != 1:
            functions = ", ".join((*_ONE_ARGUMENT, *_TWO_ARGUMENTS, *_WITH_MEMORY))
            raise self._refused(f"{name} of {len(arguments)}", f"a function of one (min and max of two): {functions}")
        return _of_one(name, arguments[0], self)

    def _memory(self, name: str) -> _Part:
        length = UNIT_OVER[Over.POSITION][self.is_linear]
        value = self._number_of(name, "s" if name == "recent_speed" else length, LARGEST_NUMBER)
        soft = self._number_of(name, "1", 1.0) if name == "hangs_back" and self._taken(",") is not None else 0.0
        self._expected(")")
        if Over.RATE not in self.known:
            raise self._refused(f"{name} is not known here", "what acts on torque, friction or command")
        given = {"hangs_back": length, "recent_speed": f"{length}/s", "direction": "1"}[name]
        program = (
            LawProgram().add(_WITH_MEMORY[name], value) if soft == 0.0 else hanging_back(LawProgram(), value, soft)
        )
        return _Part(tuple(program.operations), dimension_of(given, self.place))

    def _number_of(self, function: str, needed: str, most: float) -> float:
        """A number that a function with memory takes: by its name, above zero, in a unit."""
        kind, name = self._next()
        if kind != "name" or name not in self.numbers:
            raise self._refused(f"{function} of {name!r}", "one of the numbers: " + ", ".join(sorted(self.numbers)))
        self.used.add(name)
        value, unit = self.numbers[name]
        place = f"{self.where}: numbers.{name}"
        if dimension_of(unit, place) != dimension_of(needed, self.place):
            raise BadInputError(place, f"unit {unit!r}", f"{needed}, for {function}")
        if not 0.0 < value <= most:
            raise BadInputError(place, f"{value:g}", f"above zero, at most {most:g}, for {function}")
        return value

    def _alike(self, part: _Part, other: _Part, what: str) -> Dimension:
        if part.dimension == other.dimension or other.constant == 0.0:
            return part.dimension
        if part.constant == 0.0:
            return other.dimension
        two = f"{unit_text(part.dimension)} {what} {unit_text(other.dimension)}"
        raise self._refused(two, "the same unit on both sides")

    def _joined(self, part: _Part, other: _Part, operation: Operation, dimension: Dimension) -> _Part:
        return _Part((*part.operations, *other.operations, (operation, 0.0)), dimension)

    def _deeper(self, depth: int) -> int:
        if depth >= _DEEPEST:
            raise self._refused("nests too deep", f"{_DEEPEST} levels at most")
        return depth + 1

    def _taken(self, *signs: str) -> str | None:
        found = _TOKEN.match(self.form, self.at)
        if found is None or found[3] not in signs:
            return None
        self.at = found.end()
        return found[3]

    def _expected(self, sign: str) -> None:
        if self._taken(sign) is None:
            raise self._refused(f"no {sign!r}", f"{sign!r} after {self.form[: self.at].strip()!r}")

    def _next(self) -> tuple[str, str]:
        found = _TOKEN.match(self.form, self.at)
        if found is None:
            return "end", self.form[self.at :].strip()[:1]
        self.at = found.end()
        kind = "number" if found[1] else "name" if found[2] else "sign"
        return kind, found[0].strip()

    def _refused(self, problem: str, expected: str) -> BadInputError:
        return BadInputError(self.place, f"{problem}, at character {self.at}", expected)


def _of_one(name: str, part: _Part, reader: _Reader) -> _Part:
    """A function of one argument, whose dimension it may ask for."""
    dimension = part.dimension
    if name in ("sin", "cos") and dimension in (PLAIN, _ANGLE):
        dimension = PLAIN
    elif name in ("sin", "cos", "exp", "tanh") and dimension != PLAIN:
        raise reader._refused(
            f"{name} of {unit_text(dimension)}", "a plain number" + (" or rad" if "n" in name else "")
        )
    elif name == "sign":
        dimension = PLAIN
    elif name == "sqrt":
        if any(power % 2 for power in dimension):
            raise reader._refused(f"sqrt of {unit_text(dimension)}", "a unit that is a square")
        dimension = _halved(dimension)
    return _Part((*part.operations, (_ONE_ARGUMENT[name], 0.0)), dimension)


def _halved(one: Dimension) -> Dimension:
    return one[0] // 2, one[1] // 2, one[2] // 2, one[3] // 2, one[4] // 2


def _combined(first: Dimension, second: Dimension, times: int) -> Dimension:
    a = [x + times * y for x, y in zip(first, second, strict=True)]
    return a[0], a[1], a[2], a[3], a[4]
