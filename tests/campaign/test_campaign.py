"""Many virtual antennas: the same table wherever and in however many goes it is computed."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import one_writer
from gimbal_hil.proof.campaign import TABLE_FILE, spreads_of
from gimbal_hil.surface.cli import app
from sim_backend.model import shipped_model
from tests.executor.cluster import local_cluster

PLAN = """
schema: 1
name: turn
text: A short turn
segments:
  - name: turn
    outer: {mode: position, shape: smooth, target_rad: 0.02, over_s: 0.2}
    inner: {mode: position}
    duration_s: 0.3
    measure: true
"""
SPREAD = ["--spread", "outer.friction.coulomb=3%", "--spread", "inner.friction.viscous=0.005"]


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    file = tmp_path / "turn.yaml"
    file.write_text(PLAN)
    return file


def campaign(plan: Path, out: Path, *words: str) -> bytes:
    assert app.run("campaign", [str(plan), "--out", str(out), *SPREAD, *words]) == 0
    return (out / TABLE_FILE).read_bytes()


def test_the_table_is_the_same_from_one_process_from_two_and_after_a_kill(plan: Path, tmp_path: Path) -> None:
    alone = campaign(plan, tmp_path / "one", "--antennas", "25")
    assert campaign(plan, tmp_path / "two", "--antennas", "25", "--workers", "2") == alone
    campaign(plan, tmp_path / "cut", "--antennas", "12")
    table = tmp_path / "cut" / TABLE_FILE
    table.write_bytes(table.read_bytes()[:-30])
    assert campaign(plan, tmp_path / "cut", "--antennas", "25", "--resume") == alone
    assert campaign(plan, tmp_path / "other", "--antennas", "25", "--seed", "1") != alone


@pytest.mark.heavy
def test_the_table_is_the_same_from_a_cluster(plan: Path, tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    alone = campaign(plan, tmp_path / "one", "--antennas", "25")
    with local_cluster(tmp_path) as address:
        assert campaign(plan, tmp_path / "cluster", "--antennas", "25", "--dask", address) == alone


def test_a_row_has_what_was_drawn_and_what_was_measured(plan: Path, tmp_path: Path) -> None:
    campaign(plan, tmp_path, "--antennas", "40")
    with (tmp_path / TABLE_FILE).open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["antenna"] for row in rows] == [str(n) for n in range(41)]
    nominal = shipped_model().number("outer", "friction.coulomb")
    assert float(rows[0]["outer.friction.coulomb"]) == nominal
    drawn = np.array([float(row["outer.friction.coulomb"]) for row in rows[1:]])
    assert 0.02 < np.std(drawn) / nominal < 0.04
    torque = np.array([float(row["turn: outer_torque_mean_nm"]) for row in rows[1:]])
    assert np.corrcoef(drawn, torque)[0, 1] > 0.9
    page = (tmp_path / "report.html").read_text()
    assert (
        "40 antennas and the nominal one: all finished the experiment. Drawn for each: " in page
        and " differs most from antenna to antenna: " in page
    )


def test_what_an_antenna_cannot_do_stands_in_its_row(plan: Path, tmp_path: Path) -> None:
    plan.write_text(PLAN + "    guards: {outer: {torque_nm: 2.5}}\n")
    campaign(plan, tmp_path, "--spread", "outer.body.inertia.zz=20%", "--antennas", "20")
    with (tmp_path / TABLE_FILE).open(newline="") as file:
        problems = [row["problem"] for row in csv.DictReader(file)]
    assert not problems[0]
    assert 0 < sum(map(bool, problems)) < 20
    assert f"{sum(map(bool, problems))} did not finish" in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ("friction.coulom=1%", "has no number"),
        ("friction.coulomb=much", "is no amount"),
        ("gyro.bias=10%", "nothing spreads"),
    ],
)
def test_a_spread_that_says_nothing_is_refused(asked: str, words: str) -> None:
    with pytest.raises(BadInputError, match=words):
        spreads_of(shipped_model(), [asked])


def test_a_number_without_an_amount_spreads_by_its_uncertainty() -> None:
    model = shipped_model()
    outer, inner = spreads_of(model, ["friction.coulomb"])
    assert (outer.name, inner.name) == ("outer.friction.coulomb", "inner.friction.coulomb")
    assert outer.deviation == model.uncertainty("outer", "friction.coulomb") > 0.0
    assert {outer, inner} < set(spreads_of(model, ["all"]))


def test_a_folder_of_another_campaign_is_not_gone_on_with(plan: Path, tmp_path: Path) -> None:
    campaign(plan, tmp_path, "--antennas", "1")
    words = [str(plan), "--out", str(tmp_path), "--antennas", "2"]
    for more in (["--resume", "--seed", "3"], []):
        with pytest.raises(SystemExit) as ended:
            app.run("campaign", [*words, *more])
        assert ended.value.code == 2
    assert json.loads((tmp_path / "campaign.json").read_text())["seed"] == 0


def test_two_campaigns_in_one_folder_are_refused(
    plan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = campaign(plan, tmp_path / "one", "--antennas", "1")
    with one_writer(tmp_path / "one"), pytest.raises(SystemExit) as ended:
        campaign(plan, tmp_path / "one", "--antennas", "2", "--resume")
    assert ended.value.code == 2 and "process" in capsys.readouterr().err
    assert (tmp_path / "one" / TABLE_FILE).read_bytes() == before
