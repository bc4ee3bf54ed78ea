"""What a signal of a DBC can carry, in which steps, and how its unit is spelled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cantools.database.can.signal import Signal

#: factor of a unit to SI
UNITS = {
    "rad": 1.0, "deg": math.pi / 180.0, "turn": 2.0 * math.pi,
    "rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": math.pi / 30.0, "turn/s": 2.0 * math.pi,
    "N m": 1.0, "mN m": 1e-3, "degC": 1.0, "V": 1.0, "mV": 1e-3,
}  # fmt: skip
#: how people write them in a DBC, lower case and without blanks, dots and asterisks
_SPELLINGS = {
    "rad": "rad", "radian": "rad", "radians": "rad",
    "deg": "deg", "°": "deg", "degree": "deg", "degrees": "deg", "grad": "deg",
    "turn": "turn", "turns": "turn", "rev": "turn", "revs": "turn",
    "rad/s": "rad/s", "rad/sec": "rad/s", "rads": "rad/s",
    "deg/s": "deg/s", "°/s": "deg/s", "deg/sec": "deg/s", "dps": "deg/s",
    "rpm": "rpm", "1/min": "rpm", "rev/min": "rpm", "u/min": "rpm", "min-1": "rpm",
    "turn/s": "turn/s", "turns/s": "turn/s", "rev/s": "turn/s", "rps": "turn/s",
    "nm": "N m", "mnm": "mN m",
    "degc": "degC", "°c": "degC", "c": "degC", "celsius": "degC",
    "v": "V", "volt": "V", "mv": "mV",
}  # fmt: skip
#: words of a value table that say that a value is none
_NOT_THERE = ("sna", "invalid", "notavailable", "unavailable", "novalue", "error", "fault", "undefined", "init")


@dataclass(frozen=True)
class Span:
    """Least and largest physical value, as the DBC scales them."""

    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Whether a finite value lies within."""
        return math.isfinite(value) and self.low <= value <= self.high


def span_of(signal: Signal, by_bits: bool = False) -> Span:
    """What the bits of a signal can carry, and with that the range that the DBC states, unless it says [0|0]."""
    if signal.is_float:
        low, high = -math.inf, math.inf
    else:
        raws = (
            (-(1 << signal.length - 1), (1 << signal.length - 1) - 1)
            if signal.is_signed
            else (0, (1 << signal.length) - 1)
        )
        low, high = sorted(float(signal.scale * raw + signal.offset) for raw in raws)
    if by_bits:
        return Span(low, high)
    stated = [None if end is None else float(end) for end in (signal.minimum, signal.maximum)]
    if None not in stated and stated[0] == stated[1]:
        return Span(low, high)
    return Span(low if stated[0] is None else max(low, stated[0]), high if stated[1] is None else min(high, stated[1]))


def step_of(signal: Signal) -> float:
    """One count, physical; nothing for a float."""
    return 0.0 if signal.is_float else float(signal.scale)


def spelled_as(unit: str | None) -> str | None:
    """A unit of a DBC in this project's spelling; None where it says nothing or something else."""
    plain = "".join(letter for letter in (unit or "").lower() if letter not in " .*·_")
    return _SPELLINGS.get(plain)


def not_there(signal: Signal) -> frozenset[float]:
    """Physical values that the value table of a signal calls invalid or not available."""
    found = set()
    for raw, word in (signal.choices or {}).items():
        plain = "".join(letter for letter in str(word).lower() if letter.isalpha())
        if plain.startswith(_NOT_THERE):
            found.add(float(signal.scale * raw + signal.offset))
    return frozenset(found)
