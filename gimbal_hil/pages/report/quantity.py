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
    power = _power(abs(value), unit)
    return f"{_three(value / 10.0**power)} {_PREFIXES[power]}{unit}".rstrip()


def _power(size: float, unit: str) -> int:
    """Of ten, of the prefix in which a number of this size is told with three digits before its unit."""
    if _before_per(unit) not in _PREFIXED or not 0.0 < size < 0.1:
        return 0
    power = max(-9, 3 * math.floor(math.log10(size) / 3.0))
    if float(f"{size / 10.0**power:.3g}") >= 1000.0:
        power += 3
    return min(power, 0)


def from_to(first: float, second: float, unit: str) -> str:
    """`0.0192, 0.000473, "N m"` is "19.2 → 0.473 mN m": two numbers that are compared have one prefix."""
    # in the middle between both, so that neither has many digits
    power = _power(math.sqrt(abs(first * second)) or max(abs(first), abs(second)), unit)
    return f"{_three(first / 10.0**power)} → {_three(second / 10.0**power)} {_PREFIXES[power]}{unit}".rstrip()


def between(value: float, low: float, high: float, unit: str, nominal: float | None = None) -> str:
    """`0.03, 0.0299, 0.0301, "N m"` is "30 mN m (29.9 to 30.1)": a number with its interval, in one prefix, and what
    the model has in its place. An interval that five digits do not show is not told.
    """
    power = _power(max(abs(value), abs(nominal or 0.0)), unit)
    scaled = [one / 10.0**power for one in (value, low, high)]
    ends = _ends(*scaled[1:])
    prefixed = f"{_PREFIXES[power]}{unit}"
    said = f"per {unit[2:]}" if unit.startswith("1/") else "" if unit == "1" else prefixed
    is_told = math.isfinite(high - low) and ends[0] != ends[1]
    behind = [f"{ends[0]} to {ends[1]}"] if is_told else []
    behind += [] if nominal is None else [f"model: {_three(nominal / 10.0**power)} {said}".rstrip()]
    mine = _three(scaled[0])
    if is_told and not float(ends[0]) <= float(mine) <= float(ends[1]):
        # fewer digits than the ends have would put it beside them
        mine = f"{scaled[0]:.{len(ends[0].partition('.')[2])}f}"
    return f"{mine} {said}".rstrip() + (f" ({'; '.join(behind)})" if behind else "")


def _ends(low: float, high: float) -> list[str]:
    """Both ends of an interval with as many decimals as show a quarter of it, five digits at most."""
    size, width = max(abs(low), abs(high)), high - low
    if not (math.isfinite(low) and math.isfinite(high)):
        return [_three(one) if math.isfinite(one) else "without bound" for one in (low, high)]
    largest = math.floor(math.log10(size)) if size else 0
    shows = math.ceil(-math.log10(0.25 * width)) if width > 0.0 else 0
    for decimals in range(max(0, min(shows, 4 - largest)), -1, -1):
        said = [f"{one:.{decimals}f}" for one in (low, high)]
        if decimals == 0 or not all(one.endswith("0") for one in said):
            break
    return said
