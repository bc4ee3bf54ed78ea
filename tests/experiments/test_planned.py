"""Plan files as experiments: the shipped example runs, and its table says what the axes did."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.experiments.planned import conclude, experiment_of_file
from gimbal_hil.loop.host import HostState, program_of
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.pages.report import Callout, Table
from gimbal_hil.realtime.lockstep import CompiledPath
from sim_backend.model import shipped_model
from sim_backend.shipped import shipped_file

EXAMPLE = shipped_file("plans", "two_speeds.yaml")


def test_the_shipped_plan_runs_and_measures_its_speeds() -> None:
    experiment = experiment_of_file(EXAMPLE, 1000.0)
    path = CompiledPath(shipped_settings(), shipped_model(), 1)
    path.connect()
    rows = []
    for step in experiment.steps:
        recorded = path.run(program_of([step.segment]))
        assert path.host.state is HostState.ACTIVE
        if step.measured:
            rows.append({"step": step.name} | (experiment.measure(step, recorded.signals()) or {}) | dict(step.meaning))
    assert [row["step"] for row in rows] == [
        "slow there, lap 0",
        "fast back, lap 0",
        "slow there, lap 1",
        "fast back, lap 1",
    ]
    assert [row["repeat"] for row in rows] == [0, 0, 1, 1]
    assert rows[0]["outer_rate_mean_rad_s"] == pytest.approx(0.02, abs=2e-3)
    assert rows[1]["duration_s"] < 2.9
    assert all(math.isfinite(row["inner_torque_mean_nm"]) for row in rows)
    assert [type(block) for block in conclude(rows, {})] == [Callout, Table]


def test_a_file_that_is_no_plan_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "plan.yaml"
    path.write_text("schema: 1\nname: x\nsegments: 3\n")
    with pytest.raises(BadInputError, match="segments"):
        experiment_of_file(path, 1000.0)
