"""JSON schemas: they ship, are those that the models give, take what the loaders take, refuse typing errors."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from firmware_protocol.documents import read_yaml
from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.experiments import REFERENCE_SHAPES, REFERENCE_UNITS
from gimbal_hil.knowledge.experiments.plan import plan_from_document
from gimbal_hil.surface.checking import SCHEMA_KINDS, FileKind, kind_of, schema_of, schema_text
from gimbal_hil.surface.cli.app import run
from sim_backend.effects import CATALOGUE
from sim_backend.shipped import shipped_file

jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed (the extra test has it)")

SHIPPED = sorted(path for folder in ("", "models", "plans") for path in shipped_file(folder).glob("*.yaml"))


def faults(document: Any, kind: FileKind) -> list[str]:
    return [error.message for error in jsonschema.Draft202012Validator(schema_of(kind)).iter_errors(document)]


@pytest.mark.parametrize("kind", SCHEMA_KINDS)
def test_the_shipped_schema_is_what_the_models_give(kind: FileKind) -> None:
    shipped = shipped_file("schemas", f"{kind.value}.json")
    assert shipped.read_text() == schema_text(kind), f"gimbal-hil check --schema {kind.value} > {shipped}"
    jsonschema.Draft202012Validator.check_schema(json.loads(shipped.read_text()))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_file_names_its_schema_and_keeps_to_it(path: Path) -> None:
    kind, document = kind_of(path)
    assert not faults(document, kind)
    first = path.read_text().splitlines()[0]
    assert (path.parent / first.removeprefix("# yaml-language-server: $schema=")).resolve() == shipped_file(
        "schemas", f"{kind.value}.json"
    ).resolve()


def test_a_misspelt_key_a_wrong_type_and_a_number_out_of_bounds_are_seen_by_the_editor() -> None:
    model = read_yaml(shipped_file("models", "thesis.yaml"), "")
    for spoil in (
        lambda axis: axis["friction"].update(coulom=0.1),
        lambda axis: axis["friction"].update(coulomb="much"),
        lambda axis: axis["encoder"].update(step={"value": 2.0}),
        lambda axis: axis.update(frictoin={}),
    ):
        document = copy.deepcopy(model)
        spoil(document["axes"]["outer"])
        assert faults(document, FileKind.MODEL)


def _value(prefix: str) -> Any:
    return [0.0, 0.01] if prefix.startswith("values") else 2 if prefix in ("lines", "periods", "count") else 0.5


@pytest.mark.parametrize("mode", list(REFERENCE_UNITS), ids=lambda mode: mode.name.lower())
@pytest.mark.parametrize("shape", list(REFERENCE_SHAPES))
def test_a_reference_is_taken_by_schema_and_loader_alike_in_every_mode(mode: Any, shape: str) -> None:
    kind, units = REFERENCE_SHAPES[shape], REFERENCE_UNITS[mode]
    needed = [name for name, field in kind.model_fields.items() if field.is_required() and name != "shape"]
    section: dict[str, Any] = {"mode": mode.name.lower(), "shape": shape}
    for name in needed:
        key = f"{name}_{units[kind.quantities[name]]}" if name in kind.quantities else name
        section[key] = 10.0 if name == "last_hz" else _value(name)
    document = {"schema": 1, "name": "one", "segments": [{"pan": section, "duration_s": 1.0}]}
    plan_from_document(document, "plan", ("pan", "tilt"))
    assert not faults(document, FileKind.PLAN)
    section["value_inches"] = 1.0
    assert faults(document, FileKind.PLAN)
    with pytest.raises(BadInputError):
        plan_from_document(document, "plan", ("pan", "tilt"))


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda effect: effect.name)
def test_every_effect_of_the_catalogue_may_stand_in_a_model(effect: Any) -> None:
    document = read_yaml(shipped_file("models", "thesis.yaml"), "")
    entry = {"name": effect.name, "axis": "outer"}
    document["effects"] = [entry | {one.name: {"value": one.neutral, "unit": one.unit} for one in effect.parameters}]
    assert not faults(document, FileKind.MODEL)
    document["effects"] = [entry | {"no_parameter": 1.0}]
    assert faults(document, FileKind.MODEL)


def test_the_schema_of_an_answer_is_printed_by_its_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("check", ["--schema", "changed"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "gimbal-hil changed.json"
