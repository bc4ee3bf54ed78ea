"""Tables for drives of other makes: what they hold is what the model says, and it takes the ripple away."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.errors import BadInputError
from firmware_protocol.links import AdapterLinkConfig
from gimbal_hil.knowledge.drive_tables import FrictionFeed, Motor, drive_tables, friction_table, rehearse
from gimbal_hil.surface.cli import app
from sim_backend.drives import SimulatedMoteus, SimulatedOdrive
from sim_backend.layout import RATE
from sim_backend.model import AntennaModel, load_model, shipped_model
from sim_backend.plant import Plant

MAKES = ("moteus", "odrive", "cia402")


def link_of(drive: str, **second: Any) -> AdapterLinkConfig:
    more = {"counts_per_turn": 262144.0, "rated_torque_nm": 2.0} if drive == "cia402" else {}
    drives = [{"id": 1, "torque_nm": 15.0} | more, {"id": 2, "torque_nm": 6.0, "sign": -1, "gear": 2.0} | more | second]
    return AdapterLinkConfig(kind="adapter", drive=drive, interface="virtual", channel="tables", drives=drives)


def rippled(amplitude: float = 0.03, order: float = 36.0, phase: float = -1.1) -> AntennaModel:
    ripple = {"amplitude": amplitude, "order": order, "phase": phase}
    return shipped_model().with_effect("cogging", "inner", ripple)


def torque_of(amplitude: float, order: float, phase: float, q: float) -> float:
    return amplitude * math.sin(order * q + phase)


@given(
    turns=st.sampled_from([1.0, -1.0, 3.0, -2.0]),
    zero=st.floats(0.0, 1.0),
    phase=st.floats(-3.0, 3.0),
    q=st.floats(-2.0, 2.0),
)
@settings(max_examples=30, deadline=None)
def test_a_moteus_makes_up_for_the_ripple_wherever_its_encoder_sits(
    turns: float, zero: float, phase: float, q: float
) -> None:
    motor = Motor(0.08, turns, zero)
    tables = drive_tables(rippled(phase=phase), link_of("moteus"), {"inner": motor})[1]
    drive = SimulatedMoteus(2, 0.08, turns, zero)
    for line in tables.files["inner.moteus.cfg"].splitlines()[1:]:
        drive.configure(line)
    drive.mode = 10
    drive.shaft.position_rad = -2.0 * q
    # sign -1 and gear 2 from the shaft to the joint
    assert -2.0 * drive.torque_nm == pytest.approx(-torque_of(0.03, 36.0, phase, q), abs=1e-3)


@given(phase=st.floats(-3.0, 3.0), q=st.floats(-2.0, 2.0))
@settings(max_examples=20, deadline=None)
def test_an_odrive_makes_up_for_the_ripple_in_its_own_position(phase: float, q: float) -> None:
    tables = drive_tables(rippled(phase=phase), link_of("odrive"), {})[1]
    drive = SimulatedOdrive(2)
    for place, value in enumerate(json.loads(tables.files["inner.odrive.json"])["cogging_map"]):
        drive.set_anticogging_value(place, value)
    drive.anticogging_enabled, drive.state = True, 8
    drive.shaft.position_rad = -2.0 * q
    assert -2.0 * drive.torque_nm == pytest.approx(-torque_of(0.03, 36.0, phase, q), abs=1.5e-3)


@given(turns=st.sampled_from([1.0, -1.0, 3.0]), zero=st.floats(0.0, 1.0), q=st.floats(-2.0, 2.0))
@settings(max_examples=20, deadline=None)
def test_a_table_of_counts_is_the_ripple_over_one_turn_of_the_rotor(turns: float, zero: float, q: float) -> None:
    tables = drive_tables(rippled(), link_of("cia402"), {"inner": Motor(None, turns, zero)})[1]
    rows = list(csv.DictReader(io.StringIO(tables.files["inner.cia402.csv"])))
    counts = [float(row["position_counts"]) for row in rows]
    offsets = [float(row["torque_offset_thousandths"]) for row in rows]
    assert counts == sorted(counts)
    turn = 262144.0 / abs(turns)
    at = -2.0 * q / (2.0 * math.pi) * 262144.0 % turn
    told = np.interp(at, [*counts, counts[0] + turn], [*offsets, offsets[0]], period=turn)
    assert -2.0 * told * 2e-3 == pytest.approx(-torque_of(0.03, 36.0, -1.1, q), abs=1e-3)


def test_what_differs_from_turn_to_turn_or_is_too_fine_is_left_out_with_its_reason() -> None:
    model = rippled(order=7.0).with_effect("cogging", "inner", {"amplitude": 0.02, "order": 2600.0, "phase": 0.0})
    model = model.with_effect("cable_spring", "inner", {"stiffness": 0.2})
    tables = drive_tables(model, link_of("moteus"), {"inner": Motor(0.1)})[1]
    reasons = [one.reason for one in tables.left_out if one.item.name in ("cogging", "cable_spring")]
    assert len(reasons) == 3 and not tables.ripple.holds_something
    assert (
        sum("every turn" in reason for reason in reasons) == 2 and sum("too few" in reason for reason in reasons) == 1
    )
    assert set(tables.files) == {"inner.friction.csv"}


@pytest.mark.parametrize(("order", "held"), [(13.9999, True), (14.2, False)])
def test_a_fitted_order_that_is_whole_within_its_digits_goes_into_a_table(order: float, held: bool) -> None:
    tables = drive_tables(rippled(order=order), link_of("moteus"), {"inner": Motor(0.1)})[1]
    assert tables.ripple.holds_something is held
    assert held or "every turn" in tables.left_out[-1].reason


def test_every_number_of_friction_and_every_effect_is_on_a_list() -> None:
    model = rippled().with_effect("load_dependent_friction", "inner", {"coefficient": 0.05})
    model = model.with_effect("coulomb_asymmetry", "inner", {"asymmetry": 0.2})
    tables = drive_tables(model, link_of("odrive"), {})[1]
    held = {item.name for item in tables.held}
    assert {"friction.coulomb", "friction.sigma0", "coulomb_asymmetry"} <= held
    assert [one.item.name for one in tables.approximated] == ["cogging"]
    assert [one.item.name for one in tables.left_out] == ["load_dependent_friction"]


@pytest.mark.parametrize("effect", ["coulomb_asymmetry", "viscous_asymmetry", "quadratic_drag", "none"])
@pytest.mark.parametrize("rate", [-0.8, 0.3])
def test_friction_at_a_steady_rate_is_what_the_plant_takes(effect: str, rate: float) -> None:
    values = {"coulomb_asymmetry": {"asymmetry": 0.2}, "viscous_asymmetry": {"asymmetry": 0.3}}
    model = shipped_model()
    if effect != "none":
        model = model.with_effect(effect, "inner", values.get(effect, {"coefficient": 0.1}))
    feed = FrictionFeed(friction_table(model, "inner"), 1e-3)
    told = [feed.torque_nm(rate * 1e-3 * k, rate) for k in range(200)][-1]
    for axis in ("outer", "inner"):
        model = model.with_numbers(axis, {f"body.cog.{k}": 0.0 for k in "xyz"})
    plant = Plant(model.with_number("inner", "start.rate", rate))
    corrections = []
    for _ in range(400):
        # a loop about the rate has next to nothing to add
        corrections.append(4.0 * (rate - float(plant.X[RATE + 1])))
        plant.run(np.array([[0.0, told + corrections[-1]]]))
    assert abs(np.mean(corrections[200:])) < 0.01 * abs(told)


def test_friction_along_the_travel_multiplies_the_dry_torque() -> None:
    shape = {"relative_amplitude": 0.4, "order": 3.0, "phase": 0.5}
    table = friction_table(shipped_model().with_effect("position_dependent_friction", "inner", shape), "inner")
    feed, q, rate = FrictionFeed(table, 1e-3), -1.0, 1.0
    told = []
    for _ in range(2000):
        q += rate * 1e-3
        told.append((q, feed.torque_nm(q, rate)))
    for place, torque in told[50::100]:
        share = 1.0 + 0.4 * math.cos(3.0 * place + 0.5)
        assert torque - 0.0336 * rate == pytest.approx(0.1376 * share, rel=0.05)


@pytest.mark.heavy
@pytest.mark.parametrize("drive", MAKES)
def test_ripple_and_reversals_of_simulated_drives_become_at_least_five_times_less(drive: str) -> None:
    model = rippled()
    motors = {"inner": Motor(0.2, -1.0, 0.3)} if drive == "moteus" else {}
    link = link_of(drive)
    found = rehearse(model, link, drive_tables(model, link, motors), 1)
    assert found.ripple_rad_s is not None
    for what, (before, after) in (("ripple, rad/s", found.ripple_rad_s), ("reversal, rad", found.reversal_rad)):
        print(f"\n{drive}: {what}: {before:.4g} without, {after:.4g} with, {before / after:.0f} to 1")
        assert after < before / 5.0, found


def test_a_rehearsal_with_the_wrong_place_of_the_rotor_shows_it() -> None:
    model, link = rippled(), link_of("moteus")
    tables = drive_tables(model, link, {"inner": Motor(0.2, 1.0, 0.0)})
    # half a ripple off, put there behind the tables' back
    shifted = rippled(phase=-1.1 + math.pi)
    found = rehearse(shifted, link, tables, 1)
    assert found.ripple_rad_s is not None and found.ripple_rad_s[1] > 1.5 * found.ripple_rad_s[0]


def test_the_command_writes_what_it_lists_and_refuses_what_it_cannot_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert app.run("init", [str(tmp_path / "mine"), "--yes", "--link", f"moteus:{tmp_path}/bus"]) == 0
    capsys.readouterr()
    model = tmp_path / "better.yaml"
    axes = ("azimuth", "elevation")
    ripple = {"amplitude": 0.02, "order": 14.0, "phase": 0.3}
    model.write_text(load_model(tmp_path / "mine" / "model.yaml").with_effect("cogging", axes[1], ripple).to_yaml())
    words = [str(model), "--config", str(tmp_path / "mine" / "antenna.yaml"), "--out", str(tmp_path / "tables")]
    for more, key in (
        ([], "--torque-constant"),
        (["--torque-constant", "roll=0.1"], "--torque-constant"),
        (["--torque-constant", "elevation=-1"], "--torque-constant"),
        (["--rotor-turns", "elevation=0"], "--rotor-turns"),
    ):
        with pytest.raises(SystemExit) as refused:
            app.run("drive-tables", [*words, *more])
        assert refused.value.code == 2 and key in capsys.readouterr().err
    assert not (tmp_path / "tables").exists()
    assert app.run("drive-tables", [*words, "--torque-constant", "elevation=0.1"]) == 0
    said = capsys.readouterr().out
    assert "1024 places" in said and "next: gimbal-hil drive-tables" in said
    document = json.loads((tmp_path / "tables" / "drive_tables.json").read_text())
    listed = {name for one in document["axes"] for name in one["files"]}
    assert listed | {"drive_tables.json"} == {path.name for path in (tmp_path / "tables").iterdir()}
    with pytest.raises(SystemExit) as refused:
        app.run("drive-tables", [*words, "--torque-constant", "elevation=0.1"])
    assert refused.value.code == 2


def test_drives_without_a_table_and_slides_are_refused() -> None:
    with pytest.raises(BadInputError, match="no table"):
        drive_tables(shipped_model(), link_of("dbc"), {})
    with pytest.raises(BadInputError, match="over its own position"):
        drive_tables(rippled(), link_of("odrive"), {"inner": Motor(None, 2.0, 0.0)})
    with pytest.raises(BadInputError, match="linear"):
        drive_tables(shipped_model("emps"), link_of("odrive"), {})
