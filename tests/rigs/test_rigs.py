"""Every measured rig can be read as a stranger would bring it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import savgol_filter

from gimbal_hil.signals import read_signals
from sim_backend.model import load_model
from tests.rigs import Rig, worn, write_bam, write_dd2dof, write_emps, write_odrive
from tests.rigs.drawn import AXIS, HIDDEN, drawn_joint, judged, simulated


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


def test_what_is_said_of_a_drawn_joint_is_judged_by_names_alone() -> None:
    def said(verdict: str, status: str, *names: str, others: tuple[str, ...] = ()) -> dict[str, Any]:
        effects = [{"name": name, "status": status} for name in names]
        return {"verdict": {"verdict": verdict, "effects": effects, "alternatives": [{"name": n} for n in others]}}

    viscous = HIDDEN["viscous halved"]
    assert judged(said("named", "named", "viscous"), viscous) == "right"
    assert judged(said("named", "named", "viscous", "cogging"), viscous) == "false"
    assert judged(said("ambiguous", "ambiguous", "coulomb", others=("viscous",)), viscous) == "class"
    assert judged(said("unexplained", "named"), viscous) == "silent"
    assert judged(said("no_discrepancy", "named"), HIDDEN["nothing"]) == "right"
    assert judged(said("ambiguous", "ambiguous", "coulomb"), HIDDEN["nothing"]) == "guessed"
    assert judged({"error": "no answer"}, viscous) == "error"
