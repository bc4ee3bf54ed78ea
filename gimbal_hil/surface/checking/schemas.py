"""JSON schemas (draft 2020-12) of the YAML files, for editors that complete and check while one types.

They come from the models that validate the files in earnest. Where a file says something that those models only see
after it was unfolded (numbers with units in a model, references with the mode's unit in a plan), the same tables that
unfold it are spelt out. A schema allows a little more than the loaders do: `gimbal-hil check` has the last word.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.experiments import REFERENCE_SHAPES, REFERENCE_UNITS, Plan
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.surface.checking.kinds import FileKind
from sim_backend.effects import CATALOGUE, Effect
from sim_backend.model import NUMBER_AT, ModelFile

Schema = Json
#: first line of a file whose editor is to know its schema
SCHEMA_LINE = "# yaml-language-server: $schema={path}\n"
_DRAFT = "https://json-schema.org/draft/2020-12/schema"
_UNCERTAINTY: Schema = {
    "description": "one standard deviation: in the number's unit, or relative as in 10%",
    "anyOf": [
        {"type": "number", "minimum": 0},
        {"type": "string", "pattern": r"^\s*[0-9.]+([eE][+-]?[0-9]+)?\s*%\s*$"},
    ],
}
_TITLES = {
    FileKind.CONFIGURATION: "gimbal-hil configuration",
    FileKind.MODEL: "gimbal-hil model of an antenna",
    FileKind.PLAN: "gimbal-hil plan of an experiment",
}
#: kinds of files that people write and that have a schema
SCHEMA_KINDS = tuple(_TITLES)
#: commands whose answers have one
ANSWER_SCHEMAS = ("changed",)


def schema_of(kind: FileKind) -> Schema:
    """The schema of a kind of YAML file; KeyError for kinds that are no YAML."""
    made = {FileKind.CONFIGURATION: _of_configuration, FileKind.MODEL: _of_model, FileKind.PLAN: _of_plan}[kind]()
    return {"$schema": _DRAFT, **_in_one_line(made), "title": _TITLES[kind]}


def schema_text(kind: FileKind) -> str:
    """The schema as a file holds it."""
    return _as_text(schema_of(kind))


def answer_schema_text(command: str) -> str:
    """The schema of what a command of `ANSWER_SCHEMAS` answers; KeyError for another one."""
    # the search comes with it, which nothing else here needs
    from gimbal_hil.knowledge.change import CHANGED_SCHEMA

    return _as_text({"changed": CHANGED_SCHEMA}[command])


def _as_text(schema: Schema) -> str:
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def _in_one_line(schema: Any) -> Any:
    """Descriptions without the line breaks of the docstrings that they come from."""
    if isinstance(schema, list):
        return [_in_one_line(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    return {
        key: " ".join(one.split()) if key == "description" and isinstance(one, str) else _in_one_line(one)
        for key, one in schema.items()
    }


def _of_configuration() -> Schema:
    return DaemonSettings.model_json_schema()


def _of_model() -> Schema:
    schema = ModelFile.model_json_schema()
    schema["$defs"] |= {"AxisNumbers": _axis_numbers(), "EffectSection": _effect_entry()}
    schema["properties"]["axes"]["additionalProperties"] = {"$ref": "#/$defs/AxisNumbers"}
    schema["properties"]["uncertainty"] = _UNCERTAINTY
    schema["$defs"].pop("Uncertainty", None)
    return schema


def _axis_numbers() -> Schema:
    """Nested sections of an axis' numbers, each plain or with unit, source and uncertainty."""
    top = _section("numbers of an axis; which are needed depends on the kind")
    for number in NUMBER_AT.values():
        *parents, key = number.path.split(".")
        section = top
        for parent in parents:
            section = section["properties"].setdefault(parent, _section())
        units = sorted({number.unit, number.linear_unit})
        section["properties"][key] = _quantity(number.text, number.low, number.high, units)
    top["properties"]["parent"] = {"type": "string", "description": "the axis that carries this one"}
    top["properties"]["torque_constant"] = top["properties"]["actuator"]["properties"]["torque_constant"]
    top["properties"]["friction"]["properties"]["over_temperature"] = {
        "type": "array",
        "minItems": 2,
        "maxItems": 8,
        "items": {"type": "object"},
        "description": "rows of temperature and all friction numbers, temperature rising",
    }
    return top


def _section(description: str = "") -> Schema:
    said = {"description": description} if description else {}
    return {"type": "object", "additionalProperties": False, "properties": {}, **said}


def _quantity(text: str, low: float, high: float, units: list[str]) -> Schema:
    bounded = {"type": "number", "minimum": low, "maximum": high}
    whole = _section()
    whole["properties"] = {
        "value": bounded,
        "unit": {"type": "string", "examples": units},
        "source": {"type": "string", "examples": ["measured", "data sheet", "CAD", "assumed"]},
        "uncertainty": _UNCERTAINTY,
    }
    whole["required"] = ["value"]
    return {"description": f"{text} [{' or '.join(units)}]", "anyOf": [bounded, whole]}


def _effect_entry() -> Schema:
    return {"type": "object", "required": ["name", "axis"], "oneOf": [_effect(effect) for effect in CATALOGUE.values()]}


def _effect(effect: Effect) -> Schema:
    entry = _section(effect.text)
    entry["properties"] = {"name": {"const": effect.name}, "axis": {"type": "string"}}
    for parameter in effect.parameters:
        units = sorted({parameter.unit, parameter.linear_unit or parameter.unit})
        low, high = min(parameter.low, parameter.neutral), max(parameter.high, parameter.neutral)
        entry["properties"][parameter.name] = _quantity(parameter.text, low, high, units)
    return entry


def _of_plan() -> Schema:
    """Segments hold their axes by name, and references carry the unit of their mode."""
    schema = Plan.model_json_schema()
    definitions = schema["$defs"]
    segment = definitions["SegmentPlan"]
    for name in ("outer", "inner"):
        del segment["properties"][name]
    segment["additionalProperties"] = {"$ref": "#/$defs/AxisPlan"}
    definitions["Guards"] = {"type": "object", "additionalProperties": {"$ref": "#/$defs/GuardPlan"}}
    segment["properties"]["guards"] = {"$ref": "#/$defs/Guards"}
    off = _section("the axis is off")
    off["properties"] = {"mode": {"const": "off"}}
    moving = [
        _reference(definitions[shape.__name__], name, mode.name.lower(), shape.quantities, units)
        for mode, units in REFERENCE_UNITS.items()
        for name, shape in REFERENCE_SHAPES.items()
    ]
    definitions["AxisPlan"] = {
        "description": "what one axis does: a mode, and a reference whose keys carry the mode's unit",
        "anyOf": [off, *moving],
    }
    for shape in REFERENCE_SHAPES.values():
        del definitions[shape.__name__]
    del definitions["Mode"]
    return schema


def _reference(
    definition: Schema, shape: str, mode: str, quantities: Mapping[str, int], units: tuple[str, str, str]
) -> Schema:
    def key(name: str) -> str:
        return f"{name}_{units[quantities[name]]}" if name in quantities else name

    section = _section(definition.get("description", ""))
    section["properties"] = {key(name): one for name, one in definition["properties"].items()}
    section["properties"] |= {"mode": {"const": mode}, "shape": {"const": shape}}
    # without a shape a value is held
    own = [key(name) for name in definition.get("required", ()) if name != "shape"]
    section["required"] = ["mode", *([] if shape == "hold" else ["shape"]), *own]
    return section
