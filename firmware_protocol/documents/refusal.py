"""What is wrong with a document, each thing as one line: which key, what stands there, what was expected."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from firmware_protocol.errors import BadInputError

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

Section = TypeVar("Section", bound=BaseModel)

_LONGEST_SHOWN = 60


class Refusals:
    """What is refused while a document is looked at piece by piece: kept, so that one look tells all."""

    def __init__(self) -> None:
        self._kept: list[BadInputError] = []

    @contextmanager
    def kept(self) -> Iterator[None]:
        """A refusal within is kept, and what comes after is looked at too."""
        try:
            yield
        except BadInputError as refusal:
            self._kept += (refusal, *refusal.others)

    def settle(self) -> None:
        """Raise the first of what was kept, with the others; nothing when nothing was."""
        if self._kept:
            raise _together(self._kept)


def _together(refusals: Sequence[BadInputError]) -> BadInputError:
    first, *others = refusals
    more = f" (and {len(others)} more)" if others else ""
    return BadInputError(first.where, first.problem + more, first.expected, others)


def validated(kind: type[Section], document: object, where: str, unions: Mapping[str, type[BaseModel]] = {}) -> Section:
    """A document as the section that it should be; BadInputError names the file `where`, the first key that is wrong
    and what was expected, and has the other errors beside it as `others`.

    `unions` names the members of tagged unions: pydantic has their tags in the path of an error, the file has not.
    """
    try:
        return kind.model_validate(document)
    except ValidationError as error:
        # a misspelt key tells more than the one that is missing because of it
        found = sorted(error.errors(include_url=False), key=lambda one: one["type"] != "extra_forbidden")
        raise _together([_of_one(one, where, kind, unions) for one in found if not _follows(one, found)]) from None


def _follows(one: ErrorDetails, found: Sequence[ErrorDetails]) -> bool:
    """A list with an item that is wrong is also told to be too short by that item, however many items it has."""
    if one["type"] != "too_short" or len(one["input"]) < one["ctx"]["min_length"]:
        return False
    place = one["loc"]
    return any(len(other["loc"]) > len(place) and other["loc"][: len(place)] == place for other in found)


def _of_one(one: ErrorDetails, where: str, top: type[BaseModel], kinds: Mapping[str, type[BaseModel]]) -> BadInputError:
    section: type[BaseModel] | None = top
    path: list[str] = []
    places = one["loc"]
    for index, part in enumerate(places):
        name = str(part)
        is_key = index == len(places) - 1 and one["type"] == "extra_forbidden"
        if name in kinds and not is_key and _field(section, name) is None:
            section = kinds[name]
            continue
        path.append(name[:_LONGEST_SHOWN])
        if not isinstance(part, int) and not is_key:
            section = _section(section, name)
    place = f"{where}: {'.'.join(path)}" if path else where
    if one["type"] == "extra_forbidden":
        return BadInputError(place, "unknown key", _instead(path[-1], section))
    if one["type"] == "missing":
        return BadInputError(place, "is missing", "a value")
    problem, _, expected = str(one["msg"]).removeprefix("Value error, ").partition(": expected ")
    return BadInputError(place, f"{_shown(one['input'])}{problem}", expected)


def _instead(key: str, section: type[BaseModel] | None) -> str:
    known = [field.alias or name for name, field in section.model_fields.items()] if section is not None else []
    near = difflib.get_close_matches(key, known, 1)
    return f"{near[0]}?" if near else ("one of " + ", ".join(known) if known else "a key that there is")


def _shown(value: object) -> str:
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


def _sections_in(annotation: object) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    elif get_origin(annotation) is Annotated:
        yield from _sections_in(get_args(annotation)[0])
    else:
        for inner in get_args(annotation):
            yield from _sections_in(inner)
