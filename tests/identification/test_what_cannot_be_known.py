"""Data that hold little answer with what they hold, in words, never with an error of linear algebra."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from gimbal_hil.knowledge.identification import Determination, RigidAxisRule, axis_identification, fit_rigid_axis
from gimbal_hil.knowledge.identification.axis_response import AxisRecord
from gimbal_hil.knowledge.identification.correlations import Correlations
from gimbal_hil.knowledge.identification.estimate import Estimate, Interval
from gimbal_hil.knowledge.identification.evidence import Evidence
from gimbal_hil.knowledge.identification.output_error import OutputErrorFit, OutputErrorRule
from gimbal_hil.knowledge.identification.stiffness import disagreement, doubted
from gimbal_hil.knowledge.identification.stribeck import LugreFriction, StaticFriction
from gimbal_hil.surface.cli.app import run
from sim_backend.model import load_model
from tests.rigs.rig import write_log

STEP_S = 1e-3


@pytest.mark.parametrize("per_direction", [False, True])
def test_motion_one_way_leaves_coulomb_and_offset_to_each_other(per_direction: bool) -> None:
    t = np.arange(0.0, 12.0, STEP_S)
    rate = 1.0 + 0.5 * np.sin(2.0 * t) + 0.2 * np.sin(5.3 * t)
    acceleration = np.cos(2.0 * t) + 1.06 * np.cos(5.3 * t)
    position = np.cumsum(rate) * STEP_S
    torque = 0.5 * acceleration + 0.3 * rate + 0.2 + 0.01 * np.random.default_rng(1).normal(size=len(t))
    fit = fit_rigid_axis(t, position, torque, RigidAxisRule(20.0, per_direction=per_direction))
    found = {e.name: e for e in fit.estimates}
    assert found["inertia"].value == pytest.approx(0.5, rel=0.02)
    assert found["viscous_positive" if per_direction else "viscous"].value == pytest.approx(0.3, rel=0.05)
    for name in ("viscous_negative", "coulomb_negative") if per_direction else ("coulomb", "offset"):
        assert found[name].verdict is Determination.NOT_IDENTIFIED and found[name].reason
    if not per_direction:
        assert "offset" in found["coulomb"].reason


def rig(folder: Path, sigma0: float) -> Path:
    friction = {"coulomb": 2.0, "breakaway": 2.4, "stribeck_velocity": 0.02, "viscous": 0.5}
    friction |= {"sigma0": sigma0, "sigma1": 20.0 if sigma0 else 0.0}
    axis = {"body": {"inertia": {"zz": 0.5}}, "friction": friction, "encoder": {"step": 1e-6}}
    model = folder / "arm.yaml"
    model.write_text(yaml.safe_dump({"schema": 1, "name": "arm", "kind": "rotary", "axes": {"arm": axis}}))
    return model


def presliding_ramps(folder: Path, count: int, seconds: float) -> list[str]:
    """Torque ramps below break-away on a joint that is a spring with the exact bend of its bristles."""
    paths = []
    for k in range(count):
        t = np.arange(0.0, seconds, STEP_S)
        torque = (1.6 if k % 2 == 0 else -1.6) * t / seconds
        bend = -2.4 / 3000.0 * np.log(1.0 - np.abs(torque) / 2.4) * np.sign(torque)
        position = 1e-6 * np.round(bend / 1e-6)
        paths.append(
            str(write_log(folder / f"ramp{k}.csv", {"time_s": t, "arm.torque": torque, "arm.position": position}))
        )
    return paths


@pytest.mark.parametrize(("sigma0", "seconds"), [(0.0, 3.0), (4000.0, 1.5)])
def test_six_short_ramps_below_break_away_say_what_they_can(tmp_path: Path, sigma0: float, seconds: float) -> None:
    model, logs = rig(tmp_path, sigma0), presliding_ramps(tmp_path, 6, seconds)
    code = run(
        "identify", [*logs, "--model", str(model), "--torque-driven", "--out", str(tmp_path / "out"), "--workers", "1"]
    )
    answer = json.loads((tmp_path / "out" / "identification.json").read_text())
    found = {e["name"]: e for e in answer["axes"][0]["estimates"]}
    assert code in (0, 1)
    assert found["coulomb"]["verdict"] == found["viscous"]["verdict"] == "not_identified"
    assert all(e["reason"] and e["experiment"] for e in found.values() if e["verdict"] == "not_identified")
    if sigma0:
        assert found["sigma0"]["value"] == pytest.approx(3000.0, rel=0.05)


def test_presliding_that_is_not_said_to_be_torque_driven_leaves_the_model_as_it_is(tmp_path: Path) -> None:
    model = rig(tmp_path, 3000.0)
    t = np.arange(0.0, 40.0, STEP_S)
    torque = 1.6 * (2.0 * np.abs((t / 4.0) % 2.0 - 1.0) - 1.0)
    bend = -2.4 / 3000.0 * np.log(1.0 - np.abs(torque) / 2.4) * np.sign(torque)
    columns = {"time_s": t, "arm.torque": torque, "arm.position": 1e-6 * np.round(bend / 1e-6)}
    log = write_log(tmp_path / "log.csv", columns)
    code = run("identify", [str(log), "--model", str(model), "--out", str(tmp_path / "out"), "--workers", "1"])
    assert code in (0, 1)
    answer = json.loads((tmp_path / "out" / "identification.json").read_text())
    found = {e["name"]: e for e in answer["axes"][0]["estimates"]}
    for name in ("coulomb", "viscous", "inertia"):
        assert found[name]["verdict"] == "not_identified" and "--torque-driven" in found[name]["experiment"]
    written, stated = (yaml.safe_load(path.read_text())["axes"]["arm"] for path in (tmp_path / "out/model.yaml", model))
    assert load_model(tmp_path / "out" / "model.yaml").number("arm", "friction.coulomb") == 2.0
    assert written["body"] == stated["body"]


@pytest.mark.parametrize("noise", [1e-3, 0.03])
def test_a_reference_that_changes_in_every_row_is_told_from_the_motion(noise: float, tmp_path: Path) -> None:
    model = rig(tmp_path, 0.0)
    t = np.arange(0.0, 40.0, 0.002)
    levels = np.array([0.1, -0.1, 0.2, -0.2, 0.4, -0.4, 0.6, -0.6])
    asked = levels[np.minimum((t / 5.0).astype(int), 7)]
    columns = {
        "time_s": t,
        "arm.torque": 2.0 * np.sign(asked) + 0.5 * asked + 0.01 * np.random.default_rng(1).normal(size=len(t)),
        "arm.position": 1e-6 * np.round(np.cumsum(asked) * 0.002 / 1e-6),
        "arm.rate_ref": asked * (1.0 + noise * np.random.default_rng(2).normal(size=len(t))),
    }
    log = write_log(tmp_path / "log.csv", columns)
    run("identify", [str(log), "--model", str(model), "--out", str(tmp_path / "out"), "--workers", "1"])
    answer = json.loads((tmp_path / "out" / "identification.json").read_text())
    found = {e["name"]: e for e in answer["axes"][0]["estimates"]}
    assert found["coulomb"]["value"] == pytest.approx(2.0, rel=0.02) and found["coulomb"]["verdict"] != "not_identified"
    assert found["viscous"]["value"] == pytest.approx(0.5, rel=0.1)


KNOWN = LugreFriction(StaticFriction(2.4, 2.0, 0.02, 0.5, 1.0), 3000.0, 20.0)


def fit_of(*estimates: Estimate) -> OutputErrorFit:
    size = len(estimates)
    apart = Correlations(tuple(one.name for one in estimates), np.eye(size), np.full(size, 0.1))
    return OutputErrorFit(estimates, KNOWN, 0.0, (), (), 0.0, np.ones(size), 1, apart)


def estimate(name: str, low: float, high: float) -> Estimate:
    verdict = Determination.IDENTIFIED
    return Estimate(name, 0.5 * (low + high), Interval(low, high), "1", verdict, 0.01, 1.0, "", "")


@pytest.mark.parametrize(("travel", "slides"), [(1e-3, False), (0.1, True)])
def test_a_joint_that_never_slides_keeps_what_the_model_says_of_sliding(
    travel: float, slides: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[str, ...]] = []

    def fitted(records: object, inertia: float, known: object, free: tuple[str, ...], *_: object) -> OutputErrorFit:
        asked.append(free)
        return fit_of(estimate("sigma1", 19.0, 21.0))

    monkeypatch.setattr(axis_identification, "fit_output_error", fitted)
    t = np.arange(0.0, 4.0, STEP_S)
    record = AxisRecord("log", STEP_S, np.sin(3.0 * t), 0.5 * travel * np.sin(3.0 * t))
    axis_identification._bristles(Evidence("arm", (), (), (record,), 0.5), KNOWN, False, 1e-6, OutputErrorRule())
    assert ("viscous" in asked[0]) is slides
    assert {"breakaway", "sigma0", "sigma1"} <= set(asked[0])


def test_where_slow_ramps_exclude_a_stiffness_they_count_and_the_rest_is_weakly_known() -> None:
    dynamic = fit_of(estimate("sigma0", 2700.0, 2800.0), estimate("sigma1", 19.0, 21.0))
    slow = SimpleNamespace(sigma0=estimate("sigma0", 2990.0, 3010.0), travel_steps=1e4)
    assert disagreement(slow, dynamic, "arm")  # type: ignore[arg-type]
    found = {e.name: e for e in axis_identification._final(KNOWN, None, None, slow, doubted(dynamic), None)}  # type: ignore[arg-type]
    assert found["sigma0"].value == 3000.0 and found["sigma0"].verdict is Determination.IDENTIFIED
    assert found["sigma1"].verdict is Determination.WEAKLY_IDENTIFIED and "slow ramps" in found["sigma1"].reason
