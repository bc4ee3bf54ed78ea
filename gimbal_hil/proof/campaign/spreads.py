"""Which numbers of a model differ from antenna to antenna, and how far; and an antenna drawn from them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from firmware_protocol.errors import BadInputError
from sim_backend.model import AntennaModel

#: an antenna is drawn anew where its numbers cannot be those of a body or a friction, so often at most
_MOST_DRAWS = 1000
#: in place of a number: every one that the model states an uncertainty of
ALL = "all"
_EXPECTED = "NUMBER, NUMBER=10% or NUMBER=0.02 (in its unit), as friction.coulomb or outer.friction.coulomb, or all"
_AMOUNT = re.compile(r"([0-9.]+(?:[eE][+-]?[0-9]+)?)(%?)")


@dataclass(frozen=True)
class NumberSpread:
    """One number of the model and its standard deviation over the antennas, in its unit."""

    axis: str
    path: str
    deviation: float

    @property
    def name(self) -> str:
        """As in the table: outer.friction.coulomb."""
        return f"{self.axis}.{self.path}"


def spreads_of(model: AntennaModel, asked: Sequence[str]) -> tuple[NumberSpread, ...]:
    """What is asked on the command line; without an amount a number spreads by the uncertainty that the model states.

    A later word about a number takes the place of an earlier one. BadInputError where there is no such number, or
    where nothing would spread.
    """
    found: dict[tuple[str, str], float] = {}
    for words in asked:
        name, _, amount = words.partition("=")
        places = [(axis, path) for axis, path in model.numbers if name in (path, f"{axis}.{path}", ALL)]
        if not places:
            raise BadInputError(f"--spread {words}", f"the model has no number {name!r}", _EXPECTED)
        spreads = {place: _deviation(model, *place, words, amount) for place in places}
        found |= {place: deviation for place, deviation in spreads.items() if deviation > 0.0}
        if not any(spreads.values()):
            problem = "nothing spreads: the number is 0, or no uncertainty of it is stated"
            raise BadInputError(f"--spread {words}", problem, "an amount in the number's unit, as NUMBER=0.02")
    return tuple(NumberSpread(axis, path, deviation) for (axis, path), deviation in found.items())


def _deviation(model: AntennaModel, axis: str, path: str, words: str, amount: str) -> float:
    if not amount:
        return model.uncertainty(axis, path)
    matched = _AMOUNT.fullmatch(amount)
    try:
        size = float(matched[1]) if matched else float("nan")
    except ValueError:
        size = float("nan")
    if not matched or not size < float("inf"):
        raise BadInputError(f"--spread {words}", f"{amount!r} is no amount", _EXPECTED)
    return 0.01 * size * abs(model.number(axis, path)) if matched[2] else size


def drawn(model: AntennaModel, spreads: Sequence[NumberSpread], dice: np.random.Generator) -> AntennaModel:
    """An antenna whose numbers are normally distributed about those of the model; one that cannot exist is drawn anew.

    BadInputError where none could be drawn.
    """
    refused: BadInputError | None = None
    for _ in range(_MOST_DRAWS):
        one = model
        values = [model.number(s.axis, s.path) + s.deviation * dice.standard_normal() for s in spreads]
        try:
            for axis in model.axes:
                of_axis = {s.path: value for s, value in zip(spreads, values, strict=True) if s.axis == axis}
                one = one.with_numbers(axis, of_axis) if of_axis else one
        except BadInputError as error:
            refused = error
        else:
            return one
    raise BadInputError("--spread", f"of {_MOST_DRAWS} antennas none can exist ({refused})", "smaller spreads")
