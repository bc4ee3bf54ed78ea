"""Columns of somebody else's file as those of a signals table: their names there, their units and signs."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals.table import REPEAT, TIME, column_names
from gimbal_hil.data.signals.table_file import RawColumns
from gimbal_hil.data.signals.units import unit_of

_PAIR = "NAME=COLUMN or NAME=COLUMN:UNIT, as in azimuth.position=theta_deg:deg"
_TURN, _POUND, _INCH = 2.0 * math.pi, 4.4482216152605, 0.0254
#: SI unit -> what else may be written for it, and its size in that unit
_UNITS: Mapping[str, Mapping[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "rad": {
        "rad": 1.0,
        "mrad": 1e-3,
        "urad": 1e-6,
        "deg": _TURN / 360.0,
        "arcmin": _TURN / 21_600.0,
        "arcsec": _TURN / 1_296_000.0,
        "turn": _TURN,
    },
    "rad/s": {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": _TURN / 360.0, "turn/s": _TURN, "rpm": _TURN / 60.0},
    "N m": {
        "N m": 1.0,
        "mN m": 1e-3,
        "kN m": 1e3,
        "N cm": 1e-2,
        "lbf ft": 12.0 * _POUND * _INCH,
        "lbf in": _POUND * _INCH,
        "ozf in": _POUND * _INCH / 16.0,
    },
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": _INCH},
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "in/s": _INCH},
    "N": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": _POUND},
    "A": {"A": 1.0, "mA": 1e-3},
    "degC": {"degC": 1.0, "K": 1.0, "degF": 5.0 / 9.0},
    "m/s^2": {"m/s^2": 1.0, "mm/s^2": 1e-3, "g": 9.80665},
    "": {"1": 1.0},
}
#: what reads zero at 0 degC
_ZERO_DEGC = {"K": 273.15, "degF": 32.0}
_NUMBER = r"\d+(?:\.\d*)?(?:[eE][+-]?\d+)?"
_UNIT = re.compile(rf"(?P<sign>-?)(?:(?P<times>{_NUMBER})\*?)?(?P<unit>[^\d].*?)?(?:/(?P<over>{_NUMBER}))?")


@dataclass(frozen=True)
class ColumnMap:
    """Column of a signals table -> column of the file, with `:UNIT` where that is not SI; nothing is left as it is.

    A minus before the unit mirrors the column, a number multiplies or divides it: `:-deg`, `:turn/8192`, `:0.062*N m`.
    """

    sources: Mapping[str, str]

    @classmethod
    def of_words(cls, words: Sequence[str] | None, option: str = "--column") -> ColumnMap:
        """From words `NAME=COLUMN[:UNIT]`; BadInputError for one that is none, or for a name that comes twice."""
        found: dict[str, str] = {}
        for word in words or ():
            name, equals, source = (part.strip() for part in word.partition("="))
            if not (name and equals and source):
                raise BadInputError(f"{option} {word}", "is no pair", _PAIR)
            if name in found:
                raise BadInputError(f"{option} {word}", f"is the second column for {name}", "every name once")
            found[name] = source
        return cls(MappingProxyType(found))

    def read(self, raw: RawColumns, axes: Sequence[str], linear: bool) -> RawColumns:
        """The file with these columns under their names and in SI units.

        A column that is taken loses the name that it has in the file. A file that has none of these columns, but those
        of a signals table, is left as it is. Raises BadInputError for a name that no such table has, a column that the
        file does not have, and a unit of something else.
        """
        if not self.sources:
            return raw
        split = {name: self._split(name, raw, axes) for name in self.sources}
        missing = {name: column for name, (column, _) in split.items() if column not in raw.values}
        if len(missing) == len(split) and all(name in raw.values for name in split):
            return raw
        for name, column in missing.items():
            near = difflib.get_close_matches(column, raw.values, 1)
            hint = f"{near[0]!r}, perhaps; it has" if near else "one of"
            raise BadInputError(
                str(raw.path), f"has no column {column!r} for {name}", f"{hint} {', '.join(raw.values)}"
            )
        taken = {column for column, _ in split.values()} | set(split)
        values = {name: column for name, column in raw.values.items() if name not in taken}
        texts = {name: raw.texts[name] for name in values}
        for name, (column, unit) in split.items():
            factor, zero = _size(unit, name, unit_of(name, axes if linear else ()), self.sources[name])
            values[name] = factor * (raw.values[column] - zero)
            texts[name] = raw.texts[column]
        return replace(raw, values=values, texts=texts, called={name: column for name, (column, _) in split.items()})

    def _split(self, name: str, raw: RawColumns, axes: Sequence[str]) -> tuple[str, str]:
        """Column in the file and unit for one name; a colon may be part of what the column is called."""
        allowed = (TIME, REPEAT, *column_names(axes))
        source = self.sources[name]
        if name not in allowed:
            near = difflib.get_close_matches(name, allowed, 1)
            hint = f"{near[0]!r}, perhaps; all: " if near else ""
            raise BadInputError(
                f"--column {name}={source}", f"a signals table has no column {name!r}", hint + ", ".join(allowed)
            )
        column, colon, unit = source.rpartition(":")
        if source in raw.values or not colon:
            return source, ""
        return column.strip(), unit.strip()


def _size(text: str, name: str, si: str, source: str) -> tuple[float, float]:
    """Size of what is written in SI units, and what it reads where that is zero."""
    known = {_spelled(word): (word, size) for word, size in _UNITS[si].items()}
    match = _UNIT.fullmatch(text)
    parts = match.groupdict() if match is not None else {}
    word, size = known.get(_spelled(parts.get("unit") or si or "1"), ("", math.nan))
    times, over = float(parts.get("times") or 1.0), float(parts.get("over") or 1.0)
    if math.isnan(size) or times == 0.0 or over == 0.0:
        raise BadInputError(
            f"--column {name}={source}",
            f"{text!r} is no unit for {name}",
            f"{', '.join(_UNITS[si])}; a number may multiply or divide it (2*{si or 1}, {si or 1}/8192), a minus "
            "before it mirrors it",
        )
    sign = -1.0 if parts.get("sign") else 1.0
    return sign * times * size / over, _ZERO_DEGC.get(word, 0.0)


def _spelled(unit: str) -> str:
    """Without what people write in different ways: spaces, dots and stars between, a caret, signs for micro, degree."""
    for written, plain in (("°", "deg"), ("µ", "u"), ("μ", "u"), ("rev", "turn")):
        unit = unit.replace(written, plain)
    return re.sub(r"[ .*·^]", "", unit)
