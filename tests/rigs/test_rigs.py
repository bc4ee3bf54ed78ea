"""Every measured rig can be read as a stranger would bring it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.signals import read_signals
from sim_backend.model import load_model
from tests.rigs import Rig, write_bam, write_dd2dof, write_emps, write_odrive


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
