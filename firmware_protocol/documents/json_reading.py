"""JSON read with limits: one object, keys once, finite numbers, whole characters."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from firmware_protocol.documents.limits import LIMITS, DocumentLimits, number_problem, read_text, text_of, text_problem
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json


def read_json(path: Path, expected: str, limits: DocumentLimits = LIMITS) -> Json:
    """The one JSON object in a file; BadInputError names the file, the place and what was expected."""
    return json_line(read_text(path, expected, limits), str(path), expected, limits)


def json_line(data: bytes | str, where: str, expected: str, limits: DocumentLimits = LIMITS) -> Json:
    """The one JSON object that a text holds; BadInputError as in `read_json`."""
    text = text_of(data, where, expected, limits)
    if text.count(",") > limits.values:
        raise BadInputError(where, f"holds more than {limits.values} values", expected)
    try:
        document = json.loads(text, object_pairs_hook=_each_key_once)
    except _RefusedError as refused:
        raise BadInputError(where, str(refused), expected) from None
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, " if error.lineno > 1 else ""
        raise BadInputError(where, f"is not JSON ({place}column {error.colno}: {error.msg})", expected) from None
    except RecursionError:
        raise BadInputError(where, f"is nested deeper than {limits.depth} levels", expected) from None
    except ValueError:
        # the interpreter itself refuses integers of thousands of digits
        raise BadInputError(where, f"holds an integer of more than {limits.digits} digits", expected) from None
    if not isinstance(document, dict):
        raise BadInputError(where, "is no JSON object", expected)
    _check(document, where, expected, limits)
    return document


class _RefusedError(Exception):
    pass


def _each_key_once(pairs: list[tuple[str, object]]) -> Json:
    table = dict(pairs)
    if len(table) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise _RefusedError(f"has the key {twice[:80]!r} twice")
    return table


def _plain_numbers(values: list[Any]) -> bool:
    """Whether these are finite numbers of sensible size: the quick way through a long table."""
    return set(map(type, values)) <= {float, int} and all(abs(value) < 1e30 for value in values)


def _check(document: Json, where: str, expected: str, limits: DocumentLimits) -> None:
    """Depth, count, numbers and texts; level by level, so that no nesting can exhaust the stack."""
    level: list[tuple[str, Any]] = [("", document)]
    count = 0
    for _ in range(limits.depth + 1):
        below: list[tuple[str, Any]] = []
        for path, container in level:
            items = container.items() if isinstance(container, dict) else enumerate(container)
            count += len(container)
            if count > limits.values:
                raise BadInputError(where, f"holds more than {limits.values} values", expected)
            if isinstance(container, list) and _plain_numbers(container):
                continue
            for key, value in items:
                problem = text_problem(key) if isinstance(key, str) else None
                if isinstance(value, dict | list):
                    below.append((f"{path}{key}.", value))
                elif isinstance(value, str):
                    problem = problem or text_problem(value)
                elif isinstance(value, int | float):
                    problem = problem or number_problem(value, limits)
                if problem is not None:
                    raise BadInputError(
                        f"{where}: {path}{key}".encode(errors="replace").decode(), f"is or holds {problem}", expected
                    )
        if not below:
            return
        level = below
    raise BadInputError(where, f"is nested deeper than {limits.depth} levels", expected)
