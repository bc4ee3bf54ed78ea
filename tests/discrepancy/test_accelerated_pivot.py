"""A pivot that accelerates pulls on unbalanced bodies: logs say how, plant and twin both reckon with it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Request, Result, diagnose
from sim_backend.model import AntennaModel, shipped_model
from sim_backend.plant import Plant

T = np.arange(8000) * 1e-3


def pivot(speed: float) -> np.ndarray:
    """Acceleration in base axes, (n, 3), m/s^2."""
    return np.column_stack([3.0 * np.sin(speed * T), 4.0 * np.sin(1.3 * speed * T), 1.5 * np.sin(0.7 * speed * T)])


def log(model: AntennaModel, folder: Path, speed: float) -> SignalsTable:
    """Both axes driven through friction on a level base that is shaken."""
    pushed = pivot(speed)
    rows = np.column_stack([T, np.zeros((len(T), 3)), pushed])
    np.savetxt(
        folder / "base.csv", rows, fmt="%.17g", delimiter=",", header="time_s,roll,pitch,yaw,ax,ay,az", comments=""
    )
    torque = np.column_stack([0.9 * np.sin(speed * T), 0.5 * np.sin(1.4 * speed * T)])
    ran = Plant(model.with_base({"motion": "recorded", "file": str(folder / "base.csv")})).run(torque)
    columns = {"outer.torque": torque[:, 0], "inner.torque": torque[:, 1]}
    for i, axis in enumerate(("outer", "inner")):
        columns |= {f"{axis}.position": ran.encoder[:, i], f"{axis}.rate": ran.gyro[:, i]}
    columns |= {f"base.{name}": pushed[:, i] for i, name in enumerate(("ax", "ay", "az"))}
    return SignalsTable.of(("outer", "inner"), T, columns)


def without_pivot(table: SignalsTable) -> SignalsTable:
    kept = {name: values for name, values in table.columns.items() if not name.startswith("base.")}
    return SignalsTable.of(table.axes, table.time_s, kept)


def torque_left(result: Result) -> np.ndarray:
    """What the model as stated leaves of both torques, floors."""
    torques = [channel.signal == "torque" for channel in result.inquiry.twin.channels]
    return np.asarray(result.stated.left()[torques])


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> tuple[SignalsTable, SignalsTable]:
    folder = tmp_path_factory.mktemp("pivot")
    return log(shipped_model(), folder, 2.0), log(shipped_model(), folder, 2.9)


def test_nothing_is_missing_where_the_log_has_the_acceleration(logs: tuple[SignalsTable, SignalsTable]) -> None:
    result = diagnose(Request(shipped_model(), logs[:1], logs[1:], only=("cogging",)))
    assert result.decision.kind.value == "no_discrepancy"
    assert float(torque_left(result).max()) < 1.5


@pytest.mark.heavy
def test_a_gap_stands_where_the_log_keeps_it_to_itself(logs: tuple[SignalsTable, SignalsTable]) -> None:
    bare = tuple(without_pivot(table) for table in logs)
    result = diagnose(Request(shipped_model(), bare[:1], bare[1:], only=("cogging",)))
    assert float(torque_left(result).max()) > 10.0
