"""Tables of the keys of a section for the pages of `docs/`, made from the class that validates the section.

Units stand in the names of keys (`rate_rad_s`); the table writes them out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pydantic import BaseModel

from firmware_protocol.documents.strict import LARGEST_NUMBER

#: endings of keys and the unit that they stand for, the longest first
_UNITS = {
    "_nm_s_per_rad": "N m s/rad",
    "_kg_m2": "kg m^2",
    "_rad_s2": "rad/s^2",
    "_nm_s": "N m/s",
    "_rad_s": "rad/s",
    "_per_s2": "1/s^2",
    "_kg_m": "kg m",
    "_degc": "degC",
    "_ticks": "ticks",
    "_turns": "turns",
    "_per_s": "1/s",
    "_rad": "rad",
    "_mb": "MiB",
    "_nm": "N m",
    "_hz": "Hz",
    "_s": "s",
}
#: units that hold a quantity per another, which the ending of the key alone would hide
_NO_UNIT = ("kp_s_per_rad", "ki_per_rad")
#: a bound that is larger than this is one of the machine, not of the quantity
_LARGE = 1e9
#: an additional column: its head, and the cell for a key
Column = tuple[str, Callable[[str], str]]


def key_table(section: type[BaseModel], but: tuple[str, ...] = (), column: Column | None = None) -> list[str]:
    """Markdown lines of a section's keys: type with bounds and unit, default, meaning, and the column asked for.

    Keys in `but` are left out. AssertionError for a key without a description, because its row would say nothing.
    """
    schema = section.model_json_schema()
    heads = ["key", "value", "default", *([column[0]] if column else []), "meaning"]
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for key, entry in schema["properties"].items():
        if key in but:
            continue
        assert entry.get("description"), f"{section.__name__}.{key} has no description"
        default = "**needed**" if key in schema.get("required", ()) else _default(entry)
        cells = [f"`{key}`", _value(key, entry, schema.get("$defs", {})), default]
        lines.append(f"| {' | '.join([*cells, *([column[1](key)] if column else []), entry['description']])} |")
    return lines


def _default(entry: Mapping[str, Any]) -> str:
    default = entry.get("default")
    if default is None:
        return ""
    if isinstance(default, bool):
        return "yes" if default else "no"
    if isinstance(default, dict):
        return "see below" if default else ""
    return "" if default in ("", []) else f"{default}"


def _value(key: str, entry: Mapping[str, Any], definitions: Mapping[str, Any]) -> str:
    kind = next((one for one in entry.get("anyOf", ()) if one.get("type") != "null"), entry)
    target = definitions.get(str(kind.get("$ref", "")).rpartition("/")[2], {})
    if "enum" in target:
        return ", ".join(f"`{one}`" for one in target["enum"])
    if "enum" in kind:
        return ", ".join(f"`{one}`" for one in kind["enum"])
    if "const" in kind:
        return f"`{kind['const']}`"
    unit = "" if key in _NO_UNIT else next((unit for ending, unit in _UNITS.items() if key.endswith(ending)), "")
    if kind.get("type") in ("number", "integer"):
        whole = "whole" if kind["type"] == "integer" else ""
        return ", ".join(part for part in (whole, _bounds(kind) or ("" if whole else "number"), unit) if part)
    if kind.get("type") == "array":
        count = kind.get("maxItems")
        length = "" if not count else f" of {count}" if kind.get("minItems") == count else f" of up to {count}"
        return ", ".join(part for part in ("list" + length, unit) if part)
    words = {"boolean": "yes or no", "string": "path" if kind.get("format") == "path" else "text", "object": "mapping"}
    return words.get(kind.get("type", ""), "section")


def _bounds(kind: Mapping[str, Any]) -> str:
    """The bounds of a number in words, without those that every number has."""
    low, above = kind.get("minimum", -LARGEST_NUMBER), kind.get("exclusiveMinimum")
    high, below = kind.get("maximum", _LARGE), kind.get("exclusiveMaximum", _LARGE)
    said = []
    if above is not None:
        said.append(f"above {above:g}")
    elif low > -LARGEST_NUMBER:
        said.append(f"from {low:g}")
    if below < _LARGE:
        said.append(f"below {below:g}")
    elif high < _LARGE:
        said.append(f"to {high:g}")
    return " ".join(said)
