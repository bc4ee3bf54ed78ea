"""Units as people write them, and how large they are in the SI unit of what they measure.

The units of everyday use are a table. What it does not have is asked of `pint`, an extra: it knows the units there are
and how they combine, but not that `oz` beside `in` is a force, or that `Nmm` is a product.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from functools import cache
from typing import Any

_TURN, _POUND, _INCH, _KILOPOND = 2.0 * math.pi, 4.4482216152605, 0.0254, 9.80665
#: SI unit -> what else may be written for it, and its size in that unit
UNITS: Mapping[str, Mapping[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86_400.0},
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
        "N mm": 1e-3,
        "kgf cm": _KILOPOND * 1e-2,
        "lbf ft": 12.0 * _POUND * _INCH,
        "lbf in": _POUND * _INCH,
        "ozf in": _POUND * _INCH / 16.0,
    },
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": _INCH},
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "in/s": _INCH},
    "N": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": _POUND, "kgf": _KILOPOND},
    "A": {"A": 1.0, "mA": 1e-3},
    "degC": {"degC": 1.0, "K": 1.0, "degF": 5.0 / 9.0},
    "m/s^2": {"m/s^2": 1.0, "mm/s^2": 1e-3, "g": _KILOPOND},
    "": {"1": 1.0},
}
#: what reads zero at 0 degC
ZERO_DEGC = {"K": 273.15, "degF": 32.0}
#: words of no unit that say that a column is not in one
RAW_WORDS = frozenset(("count", "counts", "cnt", "cnts", "lsb", "raw", "tick", "ticks", "step", "steps", "%", "pct"))
_OTHER_UNITS = frozenset(("V", "mV", "W", "kW", "Hz", "kHz", "Ohm", "ohm", "-", "kg", "bar", "Pa"))
#: other spellings, as a whole word -> the one that is known
_SPELLINGS: Mapping[str, str] = {
    "sec": "s",
    "secs": "s",
    "second": "s",
    "seconds": "s",
    "msec": "ms",
    "usec": "us",
    "nsec": "ns",
    "nanosec": "ns",
    "minute": "min",
    "minutes": "min",
    "mins": "min",
    "hour": "h",
    "hours": "h",
    "hr": "h",
    "hrs": "h",
    "day": "d",
    "days": "d",
    "degree": "deg",
    "degrees": "deg",
    "radian": "rad",
    "radians": "rad",
    "revolution": "turn",
    "revolutions": "turn",
    "rev": "turn",
    "revs": "turn",
    "turns": "turn",
    "dps": "deg/s",
    "amp": "A",
    "amps": "A",
    "ampere": "A",
    "newton": "N",
    "meter": "m",
    "metre": "m",
    "meters": "m",
    "inch": "in",
    "inches": "in",
    "celsius": "degC",
    "kelvin": "K",
    "fahrenheit": "degF",
}
#: of a torque or force: the weight of that mass is meant
_WEIGHTS: Mapping[str, str] = {"lb": "lbf", "lbs": "lbf", "oz": "ozf", "kg": "kgf", "kp": "kgf", "gf": "gf"}
_FORCES = ("N m", "N")
#: letters that end a name oftener than they are its unit
_SHORT = frozenset(("a", "n", "m", "g", "s", "d", "h", "k", "in", "1", "turn"))
#: words of the longest unit that a name ends in
_MOST_WORDS = 3
IN_BRACKETS = re.compile(r"^(?P<name>.*?)\s*[\[(](?P<unit>[^\])]+)[\])]\s*$")


def unit_size(word: str, si: str) -> tuple[float, float] | None:
    """Size of a unit in the SI unit `si`, and what it reads where that is zero; None for no unit of the same kind."""
    found = _by_table(word, si)
    return found if found is not None or si in ("", "degC") else _by_pint(_usual(word, si), si)


def unit_in_name(name: str, si: str) -> str:
    """The unit of the kind of `si` that the name of a column ends in, as `angle_deg`, `theta/deg` and `tau [gf cm]` do;
    empty where it ends in none. A word that only a library takes for a unit is one in brackets alone, and of a torque
    only in a product: `torque (cal)` is calibrated.
    """
    if (match := IN_BRACKETS.match(name)) is not None:
        unit = match["unit"].strip()
        if (unit_size if si not in _FORCES or not unit.isalpha() else _by_table)(unit, si) is not None:
            return unit
    parts = [*re.finditer(r"[_\s/.]+", name.strip())][-_MOST_WORDS:]
    # the longest first: of `tau_mN_m` the m is none by itself
    tails = [re.sub(r"[_\s.]+", " ", name.strip()[part.end() :]) for part in parts if part.start() > 0]
    fits = (tail for tail in tails if tail.lower() not in _SHORT and _by_table(tail, si) is not None)
    return next(fits, "")


def _by_table(word: str, si: str) -> tuple[float, float] | None:
    known = {_pressed(name): (name, size) for name, size in UNITS[si].items()}
    for said in (_pressed(word), _pressed(_usual(word, si)), _turned(_usual(word, si))):
        if said in known:
            name, size = known[said]
            return size, ZERO_DEGC.get(name, 0.0)
    return None


def is_unit_word(word: str) -> bool:
    """Whether a word above a column is a unit, or says that the column is in none."""
    if word in _OTHER_UNITS or word.lower() in RAW_WORDS:
        return True
    return any(
        _pressed(said) in {_pressed(name) for name in names}
        for si, names in UNITS.items()
        for said in (word, _usual(word, si))
        if si
    )


def _pressed(unit: str) -> str:
    """Without what people write in different ways: spaces, dots and stars between, a caret, signs for micro, degree."""
    for written, plain in (("°C", "degC"), ("°F", "degF"), ("°", "deg"), ("µ", "u"), ("μ", "u"), ("²", "2")):
        unit = unit.replace(written, plain)
    return re.sub(r"[ .*·⋅^_]", "", unit)


def _usual(unit: str, si: str) -> str:
    """Each word of a unit in its usual spelling: capitals where one unit alone can be meant, weights as forces."""
    for written, plain in (("°C", "degC"), ("°F", "degF"), ("°", "deg"), ("µ", "u"), ("μ", "u"), ("²", "2")):
        unit = unit.replace(written, plain)
    unit = re.sub(r"(?<=[A-Za-z])\s*[-·⋅.*]\s*(?=[A-Za-z])", " ", unit.strip())
    words = []
    for word in re.split(r"([ /^*()]|(?<=[a-z])\d)", unit):
        plain = _SPELLINGS.get(word.lower(), word)
        if plain == word and len(word) > 1 and word.lower() in ("rpm", "deg", "rad", "nm"):
            plain = {"nm": "N m"}.get(word.lower(), word.lower()) if si != "m" else word
        words.append(_WEIGHTS.get(plain.lower(), plain) if si in _FORCES else plain)
    return "".join(words)


def _turned(unit: str) -> str:
    """A product of two words the other way round, as `in lb` is `lbf in`; a rate by the minute as rpm."""
    first, _, second = unit.partition(" ")
    return "rpm" if unit == "turn/min" else _pressed(f"{second} {first}")


@cache
def _registry() -> Any:
    """Pint's registry; None where it is not installed."""
    try:
        import pint
    except ImportError:
        return None
    return pint.UnitRegistry(cache_folder=None)


def knows_all_units() -> bool:
    """Whether units beyond the table can be asked for."""
    return _registry() is not None


@cache
def _by_pint(unit: str, si: str) -> tuple[float, float] | None:
    registry = _registry()
    if registry is None or not re.fullmatch(r"[A-Za-z0-9 /*^().]{1,40}", unit) or re.match(r"[\d(]", unit):
        return None
    try:
        # a space is a product, and all behind a stroke is below it, as in rad/s
        found = registry.Quantity(1.0, re.sub(r"(?<=\w) (?=\w)", "*", unit)).to_base_units()
        wanted = registry.Quantity(1.0, si.replace(" ", "*")).to_base_units()
        # a count and a turn have no dimension, either of them, and yet one is no angle
        if found.units != wanted.units:
            return None
        size = found.magnitude / wanted.magnitude
    except Exception:  # of a word that is none pint raises whatever its parser ran into
        return None
    return (float(size), 0.0) if math.isfinite(size) and size != 0.0 else None
