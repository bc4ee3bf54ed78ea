"""`gimbal-hil check`: what a file is, everything that is wrong with it, and an exit code."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from firmware_protocol.documents import yaml_mapping, yaml_text
from gimbal_hil.surface.cli import main
from sim_backend.shipped import shipped_file

THESIS = shipped_file("models", "thesis.yaml")
CONFIGURATION = shipped_file("virtual_antenna.yaml")
PLAN = shipped_file("plans", "two_speeds.yaml")


def ask(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        main(["check", *words])
    said = capsys.readouterr()
    assert isinstance(end.value.code, int)
    return end.value.code, said.out, said.err


def test_every_shipped_file_is_recognised_and_good(capsys: pytest.CaptureFixture[str]) -> None:
    folders = [shipped_file(), shipped_file("models"), shipped_file("plans")]
    code, out, _ = ask(capsys, *map(str, folders))
    assert code == 0
    *lines, following = out.splitlines()
    assert len(lines) == sum(len(list(folder.glob("*.yaml"))) for folder in folders)
    assert all(line.startswith("good") for line in lines)
    assert following.startswith("next: gimbal-hil")
    for path, kind in ((THESIS, "model"), (CONFIGURATION, "configuration"), (PLAN, "plan")):
        assert any(f"{path}: {kind}:" in line for line in lines)


def test_all_that_is_wrong_with_a_model_is_told_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "model.yaml"
    file.write_text(
        THESIS.read_text()
        .replace("coulomb: {value: 0.2412", "coulomb: {value: -0.2412")
        .replace("limit: {value: 6.6, unit: N m", "limit: {value: 6.6, unit: Nm/A")
        .replace("breakaway: {value: 0.1451", "brakeaway: {value: 0.1451")
    )
    code, out, _ = ask(capsys, str(file))
    assert code == 1
    *lines, following = out.splitlines()
    assert [line.split(": ")[1] for line in lines] == [
        "axes.outer.friction.coulomb",
        "axes.inner.friction.brakeaway",
        "axes.inner.actuator.limit",
    ]
    assert "friction.breakaway" in lines[1]
    assert following == f"next: gimbal-hil check {file}"


def test_all_that_is_wrong_with_a_configuration_is_told_at_once_as_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = yaml_mapping(CONFIGURATION.read_text(), "x", "y")
    document["rate_hz"] = "fast"
    document["axes"]["outer"]["limits"]["torqe_nm"] = document["axes"]["outer"]["limits"].pop("torque_nm")
    file = tmp_path / "antenna.yaml"
    file.write_text(yaml_text(document))
    code, out, _ = ask(capsys, str(file), "--json")
    faults = json.loads(out)["files"][0]["faults"]
    assert code == 1 and json.loads(out)["good"] is False
    assert {fault["where"].split(": ")[1] for fault in faults} == {
        "rate_hz",
        "axes.outer.limits.torqe_nm",
        "axes.outer.limits.torque_nm",
    }
    assert all("(and" not in fault["problem"] for fault in faults)


def test_a_configuration_whose_model_has_other_axes_is_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = yaml_mapping(CONFIGURATION.read_text(), "x", "y")
    outer, inner = document["axes"].values()
    document["axes"] = {"azimuth": outer, "elevation": inner | {"parent": "azimuth"}}
    file = tmp_path / "antenna.yaml"
    file.write_text(yaml_text(document))
    code, out, _ = ask(capsys, str(file))
    assert code == 1 and "azimuth and elevation" in out and "outer and inner" in out


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ({"observer": {"model": "emps"}}, "observer.model: emps has the axes carriage"),
        ({"observer": {"model": "./none.yaml"}}, "observer.model: {folder}/none.yaml: no such file"),
        ({"observer": {"model": "nobody"}}, "observer.model: no shipped model 'nobody'"),
        ({"model_control": {"model": "none.yaml"}}, "model_control.model: {folder}/none.yaml: no such file"),
        ({"link": {"embedded": {"model": "none.yaml"}}}, "link.embedded.model: {folder}/none.yaml: no such file"),
    ],
)
def test_a_model_that_is_refused_is_named_with_the_file_and_the_key_that_name_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], section: dict[str, object], said: str
) -> None:
    file, sound = tmp_path / "x.yaml", tmp_path / "y.yaml"
    sound.write_text(CONFIGURATION.read_text())
    file.write_text(yaml_text(yaml_mapping(CONFIGURATION.read_text(), "x", "y") | section))
    code, out, _ = ask(capsys, str(sound), str(file))
    assert code == 1
    assert any(line.startswith(f"wrong  {file}: {said.format(folder=tmp_path)}") for line in out.splitlines()), out


def test_a_plan_is_checked_against_the_axes_of_the_model_beside_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, plan = tmp_path / "model.yaml", tmp_path / "plan.yaml"
    model.write_text(
        THESIS.read_text().replace("  outer:\n", "  azimuth:\n").replace("parent: outer", "parent: azimuth")
    )
    plan.write_text(PLAN.read_text().replace("outer: {mode", "azimuth: {mode"))
    code, out, _ = ask(capsys, str(plan), str(model))
    assert code == 0, out
    plan.write_text(plan.read_text().replace("azimuth: {mode", "elevation: {mode"))
    code, out, _ = ask(capsys, str(plan), str(model))
    assert code == 1 and "elevation" in out


def test_a_plan_alone_says_which_axes_it_needs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = tmp_path / "plan.yaml"
    moves = "{mode: rate, value_rad_s: 0.1}"
    plan.write_text(f"schema: 1\nname: one\nsegments:\n- {{pan: {moves}, tilt: {moves}, duration_s: 1.0}}\n")
    code, out, _ = ask(capsys, str(plan))
    assert code == 0 and "axes pan and tilt, which the antenna must have" in out


def test_a_table_of_signals_is_checked_with_the_axes_that_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "log.csv"
    rows = [f"{0.01 * k:.2f},0.0,{0.001 * k}" for k in range(200)]
    table.write_text("\n".join(["time_s,pan.torque,pan.position", *rows]) + "\n")
    assert ask(capsys, str(table), "--axes", "pan")[0] == 0
    table.write_text(table.read_text().replace("0.05,0.0,", "0.05,none,"))
    code, out, _ = ask(capsys, str(table), "--axes", "pan")
    assert code == 1 and "pan.torque" in out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("nowhere.yaml",), "nowhere.yaml"),
        ((), "FILE"),
        (("--schema", "modle"), "configuration, model, plan"),
    ],
)
def test_wrong_use_ends_with_two_and_one_line(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], said: str
) -> None:
    code, _, err = ask(capsys, *words)
    assert code == 2 and said in err and len(err.splitlines()) == 1


def test_a_file_of_no_known_kind_is_said_to_be_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "list.yaml"
    file.write_text("eggs: 6\nmilk: 1\n")
    code, _, err = ask(capsys, str(file))
    assert code == 2 and "eggs, milk" in err
