"""Friction over temperature in words: the answer, a table for each axis, and what is open, each said once."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gimbal_hil.knowledge.identification.estimate import Determination, Estimate, number_text
from gimbal_hil.knowledge.identification.over_temperature import TemperatureResult, gaps, uncovered
from gimbal_hil.knowledge.identification.stribeck import LUGRE_NAMES


def answer(found: Sequence[TemperatureResult]) -> str:
    """At which temperatures, how many numbers were identified, and what of the range is missing."""
    told = [e for one in found for result in one.results for e in result.estimates if e.name in LUGRE_NAMES]
    sure = sum(e.verdict is Determination.IDENTIFIED for e in told)
    temperatures = ", ".join(f"{one.temperature_degc:.0f}" for one in found)
    missing = uncovered(found)
    said = f"Friction at {temperatures} degC; {sure} of {len(told)} numbers identified."
    return f"{said} {missing[:1].upper()}{missing[1:]}." if missing else said


def axes_of(found: Sequence[TemperatureResult]) -> list[str]:
    """The axes that were identified."""
    return [result.axis for result in found[0].results]


def rows_of(found: Sequence[TemperatureResult], axis: str) -> list[tuple[str, ...]]:
    """Of an axis' table: temperature, then numbers with half of their intervals; in brackets those of the prior."""
    return [(f"{one.temperature_degc:.1f}", *(_cell(_of(one, axis), name) for name in LUGRE_NAMES)) for one in found]


def over_temperature_lines(found: Sequence[TemperatureResult]) -> list[str]:
    """For the terminal."""
    lines = [answer(found)]
    for axis in axes_of(found):
        units = {e.name: e.unit for e in _of(found[0], axis)}
        header = ("degC", *(f"{name} [{units[name]}]" if name in units else name for name in LUGRE_NAMES))
        rows = [header, *rows_of(found, axis)]
        widths = [max(len(row[i]) for row in rows) for i in range(len(header))]
        lines += ["", axis]
        lines += ["  " + "  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True)) for row in rows]
    lines += [
        "",
        "half of the 95 % interval behind each number; in brackets what was not identified: the prior's is kept",
    ]
    return lines + [f"  ! {one}" for one in [*still_open(found), *gaps(found)]]


def still_open(found: Sequence[TemperatureResult]) -> list[str]:
    """Numbers that no data settled, and rules that numbers violate."""
    return [*_unsettled(found), *_contradictions(found)]


def _of(one: TemperatureResult, axis: str) -> tuple[Estimate, ...]:
    return next(tuple(result.estimates) for result in one.results if result.axis == axis)


def _cell(estimates: Sequence[Estimate], name: str) -> str:
    found = next((e for e in estimates if e.name == name), None)
    if found is None:
        return "-"
    if found.verdict is Determination.NOT_IDENTIFIED:
        return f"({number_text(found.value, 4)})"
    return within(found.value, found.interval.half_width)


def within(value: float, half: float) -> str:
    """A number and half of its interval with as many decimals as give that two digits, and no exponent."""
    if not (math.isfinite(half) and half > 0.0):
        return number_text(value, 4)
    decimals = max(0, 1 - math.floor(math.log10(half)))
    return f"{value:.{decimals}f} ± {half:.{decimals}f}"


def _unsettled(found: Sequence[TemperatureResult]) -> list[str]:
    """Numbers that no data settled, all that lack the same in one sentence."""
    lacking: dict[tuple[str, str], dict[str, list[float]]] = {}
    for one in found:
        for result in one.results:
            for e in result.estimates:
                if e.reason and e.name in LUGRE_NAMES:
                    numbers = lacking.setdefault((e.reason, e.experiment), {})
                    numbers.setdefault(f"{result.axis} {e.name}", []).append(one.temperature_degc)
    told = []
    for (reason, experiment), numbers in lacking.items():
        every = all(len(where) == len(found) for where in numbers.values())
        names = ", ".join(name if every else f"{name} ({_degrees(where)})" for name, where in numbers.items())
        told.append(f"{names}: {reason}" + (f"; to settle it: {experiment}" if experiment else ""))
    return told


def _contradictions(found: Sequence[TemperatureResult]) -> list[str]:
    """Each rule that an axis' numbers violate, as it is told of the coldest temperature, and where else."""
    told: dict[tuple[str, str], tuple[str, list[float]]] = {}
    for one in found:
        for result in one.results:
            for finding in result.findings:
                told.setdefault((result.axis, finding.rule), (finding.text, []))[1].append(one.temperature_degc)
    return [
        f"{axis} at {where[0]:.0f} degC: {text}" + (f" (and at {_degrees(where[1:])})" if len(where) > 1 else "")
        for (axis, _), (text, where) in told.items()
    ]


def _degrees(where: Sequence[float]) -> str:
    return f"{', '.join(f'{degc:.0f}' for degc in where)} degC"
