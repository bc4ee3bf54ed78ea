"""The JSON schema (draft 2020-12) of changed.json, for programs that read it."""

from __future__ import annotations

from gimbal_hil.knowledge.change.comparing import ChangeKind, Heard
from gimbal_hil.knowledge.discrepancy import Status

Schema = dict[str, object]
_TEXT: Schema = {"type": "string"}
_NUMBER: Schema = {"type": "number"}
_PROBABILITY: Schema = {"type": "number", "minimum": 0, "maximum": 1}


def _or_none(one: Schema) -> Schema:
    return {"anyOf": [one, {"type": "null"}]}


def _of(description: str, needed: Schema, **optional: Schema) -> Schema:
    """An object that has the needed keys, perhaps the optional ones, and perhaps others that `verdict.md` lists."""
    return {
        "type": "object",
        "description": description,
        "properties": {**needed, **optional},
        "required": list(needed),
    }


def _list(one: Schema) -> Schema:
    return {"type": "array", "items": one}


_WHERE = {"name": _TEXT, "axis": _TEXT}
_PARAMETER = _of(
    "a number with its interval; nominal is the one before, null for an effect that was not there",
    {"value": _NUMBER, "low": _NUMBER, "high": _NUMBER, "unit": _TEXT, "nominal": _or_none(_NUMBER)},
)
_PARAMETERS: Schema = {"type": "object", "additionalProperties": _PARAMETER}
_SIDE = _of("rms in noise floors", {"without": _NUMBER, "with": _NUMBER, "unit": {"const": "noise floors"}})
_SIDES = {"left_before": _SIDE, "left_after": _SIDE}
_HEARD: Schema = {"enum": [one.value for one in Heard]}
_LOGS = _of("the logs of a side", {"verdict": _TEXT, "logs": _list(_TEXT)})
_EFFECT = _of(
    "what changed",
    {
        **_WHERE,
        "status": {"enum": [one.value for one in Status]},
        "parameters": _PARAMETERS,
        "probability": _PROBABILITY,
        "reason": _HEARD,
        "share_before": _NUMBER,
        **_SIDES,
    },
    made_of=_list(_TEXT),
)
_LEFT = _of(
    "what the model of the machine before leaves of a channel, in noise floors",
    {
        "axis": _TEXT,
        "signal": _TEXT,
        "unit": {"const": "noise floors"},
        "before": _NUMBER,
        "after": _NUMBER,
        "after_with_changes": _NUMBER,
    },
)
_SHOWN = _of(
    "the smallest change that would have shown",
    {**_WHERE, "parameter": _TEXT, "size": _NUMBER, "unit": _TEXT, "relative": _or_none(_NUMBER)},
)
_ANSWER: dict[str, Schema] = {
    "schema": {"const": 1},
    "verdict": {"enum": [one.value for one in ChangeKind]},
    "text": {**_TEXT, "description": "the answer in sentences"},
    "effects": _list(_EFFECT),
    "alternatives": _list(
        _of("another name for a change", {**_WHERE, "instead_of": _TEXT, "instead_of_axis": _TEXT, "reason": _TEXT})
    ),
    "dismissed": _list(_of("found after, and no change", {**_WHERE, "reason": _HEARD, **_SIDES})),
    "shared": _list(_of("missing before already", {**_WHERE, "status": _TEXT, "parameters": _PARAMETERS})),
    "something_else": _or_none(_PROBABILITY),
    "moved": _list(
        _of(
            "a number that moved by less than it is known to",
            {"axis": _TEXT, "path": _TEXT, **dict.fromkeys(("from", "to", "low", "high"), _NUMBER)},
        )
    ),
    "left": _list(_LEFT),
    "smallest_shown": _list(_SHOWN),
    "not_testable": _list(_of("what these logs cannot show", {**_WHERE, "reason": _TEXT})),
    "before": _LOGS,
    "after": _LOGS,
    "notes": {**_list(_TEXT), "description": "what a reader must know of the logs"},
}
#: the whole file
CHANGED_SCHEMA: Schema = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": "gimbal-hil changed.json",
    "type": "object",
    "additionalProperties": False,
    "properties": _ANSWER,
    "required": list(_ANSWER),
}
