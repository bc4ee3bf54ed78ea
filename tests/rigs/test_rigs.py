"""Every measured rig can be read as a stranger would bring it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import savgol_filter

from gimbal_hil.data.signals import read_signals
from gimbal_hil.knowledge.discrepancy import standing
from sim_backend.model import load_model
from tests.rigs import Rig, turret, worn, write_bam, write_dd2dof, write_emps, write_odrive
from tests.rigs.drawn import AXIS, HIDDEN, drawn_joint, simulated
from tests.rigs.many import judged


@pytest.mark.parametrize("write", [write_odrive, write_bam, write_emps, write_dd2dof])
def test_every_log_of_a_measured_rig_is_a_signals_table_of_its_model(
    write: Callable[[Path], Rig], tmp_path: Path
) -> None:
    rig = write(tmp_path)
    axes = load_model(rig.model).axes
    for path in rig.logs.values():
        table = read_signals(path, axes, resample=True)
        assert len(table) > 100 and np.ptp(table.position(axes[0])) > 0.0, path.name


def test_the_pendulum_hangs_downwards_in_its_own_torque(tmp_path: Path) -> None:
    table = read_signals(write_bam(tmp_path).logs["kp400_sin_sin"], ("pendulum",), resample=True)
    sine = np.sin(table.position("pendulum"))
    gravity = np.polyfit(sine, table.torque("pendulum"), 1)[0]
    assert 0.4 < gravity < 0.6


def test_an_error_can_be_planted_in_a_rigs_model(tmp_path: Path) -> None:
    sound = load_model(write_emps(tmp_path / "sound").model)
    halved = load_model(write_emps(tmp_path / "halved", {"body.mass": 0.5}).model)
    assert halved.number("carriage", "body.mass") == 0.5 * sound.number("carriage", "body.mass")


def test_a_drawn_joint_of_another_simulator_obeys_its_own_numbers() -> None:
    joint = drawn_joint(np.random.default_rng(5))
    columns = simulated(joint, HIDDEN["ripple"], seed=1)
    position, torque = (columns[f"{AXIS}.{name}"] for name in ("position", "torque"))
    rate = np.gradient(position, 1.0 / joint.rate_hz)
    smooth = np.convolve(rate, np.ones(20) / 20.0, "same")
    motion = [np.gradient(smooth, 1.0 / joint.rate_hz), smooth, np.sign(smooth)]
    ripple = [np.sin(joint.orders * position), np.cos(joint.orders * position)]
    # near standstill its dry friction is a softer one than a sign
    slides = np.abs(smooth) > 0.1
    found = np.linalg.lstsq(np.column_stack([*motion, *ripple])[slides], torque[slides], rcond=None)[0]
    assert found[0] == pytest.approx(joint.inertia, rel=0.1)
    assert found[1] == pytest.approx(joint.viscous, rel=0.1)
    assert found[2] == pytest.approx(joint.coulomb, rel=0.1)
    assert np.hypot(*found[3:]) == pytest.approx(0.15 * joint.typical, rel=0.1)


def test_a_worn_joint_slides_by_its_own_numbers_and_gives_way_before() -> None:
    joint = worn.drawn_joint(np.random.default_rng(5), "gravity")
    columns = worn.simulated(joint, "sines", seed=1)
    position, torque = (columns[f"{worn.AXIS}.{name}"] for name in ("position", "torque"))
    window, period = round(0.15 * joint.rate_hz) | 1, 1.0 / joint.rate_hz
    q, v, a = (savgol_filter(position, window, 3, deriv=k, delta=period) for k in range(3))
    slides = np.abs(v) > 3.0 * joint.stribeck_rad_s
    slides[: int(2.0 / period)] = False
    motion = np.column_stack([a, v, np.sign(v), np.sin(q + 0.3)])
    found = np.linalg.lstsq(motion[slides], savgol_filter(torque, window, 3)[slides], rcond=None)[0]
    assert found == pytest.approx([joint.inertia, joint.viscous, joint.coulomb, joint.gravity], rel=0.05)


def test_what_a_worn_joint_has_beside_the_planted_number_is_no_false_name() -> None:
    def said(*named: str) -> dict[str, Any]:
        effects = [{"name": name, "status": "named"} for name in named]
        return {"verdict": {"verdict": "named", "effects": effects, "alternatives": []}}

    has = worn.BESIDE["a ripple"]
    assert worn.judged(said("inertia", "cogging", "presliding"), "inertia", has) == "right"
    assert worn.judged(said("inertia", "backlash"), "inertia", has) == "false"
    assert worn.judged(said("cogging"), "inertia", has) == "silent"
    assert worn.judged(said(), None, has) == "right"


def test_what_is_said_of_a_drawn_rig_is_judged_by_names_and_axes_alone() -> None:
    def said(verdict: str, status: str, *names: str, others: tuple[str, ...] = ()) -> dict[str, Any]:
        effects = [{"name": name, "axis": AXIS, "status": status} for name in names]
        alternatives = [{"name": name, "axis": AXIS} for name in others]
        return {"verdict": {"verdict": verdict, "effects": effects, "alternatives": alternatives}}

    viscous, nothing = HIDDEN["viscous halved"].names, HIDDEN["nothing"].names
    assert judged(said("named", "named", "viscous"), viscous, AXIS) == "right"
    assert judged(said("named", "named", "viscous"), viscous, "another") == "false"
    assert judged(said("named", "named", "viscous", "cogging"), viscous, AXIS) == "false"
    assert judged(said("ambiguous", "ambiguous", "coulomb", others=("viscous",)), viscous, AXIS) == "class"
    assert judged(said("unexplained", "named"), viscous, AXIS) == "silent"
    assert judged(said("no_discrepancy", "named"), nothing, AXIS) == "right"
    assert judged(said("ambiguous", "ambiguous", "coulomb"), nothing, AXIS) == "guessed"
    assert judged({"error": "no answer"}, viscous, AXIS) == "error"


@pytest.mark.heavy
def test_a_drawn_gimbal_of_another_simulator_obeys_our_equations_of_motion(tmp_path: Path) -> None:
    dice = np.random.default_rng(6)
    drawn = replace(turret.drawn_turret(dice), sway=0.1, gyro=3e-4, rate_hz=250.0, softness_s=0.002)
    rig = turret.write_turret(tmp_path, drawn, turret.HIDDEN["nothing"], axis=0, seed=6)
    model = load_model(rig.model)
    table = read_signals(rig.logs["first"], model.axes)
    # three numbers of the file are off by 3 to 5 % each, and MuJoCo's dry friction is soft near standstill
    for gap in standing(model, table):
        if gap["signal"] == "torque":
            scale = float(np.std(table.torque(gap["axis"])))
            assert gap["before"] < 0.1 * scale, gap
        else:
            # a step of the simulator lies between its angle and its rate
            assert gap["before"] < 3.0 * gap["noise_floor"], gap
    turns = table.columns["azimuth.rate"] - np.gradient(table.position("azimuth"), table.period_s)
    assert np.std(turns) > 0.02, "the base turns"
