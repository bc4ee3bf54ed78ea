"""Nothing of a model is dropped in silence, whatever the format."""

from __future__ import annotations

import ast
import csv
import io
import json
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gimbal_hil.knowledge.model_exports import ExportedModel, ModelFormat, export_model
from gimbal_hil.surface.cli import app
from sim_backend.effects import CATALOGUE
from sim_backend.model import shipped_model, shipped_model_path

AXES = ("outer", "inner")
HIDDEN = [effect for effect in CATALOGUE.values() if not effect.is_number]


def on_lists(exported: ExportedModel) -> list[tuple[str, str]]:
    told = (*exported.held, *(one.item for one in (*exported.approximated, *exported.left_out)))
    return [(item.axis, item.name) for item in told]


@pytest.mark.parametrize("wanted", ModelFormat)
@given(chosen=st.lists(st.tuples(st.sampled_from(HIDDEN), st.sampled_from(AXES)), max_size=4, unique=True))
@settings(max_examples=25, deadline=None)
def test_every_effect_and_number_is_on_exactly_one_list(wanted: ModelFormat, chosen: list) -> None:
    model = shipped_model()
    for effect, axis in chosen:
        values = {p.name: min(max(0.5 * (p.high if p.high < 100 else 1.0), p.low), p.high) for p in effect.parameters}
        model = model.with_effect(effect.name, axis, values)
    names = on_lists(export_model(model, wanted))
    assert len(names) == len(set(names))
    assert {(axis, effect.name) for effect, axis in chosen} <= set(names)
    assert ("outer", "friction.viscous") in names and ("inner", "gyro.noise") in names


def test_what_a_format_leaves_out_is_named_as_the_catalogue_names_it() -> None:
    model = shipped_model().with_number("outer", "gyro.bias", 0.01)
    left = {one.item.name: one.effects for one in export_model(model, ModelFormat.MJCF).left_out}
    assert left["gyro.bias"] == ("gyro_bias",)


def test_urdf_is_read_by_another_reader_with_the_same_bodies() -> None:
    built = mujoco.MjModel.from_xml_string(export_model(shipped_model(), ModelFormat.URDF).text)
    assert built.nv == 2 and built.dof_damping.tolist() == pytest.approx([0.0609, 0.0336])
    assert built.dof_frictionloss.tolist() == pytest.approx([0.2412, 0.1376])


def test_isaac_is_python_that_calls_known_classes() -> None:
    model = shipped_model().with_effect("transport_delay", "outer", {"delay": 0.003})
    tree = ast.parse(export_model(model, ModelFormat.ISAAC).text)
    calls = {ast.unparse(node.func): node for node in ast.walk(tree) if isinstance(node, ast.Call)}
    assert set(calls) == {"DelayedPDActuatorCfg", "IdealPDActuatorCfg"}
    given_words = {word.arg: ast.literal_eval(word.value) for word in calls["DelayedPDActuatorCfg"].keywords}
    assert given_words["max_delay"] == 30 and given_words["effort_limit"] == 15.5


def test_bam_gets_a_load_dependent_model_only_where_friction_depends_on_the_load() -> None:
    model = shipped_model().with_effect("load_dependent_friction", "inner", {"coefficient": 0.07})
    document = json.loads(export_model(model, ModelFormat.BAM).text)
    assert (document["outer"]["model"], document["inner"]["model"]) == ("m2", "m4")
    assert document["inner"]["load_friction_base"] == 0.07


def test_curves_are_rows_with_units_and_friction_opposes_the_motion() -> None:
    rows = list(csv.DictReader(io.StringIO(export_model(shipped_model(), ModelFormat.CSV).text)))
    friction = [row for row in rows if row["axis"] == "outer" and row["curve"] == "friction"]
    assert friction and all(float(row["value"]) * float(row["torque"]) < 0.0 for row in friction)
    assert {row["torque_unit"] for row in rows} == {"N m"}


@pytest.mark.parametrize("wanted", ModelFormat)
def test_the_command_writes_the_file_and_says_what_is_left_out(
    wanted: ModelFormat, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "model.out"
    words = [str(shipped_model_path()), "--to", wanted.value, "--out", str(out)]
    assert app.run("export-model", words) == 0
    assert "left out" in capsys.readouterr().out and out.read_bytes()
    if wanted in (ModelFormat.MJCF, ModelFormat.URDF):
        ElementTree.fromstring(out.read_text())
    with pytest.raises(SystemExit) as refused:
        app.run("export-model", words)
    assert refused.value.code == 2
    assert app.run("export-model", [*words, "--force", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["format"] == wanted.value
    # the antenna itself is all there
    assert bool(said["left_out"]) == (wanted is not ModelFormat.FMU)


def test_a_bad_model_writes_nothing(tmp_path: Path) -> None:
    (tmp_path / "model.yaml").write_text("schema: 1\n")
    with pytest.raises(SystemExit) as refused:
        app.run("export-model", [str(tmp_path / "model.yaml"), "--to", "mjcf", "--out", str(tmp_path / "x.xml")])
    assert refused.value.code == 2 and not (tmp_path / "x.xml").exists()
