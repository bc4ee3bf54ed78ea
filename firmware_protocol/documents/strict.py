"""The base of every section of a document: unknown keys are refused, values do not change, and a number is a number.

Pydantic would read `true` as 1 and "3" as 3, and takes 1e300 as readily as 1; here an integer or float must be written
as one and be no larger than anything that this project measures in.
"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict

#: no quantity in SI units, no count and no duration that makes sense here is larger
LARGEST_NUMBER = 1e15

#: entries of a core schema that hold values, not schemas
_VALUES = ("default", "metadata", "serialization", "expected", "members", "cls")


def with_strict_numbers(schema: Any) -> Any:
    """A core schema of pydantic in which every integer and float is strict and bounded."""
    if isinstance(schema, list | tuple):
        return type(schema)(with_strict_numbers(item) for item in schema)
    if not isinstance(schema, dict):
        return schema
    changed = {key: value if key in _VALUES else with_strict_numbers(value) for key, value in schema.items()}
    if changed.get("type") in ("float", "int"):
        largest = LARGEST_NUMBER if changed["type"] == "float" else int(LARGEST_NUMBER)
        changed["strict"] = True
        if not {"lt", "le"} & changed.keys():
            changed["le"] = largest
        if not {"gt", "ge"} & changed.keys():
            changed["ge"] = -largest
    return changed


class Strict(BaseModel):
    """Base of a section."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> Any:
        return with_strict_numbers(handler(source))
