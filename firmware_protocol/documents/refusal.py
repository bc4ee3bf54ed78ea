"""The first thing that is wrong with a document, as one line: which key, what stands there, what was expected."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from firmware_protocol.errors import BadInputError

_LONGEST_SHOWN = 60


def refusal_of(
    error: ValidationError, where: str, top: type[BaseModel], kinds: Mapping[str, type[BaseModel]] = {}
) -> BadInputError:
    """What validation against `top` found first, with the file `where`.

    `kinds` names the members of tagged unions: their tags stand in pydantic's path of an error, but not in the file.
    """
    # a misspelt key tells more than the one that is missing because of it
    first = min(error.errors(include_url=False), key=lambda one: one["type"] != "extra_forbidden")
    section: type[BaseModel] | None = top
    path: list[str] = []
    places = first["loc"]
    for index, part in enumerate(places):
        name = str(part)
        is_key = index == len(places) - 1 and first["type"] == "extra_forbidden"
        if name in kinds and not is_key and _field(section, name) is None:
            section = kinds[name]
            continue
        path.append(name[:_LONGEST_SHOWN])
        if not isinstance(part, int) and not is_key:
            section = _section(section, name)
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    place = f"{where}: {'.'.join(path)}" if path else where
    if first["type"] == "extra_forbidden":
        return BadInputError(place, f"unknown key{more}", _instead(path[-1], section))
    if first["type"] == "missing":
        return BadInputError(place, f"is missing{more}", "a value")
    problem, _, expected = str(first["msg"]).removeprefix("Value error, ").partition(": expected ")
    return BadInputError(place, f"{_shown(first['input'])}{problem}{more}", expected)


def _instead(key: str, section: type[BaseModel] | None) -> str:
    known = [field.alias or name for name, field in section.model_fields.items()] if section is not None else []
    near = difflib.get_close_matches(key, known, 1)
    return f"{near[0]}?" if near else ("one of " + ", ".join(known) if known else "a key that there is")


def _shown(value: Any) -> str:
    """What stands there, where that is short enough to help."""
    if value is None or isinstance(value, dict | list | tuple | BaseModel):
        return ""
    text = repr(value)
    return (text if len(text) <= _LONGEST_SHOWN else text[:_LONGEST_SHOWN] + "...") + ": "


def _field(section: type[BaseModel] | None, name: str) -> Any:
    """The field that a key of a section names, None where there is none."""
    if section is None:
        return None
    return next((field for key, field in section.model_fields.items() if name in (key, field.alias)), None)


def _section(section: type[BaseModel] | None, name: str) -> type[BaseModel] | None:
    """The section that a key leads to; None where a tag decides which section it is. A free key (the name of an axis)
    leads no further.
    """
    field = _field(section, name)
    if field is None:
        return section
    found = list(_sections_in(field.annotation))
    return found[0] if len(found) == 1 else None


def _sections_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    elif get_origin(annotation) is Annotated:
        yield from _sections_in(get_args(annotation)[0])
    else:
        for inner in get_args(annotation):
            yield from _sections_in(inner)
