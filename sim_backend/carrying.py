"""Which joint carries which: stated by `parent:`, never by the order in which axes stand in a file."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

#: words that stand beside the names of axes in columns and requests
_TAKEN = {
    "base",
    "command",
    "duration_s",
    "id",
    "label",
    "mode",
    "over_s",
    "program",
    "repeat",
    "segments",
    "switch_off_afterwards",
}
_NAME = re.compile(r"[^\W\d][\w-]*")
#: names that say it themselves, so that files without `parent:` are understood
OUTER, INNER = "outer", "inner"


def in_order(parents: Mapping[str, str | None]) -> tuple[str, ...]:
    """The axes (name -> `parent:`, None where there is none) with the carrying one first; ValueError says what is wrong
    and expected.
    """
    names = tuple(parents)
    if len(names) == 1:
        if parents[names[0]] is not None:
            raise ValueError(f"{names[0]} is the only axis and has a parent: expected no parent")
        return names
    if len(names) != 2:
        raise ValueError(f"{len(names)} axes: expected two, one of which carries the other")
    carried = [name for name in names if parents[name] is not None]
    if not carried and set(names) == {OUTER, INNER}:
        return (OUTER, INNER)
    first, second = names
    if not carried:
        expected = f"parent: {first} under {second}, or parent: {second} under {first}"
        raise ValueError(f"which of {first} and {second} carries the other is not said: expected {expected}")
    if len(carried) == 2:
        raise ValueError(f"{first} and {second} both have a parent: expected none on the axis that turns on the base")
    inner = carried[0]
    outer = second if inner == first else first
    if parents[inner] != outer:
        raise ValueError(f"the parent of {inner} is {parents[inner]!r}: expected {outer}")
    return (outer, inner)


def require_plain_names(names: Iterable[str]) -> None:
    """ValueError when an axis has a name that columns (`<axis>.torque`) or requests could not be told by."""
    for name in names:
        if not _NAME.fullmatch(name) or name in _TAKEN:
            raise ValueError(
                f"{name!r} cannot be the name of an axis: expected a word such as azimuth, and none of "
                f"{', '.join(sorted(_TAKEN))}"
            )
