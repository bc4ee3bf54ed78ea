"""An antenna whose axes are called azimuth and elevation, from the model file to every table, and what `parent:` says
and refuses.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
import yaml

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import open_run
from gimbal_hil.data.signals import read_signals
from gimbal_hil.knowledge.experiments.plan import plan_from_document
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.service.operator_commands import SetPointRequest, parse_request
from gimbal_hil.realtime.service.set_point_bounds import require_reachable
from gimbal_hil.surface.cli.app import run as run_command
from sim_backend.model import AntennaModel, load_model, model_from_document, plant_arrays, shipped_model

NAMES = ("azimuth", "elevation")


def document(names: tuple[str, str] = NAMES, **keys: Any) -> dict[str, Any]:
    """The thesis' antenna under other names, the carried axis first in the file."""
    own = yaml.safe_load(shipped_model().to_yaml())
    outer, inner = own["axes"]["outer"], own["axes"]["inner"] | {"parent": names[0]}
    return own | {"axes": {names[1]: inner, names[0]: outer}} | keys


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model file, a configuration that names its axes, and runs made with them."""
    folder = tmp_path_factory.mktemp("named")
    (folder / "model.yaml").write_text(yaml.safe_dump(document()))
    config = yaml.safe_load((Path("config") / "virtual_antenna.yaml").read_text())
    outer, inner = config["axes"]["outer"], config["axes"]["inner"] | {"parent": "azimuth"}
    config |= {"link": {"embedded": {"model": "model.yaml", "seed": 3}}, "axes": {"elevation": inner, "azimuth": outer}}
    (folder / "config.yaml").write_text(yaml.safe_dump(config))
    return folder


def command(name: str, *words: object) -> int:
    try:
        return run_command(name, [*map(str, words)])
    except SystemExit as end:
        return int(end.code or 0)


def same_antenna(one: AntennaModel, other: AntennaModel) -> bool:
    a, b = plant_arrays(one), plant_arrays(other)
    return np.array_equal(a.P, b.P) and np.array_equal(a.K, b.K) and np.array_equal(a.X, b.X)


def test_which_joint_carries_which_is_read_from_parent_and_not_from_the_order_of_keys() -> None:
    sorted_file = yaml.safe_load(yaml.safe_dump(document(("yaw", "pitch")), sort_keys=True))
    assert list(sorted_file["axes"]) == ["pitch", "yaw"]
    model = model_from_document(sorted_file, "model.yaml")
    assert model.axes == ("yaw", "pitch") and same_antenna(model, shipped_model())


def test_outer_and_inner_are_understood_without_parent_in_any_order() -> None:
    old = document(("outer", "inner"))
    del old["axes"]["inner"]["parent"]
    model = model_from_document(old, "old.yaml")
    assert model.axes == ("outer", "inner") and same_antenna(model, shipped_model())


@pytest.mark.parametrize(
    ("parents", "said"),
    [
        (
            (None, None),
            "which of elevation and azimuth carries the other is not said; expected parent: elevation under azimuth",
        ),
        (("elevation", "azimuth"), "both have a parent"),
        ((None, "base_plate"), "the parent of elevation is 'base_plate'; expected azimuth"),
        ((None, 3), "a parent is no name"),
    ],
)
def test_a_file_that_does_not_say_it_is_refused_with_what_to_write(parents: tuple[object, object], said: str) -> None:
    wrong = document()
    for name, parent in zip(NAMES, parents, strict=True):
        wrong["axes"][name].pop("parent", None)
        if parent is not None:
            wrong["axes"][name]["parent"] = parent
    with pytest.raises(BadInputError, match=r"model\.yaml: axes") as refusal:
        model_from_document(wrong, "model.yaml")
    assert said in str(refusal.value)


@pytest.mark.parametrize("name", ["base", "a.b", "", "mode", "2nd axis"])
def test_a_name_that_columns_could_not_be_told_by_is_refused(name: str) -> None:
    with pytest.raises(BadInputError, match="cannot be the name of an axis"):
        model_from_document(document((name, "elevation")), "model.yaml")


def test_the_log_the_table_and_every_command_call_the_axes_by_their_names(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = folder / "step"
    assert command("experiment", "step", "--short", "--model", folder / "model.yaml", "--out", run, "--json") == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert {row["axis"] for row in rows} == set(NAMES)
    table = (run / "table.csv").read_text()
    assert "azimuth out" in table and "outer" not in table and "inner" not in table
    columns = set(pa.ipc.open_stream((run / "ticks.arrow").read_bytes()).schema.names)
    assert {"torque_azimuth", "torque_elevation", "mode_azimuth"} <= columns and "torque_outer" not in columns
    assert open_run(run).record.header.axes == NAMES
    assert command("replay", run) == 0
    assert command("export", run, "--format", "csv", "--out", folder / "step.csv") == 0
    header = (folder / "step.csv").read_text().split("\n")[0].split(",")
    assert {"azimuth.torque", "elevation.position"} <= set(header) and not any(
        name.startswith(("outer", "inner")) for name in header
    )
    page = (run / "report.html").read_text()
    assert "azimuth out" in page and "outer out" not in page


def test_runs_of_one_antenna_are_not_read_for_another(folder: Path) -> None:
    run = folder / "still"
    assert command("experiment", "base_motion", "--short", "--model", folder / "model.yaml", "--out", run) == 0
    assert read_signals(run, load_model(folder / "model.yaml").axes).axes == NAMES
    with pytest.raises(
        BadInputError, match="is a run of the axes azimuth, elevation; expected a log of the model's axes outer, inner"
    ):
        read_signals(run, shipped_model().axes)


def test_friction_is_identified_and_written_under_the_axis_own_name(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, out = folder / "sliding", folder / "identified"
    words = ("--short", "--axis", "elevation", "--config", folder / "config.yaml", "--out", run)
    assert command("experiment", "sliding", *words) == 0
    assert (
        command("identify", run, "--model", folder / "model.yaml", "--axis", "elevation", "--out", out, "--workers", 1)
        == 0
    )
    assert "elevation" in capsys.readouterr().out
    found, truth = load_model(out / "model.yaml"), shipped_model()
    assert found.axes == NAMES
    assert found.number("elevation", "friction.coulomb") == pytest.approx(
        truth.number("inner", "friction.coulomb"), rel=0.05
    )


@pytest.mark.heavy
def test_what_the_model_lacks_is_named_on_the_axis_own_name(folder: Path) -> None:
    hidden = load_model(folder / "model.yaml").with_effect(
        "cogging", "azimuth", {"amplitude": 0.06, "order": 12.0, "phase": 0.7}
    )
    (folder / "hidden.yaml").write_text(hidden.to_yaml())
    for name in ("survey", "survey_holdout"):
        assert command("experiment", name, "--short", "--model", folder / "hidden.yaml", "--out", folder / name) == 0
    out = folder / "found"
    logs = ("--measured", folder / "survey", "--holdout", folder / "survey_holdout")
    assert command("discrepancy", "--model", folder / "model.yaml", *logs, "--out", out, "--workers", 1) == 0
    verdict = json.loads((out / "verdict.json").read_text())
    assert [(effect["name"], effect["axis"]) for effect in verdict["effects"]] == [("cogging", "azimuth")]
    assert {gap["axis"] for gap in verdict["gaps"]} <= set(NAMES)


def test_the_daemon_records_under_the_names_of_its_model(folder: Path) -> None:
    run = folder / "daemon"
    words = ("--config", folder / "config.yaml", "--lockstep", "--duration", 0.3, "--out", run)
    assert command("daemon", *words) == 0
    assert open_run(run).record.header.axes == NAMES
    assert command("replay", run) == 0


def test_an_operator_calls_the_axes_by_their_names_and_is_told_which_there_are() -> None:
    asked = parse_request({"command": "set_point", "mode": "position", "azimuth": 0.1, "elevation": -0.2}, NAMES)
    generic = parse_request({"command": "set_point", "mode": "position", "outer": 0.1, "inner": -0.2})
    assert asked == generic
    with pytest.raises(BadInputError, match="expected azimuth or elevation"):
        parse_request({"command": "set_point", "mode": "position", "outer": 0.1}, NAMES)
    segment = {"elevation": {"mode": "rate"}, "duration_s": 1.0}
    assert parse_request({"command": "segments", "segments": [segment]}, NAMES).segments[0].inner.mode == "rate"  # type: ignore[union-attr]


def test_a_plan_names_the_axes_of_its_antenna_and_errors_speak_of_them() -> None:
    end = {"axis": "elevation", "position_above_rad": 1.0}
    segment: dict[str, Any] = {"azimuth": {"mode": "rate", "value_rad_s": 0.1}, "duration_s": 1.0, "end": [end]}
    named = plan_from_document({"schema": 1, "name": "n", "segments": [segment]}, "plan", NAMES)
    assert named.segments[0].outer.reference is not None and named.segments[0].end[0].condition(1000.0).axis == 1
    segment["azimuth"] = {"mode": "rate", "value_rad": 0.1}
    with pytest.raises(BadInputError, match=r"segments\.0\.azimuth"):
        plan_from_document({"schema": 1, "name": "n", "segments": [segment]}, "plan", NAMES)


def test_a_configuration_of_other_names_than_the_models_is_refused_and_the_generic_ones_fit() -> None:
    settings = shipped_settings()
    assert settings.for_axes(NAMES, "model.yaml").axis_names == NAMES
    with pytest.raises(BadInputError, match=r"are azimuth and elevation; expected yaw and pitch, as in other\.yaml"):
        settings.for_axes(NAMES, "model.yaml").for_axes(("yaw", "pitch"), "other.yaml")


def test_a_set_point_beyond_a_limit_is_refused_under_the_axis_own_name() -> None:
    asked = parse_request({"command": "set_point", "mode": "position", "elevation": 9.0}, NAMES)
    assert isinstance(asked, SetPointRequest)
    with pytest.raises(BadInputError, match=r"set_point\.elevation"):
        require_reachable(asked, shipped_settings().for_axes(NAMES, "model.yaml"))
