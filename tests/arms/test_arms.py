"""One joint of an arm that another simulator moves: what the other links do to it is known, what is left is its own."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.arms import arm_of_urdf, one_joint
from gimbal_hil.data.signals import SignalsTable, read_signals
from gimbal_hil.surface.cli.app import run
from tests.arms.six_joints import COULOMB, JOINTS, STEP_S, VISCOUS, moved, urdf

pytest.importorskip("pinocchio", reason="the extra urdf has it")
mujoco = pytest.importorskip("mujoco", reason="the extra test has it")


@pytest.fixture(name="arm_file")
def _arm_file(tmp_path: Path) -> Path:
    path = tmp_path / "arm.urdf"
    path.write_text(urdf())
    return path


def test_torques_of_a_motion_are_those_of_another_simulator(arm_file: Path) -> None:
    arm = arm_of_urdf(arm_file)
    assert arm.joints == JOINTS
    model = mujoco.MjModel.from_xml_string(urdf())
    data = mujoco.MjData(model)
    random = np.random.default_rng(3)
    states = random.normal(size=(3, 5, 6))
    found = arm.torques(*states)
    for row in range(5):
        data.qpos[:], data.qvel[:], data.qacc[:] = states[:, row]
        mujoco.mj_inverse(model, data)
        rigid = data.qfrc_inverse + data.qfrc_passive + data.qfrc_constraint
        assert np.allclose(found[row], rigid, atol=1e-8)
    asked = []
    for acceleration in (0.0, 1.0):
        data.qpos[:], data.qvel[:], data.qacc[:] = states[0, 0], 0.0, 0.0
        data.qacc[2] = acceleration
        mujoco.mj_inverse(model, data)
        asked.append(float((data.qfrc_inverse + data.qfrc_passive + data.qfrc_constraint)[2]))
    assert arm.inertia(states[0, 0], "elbow") == pytest.approx(asked[1] - asked[0], rel=1e-6)


@pytest.mark.heavy
def test_what_is_left_of_a_joint_is_its_own_friction(tmp_path: Path, arm_file: Path) -> None:
    log, out = tmp_path / "log.csv", tmp_path / "elbow.csv"
    moved(log, 1, 6.0, ripple=0.0)
    assert run("joint", [str(log), "--urdf", str(arm_file), "--joint", "elbow", "--out", str(out), "--json"]) == 0
    table = read_signals(out, ("elbow",))
    rate = np.gradient(table.position("elbow"), table.period_s)
    fast = np.abs(rate) > 0.3
    acceleration = np.gradient(rate, table.period_s)
    inertia = arm_of_urdf(arm_file).inertia(np.zeros(6), "elbow")
    assert np.sqrt(np.mean(table.commanded("elbow") ** 2)) > 5.0 * COULOMB
    own = (table.torque("elbow") - inertia * acceleration)[fast]
    columns = np.stack((np.sign(rate), rate), axis=1)[fast]
    (coulomb, viscous), *_ = np.linalg.lstsq(columns, own, rcond=None)
    assert coulomb == pytest.approx(COULOMB, rel=0.1) and viscous == pytest.approx(VISCOUS, rel=0.3)


def arm_log(positions: dict[str, np.ndarray], torque: np.ndarray) -> SignalsTable:
    columns = {f"{name}.position": values for name, values in positions.items()} | {"elbow.torque": torque}
    return SignalsTable.of(tuple(positions), np.arange(len(torque)) * STEP_S * 8, columns, source="log.csv")


def test_a_standing_arm_asks_for_its_weight_alone(arm_file: Path) -> None:
    arm = arm_of_urdf(arm_file)
    pose = dict(zip(JOINTS, (0.1, 0.4, -0.3, 0.2, 0.5, 0.0), strict=True))
    still = {name: np.full(60, value) for name, value in pose.items() if name != "wrist"}
    found = one_joint(arm, arm_log(still, np.zeros(60)), "elbow", {"wrist": 0.5})
    rest = np.zeros((1, 6))
    weight = arm.torques(np.array([list(pose.values())]), rest, rest)[0, 2]
    assert np.allclose(found.table.columns["elbow.torque_known"], weight, atol=1e-9) and abs(weight) > 1.0
    assert np.allclose(found.table.torque("elbow"), -weight, atol=1e-9)


def test_what_is_missing_is_told_by_name(arm_file: Path, tmp_path: Path) -> None:
    arm = arm_of_urdf(arm_file)
    still = {name: np.zeros(60) for name in JOINTS if name != "wrist"}
    with pytest.raises(BadInputError, match=r"no position of wrist.*--held wrist=POSITION"):
        one_joint(arm, arm_log(still, np.zeros(60)), "elbow")
    with pytest.raises(BadInputError, match="no joint 'ellbow'; expected one of base, shoulder, elbow"):
        one_joint(arm, arm_log(still, np.zeros(60)), "ellbow")
    for text in ("", "<robot", "<robot name='x'><link name='a'/></robot>", json.dumps({})):
        (tmp_path / "bad.urdf").write_text(text)
        with pytest.raises(BadInputError, match=r"bad\.urdf"):
            arm_of_urdf(tmp_path / "bad.urdf")


def test_without_its_package_a_urdf_names_the_extra(arm_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(BadInputError, match=r"needs the package pin.*gimbal-hil\[urdf\]"):
        arm_of_urdf(arm_file)
