"""Tuning: what is chosen keeps its margin and is stable, the file keeps its comments, and other antennas work too."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.knowledge.tuning import (
    MARGIN,
    Aim,
    AxisDynamics,
    CascadeLaw,
    NoMarginError,
    Tuning,
    axis_cases,
    axis_inertias,
    disk_margin,
    errors,
    figures,
    largest_pole,
    laws_of,
    tuned,
    tuning_task,
)
from gimbal_hil.knowledge.tuning.choosing import steady_gains
from gimbal_hil.knowledge.tuning.loops import Disturbances
from gimbal_hil.loop.settings import (
    DaemonSettings,
    JointObserver,
    load_settings,
    observed_joint,
    settings_from_document,
    shipped_settings,
    shipped_settings_path,
)
from gimbal_hil.pointing.arena import Trial, chosen, run_trial, shipped_scenarios
from gimbal_hil.surface.cli import main
from sim_backend.model import AntennaModel, shipped_model


def test_a_delayed_rate_loop_is_stable_up_to_the_gain_of_theory() -> None:
    # held torque of 1 ms and 10 ms of delay take a quarter turn at pi / 2 / 0.0105 = 149.6 rad/s
    axis = AxisDynamics(1.0, 0.0, 0.0, 0.010, 0.0, 0.0)
    for gain, stable in ((148.5, True), (150.5, False)):
        pole = largest_pole(CascadeLaw(1e-3, 0.0, 0.0, gain, 0.0), axis)
        # the joint's position is in no loop here: its pole is 1
        assert (pole < 1.0 + 1e-9) is stable


def test_the_error_of_a_walking_torque_is_that_of_a_simulation() -> None:
    axis = AxisDynamics(0.5, 0.05, 0.0, 0.0, 0.0, 0.0)
    law = CascadeLaw(1e-3, 20.0, 20.0, 60.0, 1200.0)
    w = np.geomspace(0.02, 0.98e3 * np.pi, 4000)
    predicted = errors(law, axis, w, Disturbances(1.0, 0.0, 0.0, 0.0)).torque_rad
    draw, kept = np.random.default_rng(3), []
    q = v = walk = position_integral = rate_integral = 0.0
    for _ in range(400_000):
        wanted = -20.0 * q + position_integral
        torque = 60.0 * (wanted - v) + rate_integral
        position_integral -= 20.0 * 1e-3 * q
        rate_integral += 1200.0 * 1e-3 * (wanted - v)
        walk += draw.normal() * 1e-3**0.5
        acceleration = (torque + walk - 0.05 * v) / 0.5
        q, v = q + 1e-3 * (v + 0.5e-3 * acceleration), v + 1e-3 * acceleration
        kept.append(q)
    assert float(np.std(kept)) == pytest.approx(predicted, rel=0.1)


@pytest.fixture(scope="module")
def realistic() -> Tuning:
    return tuned(shipped_settings(), shipped_model("realistic"), "realistic")


def in_force(found: Tuning, tmp_path: Path) -> DaemonSettings:
    from firmware_protocol.documents import yaml_edited

    path = tmp_path / "tuned.yaml"
    text = yaml_edited(shipped_settings_path().read_text(), found.changes, "shipped")
    path.write_text(text.replace("schemas/", ""))
    return load_settings(path)


@pytest.mark.heavy
def test_tuned_loops_keep_the_margin_and_are_better_than_before(realistic: Tuning, tmp_path: Path) -> None:
    model, settings = shipped_model("realistic"), in_force(realistic, tmp_path)
    for one in realistic.axes:
        assert one.observed is not None and one.after.stable_when_wrong
        # of the file as it was written, rounded
        task = tuning_task(model, one.axis, settings.step_s, 0.4)
        for law, case in zip(laws_of(settings, model, one.axis, task), axis_cases(model, one.axis), strict=True):
            assert disk_margin(law.torque(task.frequencies, case)) > 0.395
            assert largest_pole(law, case.varied(0.7, 0.001)) < 1.0
        # by hand: 175 and 60 rad/s outer, 200 and 120 inner, position 20 /s, which predict 26 and 55 urad
        assert one.after.error_rad < {"outer": 24e-6, "inner": 50e-6}[one.axis]
        assert one.after.error_rad < 0.3 * one.before.error_rad


@pytest.mark.heavy
def test_the_tuned_antenna_holds_what_was_asked_in_the_arena(realistic: Tuning, tmp_path: Path) -> None:
    settings = in_force(realistic, tmp_path)
    for words, most in (("case 5", 1.5e-6), ("5 deg/s", 4e-6)):
        scenario = chosen(shipped_scenarios(), words)[0].model_copy(update={"duration_s": 5.0})
        found = run_trial(Trial(scenario, "tuned", settings, "realistic", shipped_model("realistic"), 1))
        assert not found.tripped and found.los_rms < most


@pytest.mark.heavy
def test_a_reference_leaves_the_rate_that_the_loops_ask_for_where_the_model_is_wrong(realistic: Tuning) -> None:
    model, settings = shipped_model("realistic"), shipped_settings()
    for one in realistic.axes:
        section, prefilter = settings.axes[one.axis], one.changes[f"axes.{one.axis}.prefilter"]
        stiffness = one.changes[f"axes.{one.axis}.rate_loop.kp_s_per_rad"] * section.rate_loop.torque_per_unit_nm
        # inertia 30 % off while it speeds up, as a rate that the proportional gain of the rate loop has to see
        torque = 0.3 * prefilter["acceleration_rad_s2"] * axis_inertias(model, one.axis)[0]
        most = section.position_loop.rate_limit_rad_s
        assert 0.9 * torque / stiffness < most - prefilter["rate_rad_s"] < 3.0 * torque / stiffness


@pytest.mark.heavy
@pytest.mark.parametrize("times", [0.2, 5.0])
def test_another_inertia_gets_gains_in_proportion(times: float) -> None:
    model = heavier(times)
    found = tuned(shipped_settings(), model, "x")
    for one in found.axes:
        assert one.after.margin >= 0.4 and one.after.stable_when_wrong
        crossing = one.changes[f"axes.{one.axis}.rate_loop.kp_s_per_rad"] / axis_inertias(model, one.axis)[0]
        assert 40.0 < crossing < 150.0


def heavier(times: float) -> AntennaModel:
    model = shipped_model("realistic")
    for axis in model.axes:
        paths = [f"body.inertia.{key}" for key in ("xx", "yy", "zz", "xy", "xz", "yz")]
        model = model.with_numbers(axis, {path: times * model.number(axis, path) for path in paths})
    return model


@pytest.mark.parametrize(("bandwidth", "gusts_above"), [(150.0, math.inf), (700.0, 80.0), (200.0, 2.0)])
def test_the_gains_of_the_search_are_those_of_the_host(bandwidth: float, gusts_above: float) -> None:
    model = shipped_model("realistic")
    observer = JointObserver(bandwidth_rad_s=bandwidth)
    joint = replace(observed_joint(model, "outer", 1e-3, observer), gusts_above_rad_s=gusts_above)
    np.testing.assert_allclose(steady_gains(joint), joint.gains(), rtol=1e-4, atol=1e-7 * np.abs(joint.gains()).max())


def test_an_observer_that_expects_gusts_is_stiffer_at_the_same_margin_and_shakes_the_torque_no_more_than_allowed(
    realistic: Tuning, tmp_path: Path
) -> None:
    model, settings = shipped_model("realistic"), in_force(realistic, tmp_path)
    for axis, gusts in (("outer", 110e-6), ("inner", 105e-6)):
        task = tuning_task(model, axis, settings.step_s, MARGIN)
        assert settings.axes[axis].observer is not None and settings.axes[axis].observer.gusts_above_rad_s
        laws = laws_of(settings, model, axis, task)
        for law, case in zip(laws, task.cases, strict=True):
            # a torque of 1 rad/s^2, even over the band of gusts
            given = replace(task.disturbances, gust_nm=case.inertia_kg_m2)
            found = errors(law, case, task.frequencies, given)
            assert found.gust_rad < gusts and found.noise_nm < 1.05 * task.most_noise_nm


def test_a_margin_that_nothing_keeps_is_said_by_axis() -> None:
    with pytest.raises(NoMarginError, match="outer"):
        tuned(shipped_settings(), shipped_model("realistic"), "realistic", 1.9)


@pytest.mark.heavy
def test_the_command_writes_a_file_that_check_accepts_with_its_comments(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "antenna.yaml"
    config.write_text(shipped_settings_path().read_text())
    with pytest.raises(SystemExit) as end:
        main(["tune", "--config", str(config), "--model", "realistic", "--json"])
    assert end.value.code == 0
    said = json.loads(capsys.readouterr().out)
    written = Path(said["out"]).read_text()
    comments = [line for line in config.read_text().splitlines() if line.lstrip().startswith("#")]
    assert comments and all(line in written for line in comments)
    settings = load_settings(Path(said["out"]))
    assert settings.model_control is not None and settings.model_control.model == "realistic"
    assert settings.axes["outer"].observer is not None
    assert said["axes"]["outer"]["observed"]["margin"] >= 0.4
    # a second time it would overwrite
    with pytest.raises(SystemExit) as end:
        main(["tune", "--config", str(config), "--model", "realistic"])
    assert end.value.code == 2


def test_a_single_axis_gets_a_cascade() -> None:
    model = shipped_model("emps")
    found = tuned(shipped_settings().for_axes(model.axes, "emps"), model, "emps")
    (one,) = found.axes
    assert one.observed is None and one.cascade.margin >= 0.4 and "model_control" not in found.changes


@pytest.mark.heavy
def test_tuned_for_pointing_gusts_move_the_joint_less_and_the_margin_stays(realistic: Tuning) -> None:
    model = shipped_model("realistic")
    pointing = tuned(shipped_settings(), model, "realistic", MARGIN, Aim.POINTING)
    task = tuning_task(model, "outer", 1e-3, MARGIN, Aim.POINTING)
    gusts = []
    for found in (realistic, pointing):
        document = shipped_settings().model_dump(mode="json", by_alias=True)
        document["axes"]["outer"]["observer"] = found.changes["axes.outer.observer"]
        document["model_control"] = {"model": "realistic"}
        laws = laws_of(settings_from_document(document, "tuned"), model, "outer", task)
        cases = zip(laws, task.cases, strict=True)
        gusts.append(max(errors(law, case, task.frequencies, task.disturbances).gust_rad for law, case in cases))
        # gains are written with four digits
        assert figures(laws, task).margin > MARGIN - 2e-3
    assert gusts[1] < 0.95 * gusts[0]


@pytest.mark.heavy
def test_tuned_for_both_gusts_move_the_joint_less_and_friction_no_more(realistic: Tuning) -> None:
    model = shipped_model("realistic")
    both = tuned(shipped_settings(), model, "realistic", MARGIN, Aim.BOTH)
    task = tuning_task(model, "outer", 1e-3, MARGIN, Aim.BOTH)
    gusts, torques = [], []
    for found in (realistic, both):
        document = shipped_settings().model_dump(mode="json", by_alias=True)
        document["axes"]["outer"]["observer"] = found.changes["axes.outer.observer"]
        document["model_control"] = {"model": "realistic"}
        laws = laws_of(settings_from_document(document, "tuned"), model, "outer", task)
        left = [
            errors(law, case, task.frequencies, task.disturbances) for law, case in zip(laws, task.cases, strict=True)
        ]
        gusts.append(max(one.gust_rad for one in left))
        torques.append(max(one.torque_rad for one in left))
    assert gusts[1] < 0.9 * gusts[0] and torques[1] < 1.02 * torques[0]


def test_an_aim_that_there_is_not_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["tune", "--config", str(shipped_settings_path()), "--out", str(tmp_path / "t.yaml"), "--for", "speed"])
    assert "pointing, tracking, both" in capsys.readouterr().err
