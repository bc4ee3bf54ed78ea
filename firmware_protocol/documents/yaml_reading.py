"""YAML read with limits: the core schema of YAML 1.2 and nothing that surprises.

Plain `true`, `false`, `null` and numbers are what they look like, everything else is text: no dates, no base 60, no
octal by a leading zero, no tags. `1e-3` is a number. A key is text, stands once in its table, and a file holds one
document. An alias is copied, and counts for the limits as often as it is used. The document is built from the parser's
events on a stack of its own, so that no nesting exhausts the interpreter's. Source: YAML 1.2.2, section 10.3 (core
schema).
"""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firmware_protocol.documents.limits import LIMITS, DocumentLimits, number_problem, read_text, text_of, text_problem
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json

if TYPE_CHECKING:
    from yaml.events import Event

_CONSTANTS = {"": None, "~": None} | {
    form: value
    for word, value in (("null", None), ("true", True), ("false", False))
    for form in (word, word.title(), word.upper())
}
_INTEGER = re.compile(r"[-+]?[0-9]+")
_HEXADECIMAL = re.compile(r"0x[0-9a-fA-F]+")
#: also what a writer must put in quotes to have it read as text
FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_NO_KEY = object()


def read_yaml(path: Path, expected: str, limits: DocumentLimits = LIMITS) -> Json:
    """The table of keys in a YAML file; BadInputError names the file, the line and what was expected."""
    return yaml_mapping(read_text(path, expected, limits), str(path), expected, limits)


def yaml_mapping(data: bytes | str, where: str, expected: str, limits: DocumentLimits = LIMITS) -> Json:
    """The table of keys that a YAML text holds; BadInputError as in `read_yaml`."""
    import yaml

    text = text_of(data, where, expected, limits)
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        document = _built(yaml.parse(text, Loader=loader), limits)
    except _RefusedError as refused:
        raise BadInputError(f"{where}: line {refused.line}", refused.problem, expected) from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f" at line {mark.line + 1}" if mark else ""
        problem = " ".join(str(getattr(error, "problem", None) or getattr(error, "reason", None) or error).split())
        raise BadInputError(where, f"is not YAML{place}: {problem}", expected) from None
    except (ValueError, OverflowError, RecursionError) as error:
        raise BadInputError(where, f"is not YAML: {' '.join(str(error).split())[:120]}", expected) from None
    if not isinstance(document, dict):
        raise BadInputError(where, "holds no mapping", expected)
    return document


class _RefusedError(Exception):
    def __init__(self, event: Event, problem: str) -> None:
        self.line, self.problem = _line(event), problem
        super().__init__(problem)


def _line(event: Event) -> int:
    return event.start_mark.line + 1 if event.start_mark else 0


@dataclass(slots=True)
class _Open:
    """A table or list that is being read; `values` counts what is in it, `depth` how deep it goes below itself."""

    content: Json | list[Any]
    anchor: str | None
    key: Any = _NO_KEY
    lines: dict[str, int] = field(default_factory=dict)
    values: int = 1
    depth: int = 1


@dataclass(slots=True)
class _Anchored:
    value: Any
    values: int
    depth: int


def _built(events: Iterator[Event], limits: DocumentLimits) -> Any:
    """The one document of a stream of events."""
    import yaml

    stack: list[_Open] = []
    anchors: dict[str, _Anchored] = {}
    result: Any = None
    values, documents = 0, 0
    for event in events:
        if isinstance(event, yaml.DocumentStartEvent):
            documents += 1
            if documents > 1:
                raise _RefusedError(event, "a second document begins")
            continue
        if isinstance(event, yaml.MappingStartEvent | yaml.SequenceStartEvent):
            _refuse_tag(event)
            if len(stack) >= limits.depth:
                raise _RefusedError(event, f"is nested deeper than {limits.depth} levels")
            if stack and isinstance(stack[-1].content, dict) and stack[-1].key is _NO_KEY:
                raise _RefusedError(event, "a table or list cannot be a key")
            stack.append(_Open({} if isinstance(event, yaml.MappingStartEvent) else [], event.anchor))
            continue
        if isinstance(event, yaml.ScalarEvent):
            is_key = bool(stack) and isinstance(stack[-1].content, dict) and stack[-1].key is _NO_KEY
            done = _Anchored(_scalar(event, is_key, limits), 1, 0)
            if event.anchor:
                anchors[event.anchor] = done
        elif isinstance(event, yaml.AliasEvent):
            if event.anchor not in anchors:
                raise _RefusedError(event, f"the alias *{event.anchor} stands for nothing that is complete before it")
            done = anchors[event.anchor]
        elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
            closed = stack.pop()
            done = _Anchored(closed.content, closed.values, closed.depth)
            if closed.anchor:
                anchors[closed.anchor] = done
        else:
            continue
        values += 1 if not isinstance(event, yaml.AliasEvent) else done.values
        if values > limits.values:
            raise _RefusedError(event, f"holds more than {limits.values} values")
        if len(stack) + done.depth > limits.depth:
            raise _RefusedError(event, f"is nested deeper than {limits.depth} levels")
        if isinstance(event, yaml.AliasEvent):
            done = _Anchored(copy.deepcopy(done.value), done.values, done.depth)
        if stack:
            _put(stack[-1], done, event)
        else:
            result = done.value
    return result


def _put(parent: _Open, done: _Anchored, event: Event) -> None:
    """One more value, or one more key, of an open table or list."""
    content = parent.content
    if isinstance(content, list):
        content.append(done.value)
    elif parent.key is _NO_KEY:
        key = done.value
        if not isinstance(key, str):
            raise _RefusedError(event, "a key must be text")
        if key in parent.lines:
            raise _RefusedError(event, f"the key {key[:80]!r} stands here again, first in line {parent.lines[key]}")
        parent.key, parent.lines[key] = key, _line(event)
        return
    else:
        content[parent.key], parent.key = done.value, _NO_KEY
    parent.values += done.values
    parent.depth = max(parent.depth, done.depth + 1)


def _refuse_tag(event: Any) -> None:
    if event.tag is not None:
        raise _RefusedError(event, f"the tag {event.tag[:80]!r} is not read; write the plain value")


def _scalar(event: Any, is_key: bool, limits: DocumentLimits) -> Any:
    _refuse_tag(event)
    text: str = event.value
    problem = text_problem(text)
    if problem is not None:
        raise _RefusedError(event, f"holds {problem}")
    if is_key or not event.implicit[0]:
        return text
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    number = _number(event, text, limits)
    if number is None:
        return text
    problem = number_problem(number, limits)
    if problem is not None:
        raise _RefusedError(event, f"{text[:40]} is {problem}")
    return number


def _number(event: Event, text: str, limits: DocumentLimits) -> float | None:
    """A plain scalar as a number, None where it is text."""
    if _INTEGER.fullmatch(text):
        digits = text.lstrip("+-")
        if len(digits) > limits.digits:
            raise _RefusedError(event, f"{text[:20]}... is an integer of more than {limits.digits} digits")
        if len(digits) > 1 and digits[0] == "0":
            raise _RefusedError(
                event, f"{text} may be meant as octal or decimal; write it without the zero in front, or in quotes"
            )
        return int(text)
    if _HEXADECIMAL.fullmatch(text):
        return int(text[: limits.digits + 2], 16)
    if FLOAT.fullmatch(text):
        return float(text)
    if _NOT_FINITE.fullmatch(text):
        raise _RefusedError(event, f"{text} is no finite number")
    return None
