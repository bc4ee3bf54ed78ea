"""Friction over temperature: runs become rows, rows become a table, and intervals hold what is true."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification import Log, as_warm_as, at_temperature, grouped, has_table, require_a_table
from gimbal_hil.knowledge.identification.axis_identification import AxisIdentification
from gimbal_hil.knowledge.identification.estimate import DataWarning, Determination, Estimate, Interval
from gimbal_hil.knowledge.identification.over_temperature import (
    MOST_WARMING_DEGC,
    SAME_DEGC,
    TemperatureResult,
    temperature_of,
)
from gimbal_hil.knowledge.identification.over_temperature_text import over_temperature_lines, within
from gimbal_hil.surface.cli.app import run
from sim_backend.model import AntennaModel, load_model, shipped_model

TABLED = shipped_model("thesis-temperature")


def log(degc: float, warming: float = 0.0, name: str = "a log") -> Log:
    time_s = 1e-3 * np.arange(100)
    warm = np.linspace(degc - 0.5 * warming, degc + 0.5 * warming, 100)
    columns = {f"{axis}.temperature": warm for axis in TABLED.axes}
    columns |= {f"{axis}.{signal}": np.zeros(100) for axis in TABLED.axes for signal in ("torque", "position")}
    return Log(name, SignalsTable.of(TABLED.axes, time_s, columns), {})


@given(st.lists(st.floats(-40.0, 85.0), min_size=1, max_size=12))
def test_every_log_is_in_one_group_and_no_group_is_wider_than_one_temperature(temperatures: list[float]) -> None:
    groups = grouped([log(one) for one in temperatures], TABLED.axes)
    assert sum(len(group.logs) for group in groups) == len(temperatures)
    means = [group.temperature_degc for group in groups]
    assert means == sorted(means)
    for group in groups:
        inside = [temperature_of(one, TABLED.axes) for one in group.logs]
        assert max(inside) - min(inside) <= SAME_DEGC + 1e-9


def test_a_run_that_warms_up_and_one_that_does_not_tell_are_refused() -> None:
    with pytest.raises(BadInputError, match="soak"):
        temperature_of(log(20.0, MOST_WARMING_DEGC + 1.0), TABLED.axes)
    silent = log(20.0)
    bare = SignalsTable.of(
        TABLED.axes, silent.table.time_s, {k: v for k, v in silent.table.columns.items() if "temperature" not in k}
    )
    with pytest.raises(BadInputError, match="temperature"):
        temperature_of(replace(silent, table=bare), TABLED.axes)


@pytest.mark.parametrize(
    ("degc", "viscous"), [(-40.0, 0.2729), (20.0, 0.0609), (37.5, (0.0609 + 0.02539) / 2), (99.0, 0.01199)]
)
def test_between_rows_friction_is_what_the_antenna_has(degc: float, viscous: float) -> None:
    model = at_temperature(TABLED, degc)
    assert not has_table(model)
    assert model.number("outer", "friction.viscous") == pytest.approx(viscous, rel=1e-3)
    assert model.numbers["outer", "friction.viscous"].source == TABLED.numbers["outer", "friction.viscous"].source


def test_a_model_without_a_table_is_as_warm_as_it_says() -> None:
    plain = shipped_model("thesis")
    assert as_warm_as(plain, [log(20.0)]) is plain
    warm = as_warm_as(TABLED, [log(80.0), log(90.0)])
    assert warm.number("outer", "friction.viscous") == pytest.approx(0.01199, rel=1e-3)


def test_one_temperature_makes_no_table_and_too_many_make_none_either() -> None:
    with pytest.raises(BadInputError, match=r"20\.0 degC alone"):
        require_a_table(shipped_model("thesis"), grouped([log(20.0)], TABLED.axes))
    require_a_table(TABLED, grouped([log(20.0)], TABLED.axes))
    with pytest.raises(BadInputError, match="9 temperatures"):
        require_a_table(TABLED, grouped([log(float(t)) for t in range(-40, 50, 10)], TABLED.axes))


def warmed(model: AntennaModel, degc: float, folder: Path) -> Path:
    for axis in model.axes:
        model = model.with_number(axis, "thermal.ambient", degc)
    file = folder / f"at_{degc:g}.yaml"
    file.write_text(model.to_yaml())
    return file


def recorded(model: AntennaModel, degc: float, folder: Path) -> str:
    """A run folder of sliding at a temperature."""
    out = folder / f"run_{degc:g}"
    words = ["sliding", "--short", "--model", str(warmed(model, degc, folder)), "--out", str(out), "--json"]
    assert run("experiment", words) == 0
    return str(out)


@pytest.mark.heavy
def test_two_temperatures_become_a_table_whose_intervals_hold_the_truth(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = [recorded(TABLED, degc, tmp_path) for degc in (-40.0, 55.0)]
    words = [*runs, "--over-temperature", "--model", "thesis", "--out", str(tmp_path / "out"), "--json"]
    capsys.readouterr()
    assert run("identify", words) == 0
    found = json.loads(capsys.readouterr().out)["over_temperature"]
    model = load_model(tmp_path / "out" / "model.yaml")
    assert [row[0] for row in model.friction_over_temperature["outer"]] == pytest.approx([-40.0, 55.0], abs=1.0)
    inside = sure = 0
    for row in found:
        true = at_temperature(TABLED, row["temperature_degc"])
        for name, one in row["numbers"].items():
            if one["verdict"] == "identified":
                sure += 1
                inside += one["low"] <= true.number(row["axis"], f"friction.{name}") <= one["high"]
                half = 0.5 * (one["high"] - one["low"])
                assert abs(one["value"] - true.number(row["axis"], f"friction.{name}")) < 5.0 * half
    assert sure >= 12 and inside >= 0.75 * sure
    # once more, at one temperature: its row stands in place of the old one, the other stays
    again = [runs[0], "--model", str(tmp_path / "out" / "model.yaml"), "--out", str(tmp_path / "again"), "--json"]
    assert run("identify", again) == 0
    after = load_model(tmp_path / "again" / "model.yaml")
    assert after.friction_over_temperature["inner"][1] == model.friction_over_temperature["inner"][1]
    assert (tmp_path / "again" / "over_temperature.csv").read_text().startswith("axis,temperature_degc,number,value")


def _estimate(name: str, value: float, half: float, reason: str = "") -> Estimate:
    verdict = Determination.NOT_IDENTIFIED if reason else Determination.IDENTIFIED
    return Estimate(name, value, Interval(value - half, value + half), "N m", verdict, value, None, reason, "ramps")


def _result(degc: float, coulomb: float, rules: tuple[str, ...]) -> TemperatureResult:
    estimates = (_estimate("coulomb", coulomb, 1.2e-6), _estimate("sigma0", 300.0, 1.0, "no data"))
    findings = tuple(DataWarning(rule, f"{rule} at {coulomb}", ()) for rule in rules)
    one = SimpleNamespace(axis="outer", estimates=estimates, findings=findings)
    return TemperatureResult(degc, TABLED, (cast(AxisIdentification, one),))


def test_the_terminal_has_a_row_for_each_temperature_and_says_once_what_is_open() -> None:
    found = [
        _result(-40.0, 0.1317535, ("passive",)),
        _result(20.0, 0.1036532, ("passive", "scale")),
        _result(85.0, 0.1, ()),
    ]
    said = over_temperature_lines(found)
    assert said[0] == "Friction at -40, 20, 85 degC; 3 of 6 numbers identified."
    rows = [line.split() for line in said if "±" in line]
    assert [row[0] for row in rows] == ["-40.0", "20.0", "85.0"] and rows[0][2:5] == ["0.1317535", "±", "0.0000012"]
    assert all("(300)" in row for row in rows)
    assert [line for line in said if line.startswith("  ! ")] == [
        "  ! outer sigma0: no data; to settle it: ramps",
        "  ! outer at -40 degC: passive at 0.1317535 (and at 20 degC)",
        "  ! outer at 20 degC: scale at 0.1036532",
    ]


@given(st.floats(1e-9, 1e3), st.floats(-1e3, 1e3))
def test_a_number_and_half_its_interval_have_the_same_decimals_and_no_exponent(half: float, value: float) -> None:
    one, other = within(value, half).split(" ± ")
    assert "e" not in one + other and len(one.partition(".")[2]) == len(other.partition(".")[2])
    assert float(other) == pytest.approx(half, rel=0.06) and abs(float(one) - value) <= 0.06 * half
