"""Documents made wrong: by value (any leaf or branch becomes something it should not be) and by text (bytes, lines,
indents).
"""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable, Iterator
from random import Random
from typing import Any

Path = tuple[str | int, ...]

#: what people and programs write by accident, and what an attacker writes on purpose
NASTY: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2**31, 2**63, 2**64, 10**40, 10**400, -(2**63), 0.5, -0.0, 1e-320, 1e15, 1e18, 1e300,
    -1e300,
    math.inf, -math.inf, math.nan, "", " ", "0", "1", "-1", "1e3", "true", "yes", "inf", "nan", "outer", "off",
    "x" * 5000, "é", "\ud800",
    "\x00", "../../etc/passwd", "[]", [], [0], [[]], [1e300] * 3, ["a", "b"], list(range(50)), {}, {"value": 1},
    {"value": None},
    {"value": math.nan, "unit": "N m"}, {"": 0}, {"a": {"a": {"a": {}}}},
)  # fmt: skip

#: plain scalars of YAML that other readers take for dates, base 60, octal, tags, aliases, merges
NASTY_TEXT = (
    "2026-13-45", "2026-02-30T25:61:61Z", "0001-01-01", "1:30", "190:20:30", "010", "0o17", "0x", "0b101", "1_000",
    "1" * 5000, "1e400",
    ".inf", "-.inf", ".nan", "!!float abc", "!!int 1", "!!timestamp 2026-13-45", "!!binary =",
    "!!python/object:os.system x", "!local x",
    "*missing", "&a [*a]", "<<: {a: 1}", "~", "null", "'", '"', '"\\ud800"', '"\\U00110000"', "[", "]", "{", "}",
    "[" * 1500, "{a: " * 400,
    "- - -", "? a", ": :", "|", ">", "%YAML 9.9", "---", "...", "@", "`", "\t", "#", "\x00", "\x85", "\ufeff", "\u2028",
    "y: y: y",
)  # fmt: skip


def places(value: Any, path: Path = ()) -> Iterator[Path]:
    """The path of every value in a document, the document itself first."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


def mutated(document: dict[str, Any], random: Random) -> Any:
    """A copy with one to three things wrong in it."""
    changed: Any = copy.deepcopy(document)
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        path = random.choice(list(places(changed)))
        if path:
            changed = _changed_at(changed, path, random)
        elif random.random() < 0.2:
            return copy.deepcopy(random.choice(NASTY))
    return changed


def _changed_at(document: Any, path: Path, random: Random) -> Any:
    holder = document
    for key in path[:-1]:
        holder = holder[key]
    last = path[-1]
    change = random.randrange(6)
    if change == 0:
        del holder[last]
    elif change == 1 and isinstance(holder, dict) and isinstance(last, str):
        holder[last + random.choice(("x", "", " ", "\ud800", "s" * 300))] = holder.pop(last)
    elif change == 2:
        other = random.choice([place for place in places(document) if place != path[: len(place)]] or [path])
        holder[last] = copy.deepcopy(_at(document, other))
    elif change == 3 and isinstance(holder[last], list) and holder[last]:
        holder[last] = holder[last] * random.choice((0, 2, 40))
    elif (
        change == 4
        and isinstance(holder[last], float | int)
        and not isinstance(holder[last], bool)
        and abs(holder[last]) < 1e18
    ):
        number = holder[last]
        holder[last] = random.choice((-number, number * 1e6, number * 1e-9, str(number), int(number)))
    else:
        holder[last] = copy.deepcopy(random.choice(NASTY))
    return document


def _at(document: Any, path: Path) -> Any:
    for key in path:
        document = document[key]
    return document


def mutated_text(text: str, random: Random) -> bytes:
    """A text with one to four things wrong in it: bytes, lines, indents, scalars."""
    lines = text.split("\n")
    for _ in range(random.choice((1, 1, 2, 4))):
        at = random.randrange(len(lines))
        random.choice(_LINE_CHANGES)(lines, at, random)
        if not lines:
            lines = [""]
    data = bytearray("\n".join(lines).encode(errors="surrogatepass"))
    if data and random.random() < 0.3:
        for _ in range(random.choice((1, 2, 20))):
            data[random.randrange(len(data))] = random.randrange(256)
    if random.random() < 0.05:
        del data[random.randrange(len(data) + 1) :]
    return bytes(data)


def _replace_scalar(lines: list[str], at: int, random: Random) -> None:
    head, colon, _ = lines[at].partition(":")
    lines[at] = f"{head}{colon} {random.choice(NASTY_TEXT)}"


def _double(lines: list[str], at: int, random: Random) -> None:
    lines.insert(random.randrange(len(lines) + 1), lines[at])


def _indent(lines: list[str], at: int, random: Random) -> None:
    lines[at] = random.choice((" ", "  ", "\t", "- ", "? ")) + lines[at]


def _dedent(lines: list[str], at: int, _random: Random) -> None:
    lines[at] = lines[at][2:]


def _insert(lines: list[str], at: int, random: Random) -> None:
    lines.insert(at, random.choice(NASTY_TEXT))


def _drop(lines: list[str], at: int, _random: Random) -> None:
    del lines[at]


_LINE_CHANGES: tuple[Callable[[list[str], int, Random], None], ...] = (
    _replace_scalar, _replace_scalar, _replace_scalar, _double, _indent, _dedent, _insert, _drop,
)  # fmt: skip


def json_text(document: Any) -> str:
    """A document as JSON, with the NaN and half characters that JSON should not hold."""
    return json.dumps(document)
