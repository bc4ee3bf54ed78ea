"""What `--column` says of one column: names in the file, the number at which a counter begins again, units, sums."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimbal_hil.data.tables import UNITS, Floats

_TIMED = re.compile(r"@\s*(?P<size>[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)\s*(?P<unit>s|ms|us|ns)\s*(?=:|$)")
_WRAP = re.compile(r"(?P<column>.+)%(?P<base>\d+(?:\.\d+)?)(?:\^(?P<power>\d{1,2}))?")


@dataclass(frozen=True)
class Term:
    """A column of the file, the count `wrap` at which it begins again, if it does, and the unit that was said for
    it.
    """

    column: str
    wrap: float | None = None
    unit: str = ""


def terms_of(source: str, known: Sequence[str], numbered: bool = True) -> tuple[Term, ...] | None:
    """The terms of `COLUMN[%WRAP][:UNIT]`, several with a plus between; None where a column is not known.

    A name of the file comes first, whatever signs are in it; then, where columns are `numbered`, the number of one,
    counted from one.
    """
    alone = _term(source, known, numbered)
    if alone is not None:
        return (alone,)
    parts = [_term(part.strip(), known, numbered) for part in source.split("+")]
    terms = tuple(part for part in parts if part is not None)
    return terms if len(terms) == len(parts) and len(parts) > 1 else None


def without_time(source: str, known: Sequence[str] = ()) -> tuple[str, float | None]:
    """What `COLUMN@TIME[:UNIT]` says without its time, and by how many seconds the values belong later than their rows;
    None where it says no time. A name of the file comes first.
    """
    found = None if source in known else _TIMED.search(source)
    if found is None:
        return source, None
    return _TIMED.sub("", source).strip(), float(found["size"]) * UNITS["s"][found["unit"]]


def wrapped_on(values: Floats, wrap: float, goes_on: bool) -> Floats:
    """A counter (n,) that begins again at `wrap`: carried on where it goes on and on, as a position or the time does,
    else with the upper half of its range below zero.
    """
    good = np.isfinite(values)
    found = values.copy()
    found[good] = np.unwrap(values[good], period=wrap) if goes_on else (values[good] + wrap / 2) % wrap - wrap / 2
    return found


def _term(text: str, known: Sequence[str], numbered: bool) -> Term | None:
    for column, unit in ((text, ""), tuple(part.strip() for part in text.rpartition(":")[::2])):
        if (name := _known(column, known, numbered)) is not None:
            return Term(name, unit=unit)
        match = _WRAP.fullmatch(column)
        if match is not None and (name := _known(match["column"].strip(), known, numbered)) is not None:
            wrap = float(match["base"]) ** int(match["power"] or 1)
            return Term(name, wrap, unit) if wrap > 0.0 else None
    return None


def _known(name: str, known: Sequence[str], numbered: bool) -> str | None:
    # what stands before a header as a remark does is no part of its first name
    for said in (name, name.lstrip("#% ")):
        if said in known:
            return said
    number = name.removeprefix("#")
    if numbered and number.isdecimal() and number.isascii() and 0 < int(number) <= len(known):
        return known[int(number) - 1]
    return None
