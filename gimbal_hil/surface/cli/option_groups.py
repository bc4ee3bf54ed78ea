"""A command's options as frozen values: a parameter whose type is a dataclass of options stands for its fields.

A field is written as a parameter of typer: `Annotated[type, typer.Option(...)] = default`. What several commands take
(`log_options`) is one dataclass; what one command takes many of is its own.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from functools import wraps
from typing import Any, get_type_hints


def with_groups(command: Callable[..., int]) -> Callable[..., int]:
    """A command as typer takes it: every field of its groups is a parameter, in the order of the groups."""
    signature = inspect.signature(command, eval_str=True)
    groups: dict[str, Any] = {
        name: one.annotation for name, one in signature.parameters.items() if is_dataclass(one.annotation)
    }
    if not groups:
        return command

    @wraps(command)
    def flat(**given: Any) -> int:
        for name, group in groups.items():
            given[name] = group(**{one.name: given.pop(one.name) for one in fields(group)})
        return command(**given)

    spread: list[inspect.Parameter] = []
    for name, parameter in signature.parameters.items():
        spread += _fields_of(groups[name]) if name in groups else [parameter]
    flat.__dict__.pop("__wrapped__")
    flat.__dict__["__signature__"] = signature.replace(parameters=[_keyword(one) for one in spread])
    flat.__annotations__ = {one.name: one.annotation for one in spread} | {"return": int}
    return flat


def _fields_of(group: Any) -> list[inspect.Parameter]:
    types = get_type_hints(group, include_extras=True)
    return [
        inspect.Parameter(
            one.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=inspect.Parameter.empty if one.default is MISSING else one.default,
            annotation=types[one.name],
        )
        for one in fields(group)
    ]


def _keyword(parameter: inspect.Parameter) -> inspect.Parameter:
    """By name alone, so that one without a default may follow one with it."""
    return parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY)
