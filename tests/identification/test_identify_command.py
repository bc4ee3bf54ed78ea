"""`gimbal-hil identify` from the outside: tables in, model file, answer and page out."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from gimbal_hil.data.signals import SignalsTable, write_signals
from gimbal_hil.surface.cli.app import run
from sim_backend.model import load_model
from tests.identification.one_axis_rig import (
    ENCODER_STEP,
    OUTER,
    Recorded,
    Rig,
    apply_torque,
    follow_rate,
    pulses,
    slow_ramp,
    there_and_back,
)

TRUE = OUTER.static
RIG = Rig(gravity=0.4)
SPEEDS = np.geomspace(0.001, 0.1, 10)


def _prior(folder: Path) -> Path:
    """A model whose friction is off, whose gravity is right: 0.4 N m at the level."""
    number = {
        "breakaway": 0.3,
        "coulomb": 0.28,
        "stribeck_velocity": 0.01,
        "viscous": 0.1,
        "shape": 1.3,
        "sigma0": 300.0,
        "sigma1": 10.0,
    }
    document = {
        "schema": 1, "name": "one axis", "kind": "rotary", "incline_sine": 1.0, "gravity_m_s2": 10.0,
        "axes": {"arm": {
            "body": {"mass": 1.0, "cog": {"x": 0.04}, "inertia": {"zz": 0.5}}, "friction": number,
            "encoder": {"step": ENCODER_STEP},
        }},
    }  # fmt: skip
    path = folder / "prior.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


def _write(folder: Path, name: str, recorded: Recorded, with_reference: bool) -> Path:
    columns = {"arm.torque": recorded.torque, "arm.position": recorded.position, "arm.rate": recorded.gyro}
    if with_reference:
        columns["arm.rate_ref"] = recorded.rate_ref
    path = folder / f"{name}.parquet"
    write_signals(SignalsTable.of(("arm",), recorded.time_s, columns), path)
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Prior, a sliding table, a slow-ramp table and a pulse table; the torque runs stand where gravity is balanced by
    nothing else.
    """
    where = tmp_path_factory.mktemp("identify")
    _prior(where)
    _write(where, "sliding", follow_rate(RIG, there_and_back(SPEEDS), 7), with_reference=True)
    level = Rig()
    offset = 0.4
    for name, torque in (("ramps", slow_ramp(0.8 * TRUE.breakaway, 30.0)), ("pulses", pulses(0.12, 4.0))):
        recorded = apply_torque(level, torque)
        # the arm hangs where gravity asks for 0.4 N m; over microradians it does not change
        moved = Recorded(recorded.time_s, recorded.torque + offset, recorded.position, recorded.gyro, recorded.rate_ref)
        _write(where, name, moved, with_reference=False)
    return where


def _identify(folder: Path, out: Path, *extra: str) -> int:
    tables = [str(folder / f"{name}.parquet") for name in ("sliding", "ramps", "pulses")]
    return run(
        "identify",
        [
            *tables,
            "--model",
            str(folder / "prior.yaml"),
            "--out",
            str(out),
            "--torque-driven",
            "--workers",
            "1",
            *extra,
        ],
    )


@pytest.fixture(scope="module")
def answer(folder: Path) -> Path:
    """Folder of one whole identification."""
    assert _identify(folder, folder / "out") == 0
    return folder / "out"


def test_all_seven_numbers_are_identified_with_intervals_that_hold_the_truth(answer: Path) -> None:
    record = json.loads((answer / "identification.json").read_text())
    found = {e["name"]: e for e in record["axes"][0]["estimates"]}
    true = {
        "breakaway": 0.2585,
        "coulomb": 0.2412,
        "stribeck_velocity": 0.0054,
        "viscous": 0.0609,
        "shape": 1.0459,
        "sigma0": 238.88,
        "sigma1": 16.02,
    }
    tolerance = {
        "breakaway": 0.01,
        "coulomb": 0.01,
        "stribeck_velocity": 0.1,
        "viscous": 0.2,
        "shape": 0.2,
        "sigma0": 0.05,
        "sigma1": 0.05,
    }
    for name, value in true.items():
        assert found[name]["verdict"] != "not_identified", name
        assert found[name]["value"] == pytest.approx(value, rel=tolerance[name]), name
    assert sum(found[name]["low"] <= value <= found[name]["high"] for name, value in true.items()) >= 6


def test_the_new_model_holds_the_numbers_and_says_where_they_come_from(answer: Path) -> None:
    model = load_model(answer / "model.yaml")
    assert model.number("arm", "friction.coulomb") == pytest.approx(TRUE.coulomb, rel=0.01)
    assert "95 % interval" in str(model.numbers["arm", "friction.coulomb"].source)
    assert model.number("arm", "body.inertia.zz") == 0.5


def test_the_prior_beside_each_number_is_that_of_the_model_given(folder: Path, answer: Path) -> None:
    estimates = json.loads((answer / "identification.json").read_text())["axes"][0]["estimates"]
    given = load_model(folder / "prior.yaml")
    assert [e["prior"] for e in estimates] == [given.number("arm", f"friction.{e['name']}") for e in estimates]


def test_the_page_stands_alone_and_shows_curve_loops_and_intervals(answer: Path) -> None:
    page = (answer / "report.html").read_text()
    assert "Friction over speed" in page and "Presliding" in page and "Intervals" in page
    assert "<script src=" not in page


def test_the_missing_passivity_of_the_truth_is_reported(answer: Path) -> None:
    record = json.loads((answer / "identification.json").read_text())
    assert "not_passive" in [finding["rule"] for finding in record["axes"][0]["findings"]]


def test_nothing_is_overwritten_without_force(folder: Path, answer: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        _identify(folder, answer)
    assert ended.value.code == 2
    assert "--force" in capsys.readouterr().err


def test_an_axis_that_the_model_does_not_have_is_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        _identify(folder, tmp_path / "out", "--axis", "leg")
    assert ended.value.code == 2
    assert "arm" in capsys.readouterr().err


def test_a_table_in_which_nothing_happens_keeps_every_prior_and_answers_no(folder: Path, tmp_path: Path) -> None:
    n = 2000
    still = SignalsTable.of(("arm",), np.arange(n) * 1e-3, {
        "arm.torque": np.zeros(n), "arm.position": np.zeros(n), "arm.rate_ref": np.zeros(n),
    })  # fmt: skip
    write_signals(still, tmp_path / "still.csv")
    code = run(
        "identify",
        [
            str(tmp_path / "still.csv"),
            "--model",
            str(folder / "prior.yaml"),
            "--out",
            str(tmp_path / "out"),
            "--workers",
            "1",
        ],
    )
    assert code == 1
    record = json.loads((tmp_path / "out" / "identification.json").read_text())
    assert {e["verdict"] for e in record["axes"][0]["estimates"]} == {"not_identified"}
    assert load_model(tmp_path / "out" / "model.yaml").number("arm", "friction.sigma0") == 300.0
