"""The first lines of a verdict: what was found, each cause in the field's words and numbers."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.discrepancy.judgement import Status
from gimbal_hil.pages.report import between, quantity
from sim_backend.effects import CATALOGUE

#: numbers of a cause that a headline tells; the rest stand in the table
MOST_NUMBERS = 3
#: causes of which a headline tells as many
_FEW_CAUSES = 2


def answer_of(effects: Sequence[Json], alternatives: Sequence[Json]) -> str:
    """What was found, a line for each cause; of causes that the logs cannot tell apart first that, then each."""
    lines, brief = [], is_brief(len(effects))
    for effect in effects:
        name = effect["name"], effect["axis"]
        others = [one for one in alternatives if (one["instead_of"], one["instead_of_axis"]) == name]
        unsure = effect["status"] == Status.AMBIGUOUS.value
        if unsure and others:
            lines.append(f"{at_first(_either([effect, *others]))}: these logs cannot tell which.")
        said = [f"{headline(one, brief)}." for one in (effect, *(others if unsure else ()))]
        # a name that is no more than a guess says so before it says anything else
        lines += [f"Perhaps {said[0][0].lower()}{said[0][1:]}"] if unsure and not others else said
    return "\n".join(lines)


def is_brief(causes: int) -> bool:
    """Whether there are so many causes that each has one short line."""
    return causes > _FEW_CAUSES


def _either(causes: Sequence[Json]) -> str:
    """`cable spring or static unbalance on inner`."""
    axes = {one["axis"] for one in causes}
    if len(axes) > 1:
        return " or ".join(dict.fromkeys(name_of(one["name"], one["axis"]) for one in causes))
    names = dict.fromkeys(one["name"].replace("_", " ") for one in causes)
    return f"{' or '.join(names)} on {axes.pop()}"


def headline(effect: Json, brief: bool = False) -> str:
    """A told cause in the field's words and numbers: what, where, how large, how sure. A `brief` one tells the first
    number and the order of a ripple, and not what the log could be instead.
    """
    periodic = {p.name for p in CATALOGUE[effect["name"]].parameters if p.periodic}
    told = []
    for entry in effect.get("entries") or [effect["parameters"]]:
        own = {name: number for name, number in entry.items() if name not in periodic}
        moved = {name: number for name, number in own.items() if number["value"] != number["nominal"]}
        # one that moved behind the digits that are told says nothing, unless all did
        moved = {name: number for name, number in moved.items() if _shows(number)} or moved
        # nor does one that the model lacks and that is nothing within its interval
        moved = {name: number for name, number in moved.items() if not _is_nothing(number)} or moved
        items, most = list(moved.items()), 1 if brief else MOST_NUMBERS
        those = [*items[:most], *(item for item in items[most:] if _is_order(item[1]))][:MOST_NUMBERS]
        told.append(", ".join(_number(*item, n == 0) for n, item in enumerate(those)))
    told = [one for one in told if one] or ["its numbers are not known"]
    where = at_first(name_of(effect["name"], effect["axis"]))
    of_log = f", or {effect['or_in_the_log']}" if "or_in_the_log" in effect and not brief else ""
    return f"{where}: {' and '.join(told)}{of_log}; probability {effect['probability']:.2f}"


def _shows(number: Json) -> bool:
    unit, nominal = number["unit"], number["nominal"]
    return nominal is None or quantity(number["value"], unit) != quantity(nominal, unit)


def _is_nothing(number: Json) -> bool:
    return number["nominal"] is None and number["low"] <= 0.0 <= number["high"] and _is_wide(number)


def _is_wide(number: Json) -> bool:
    """Whether the interval of a number is wider than twice the number."""
    return bool(abs(number["value"]) < 0.5 * (number["high"] - number["low"]))


def _is_order(number: Json) -> bool:
    """Whether it is told as "8 per turn", which says what it is."""
    return bool(number["unit"].startswith("1/"))


def _number(name: str, number: Json, first: bool) -> str:
    """A number of a cause; the first one, which says how large it is, with its interval."""
    said = _as_known(number, first)
    return said if _is_order(number) else f"{name.replace('_', ' ')} {said}"


def _as_known(number: Json, with_interval: bool) -> str:
    """A value where its interval is narrower than it, else how far the interval goes."""
    value, low, high, unit, nominal = (number[key] for key in ("value", "low", "high", "unit", "nominal"))
    if not _is_wide(number):
        return between(value, *((low, high) if with_interval else (value, value)), unit, nominal=nominal)
    # what is nothing within its interval has no digits of its own; of a factor half as much and twice are as near
    nothing = low <= 0.0 <= high
    spread = quantity(0.5 * (high - low), unit)
    said = f"0 \u00b1 {spread}" if nothing else f"{quantity(low, unit)} to {quantity(high, unit)}"
    return said if nominal is None else f"{said} (model: {quantity(nominal, unit)})"


def at_first(said: str) -> str:
    """At the start of a sentence; names of axes stay as they are written."""
    return said[0].upper() + said[1:]


def name_of(effect: str, axis: str) -> str:
    return f"{effect.replace('_', ' ')} on {axis}"
