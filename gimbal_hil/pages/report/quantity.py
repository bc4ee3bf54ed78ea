"""Numbers as people say them: three digits, and a prefix of the unit that leaves none of them behind zeros."""

from __future__ import annotations

import math

#: units that a prefix goes before; a kilogram has one, and squares and shares take none
_PREFIXED = ("N m", "N", "rad", "m", "s", "Hz", "W", "A", "V")
_PREFIXES = {-9: "n", -6: "\u00b5", -3: "m", 0: ""}


def counted(count: int, one: str, many: str = "") -> str:
    """`1, "row"` is "1 row", `3, "row"` is "3 rows"; `many` where an s does not do."""
    return f"{count} {one if count == 1 else many or f'{one}s'}"


def _three(value: float) -> str:
    """Three digits, or all before the point where there are more: no exponent below ten millions."""
    return f"{value:.0f}" if 999.5 <= abs(value) < 1e7 else f"{value:.3g}"


def _before_per(unit: str) -> str:
    """`rad` of rad/s, `N m` of N m s/rad: what a prefix goes before."""
    return unit if unit in _PREFIXED else unit.split("/")[0].split(" s")[0]


def scaled_unit(size: float, unit: str) -> tuple[float, str]:
    """A factor and the unit after it, in which numbers of up to this size are told: `3e-6, "rad"` is (1e6, "µrad")."""
    if _before_per(unit) not in _PREFIXED or not 0.0 < size < 0.1:
        return 1.0, unit
    power = max(-9, 3 * math.floor(math.log10(size) / 3.0))
    return 10.0**-power, f"{_PREFIXES[power]}{unit}"


def quantity(value: float, unit: str) -> str:
    """`0.012, "N m"` is "12 mN m"; `8, "1/turn"` is "8 per turn"; a unit of "1" is not said."""
    if not math.isfinite(value):
        return "-" if math.isnan(value) else "without bound"
    if unit == "1":
        return _three(value)
    if unit.startswith("1/"):
        return f"{_three(value)} per {unit[2:]}"
    size = abs(value)
    if _before_per(unit) not in _PREFIXED or size == 0.0 or size >= 0.1:
        return f"{_three(value)} {unit}".rstrip()
    power = max(-9, 3 * math.floor(math.log10(size) / 3.0))
    if float(f"{size / 10.0**power:.3g}") >= 1000.0:
        power += 3
    power = min(power, 0)
    return f"{value / 10.0**power:.3g} {_PREFIXES[power]}{unit}"
