"""Identification from a run folder that the host wrote: segments become plateaus, ramps and pulses by themselves."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from gimbal_hil.knowledge.experiments.antenna import LockstepAntenna
from gimbal_hil.knowledge.experiments.conducting import embedded_model_of, run_header
from gimbal_hil.knowledge.experiments.experiment import Experiment, Step, move_to, position_hold, step_of
from gimbal_hil.knowledge.experiments.runner import run_experiment
from gimbal_hil.loop.host import AxisCommand, Mode, ReferenceOrigin, Shape
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.surface.cli.app import run
from tests.identification.one_axis_rig import OUTER, pulses, slow_ramp

SPEEDS = (0.002, 0.004, 0.008, 0.015, 0.03, 0.06, 0.1)


def _torque(values: np.ndarray) -> AxisCommand:
    return AxisCommand(Mode.TORQUE, Shape.TABLE, (0.001, 1.0), ReferenceOrigin.ABSOLUTE, table=values)


def _steps(rate_hz: float) -> Sequence[Step]:
    still = position_hold(0.0)
    steps = [step_of("start", rate_hz, 1.0, (move_to(0.0, 0.8), still))]
    for speed in SPEEDS:
        span = max(0.02, 4.0 * speed)
        for way in (1.0, -1.0):
            name = f"outer {way * speed:+.3f} rad/s"
            slide = AxisCommand(Mode.POSITION, Shape.RAMP, (0.0, way * speed, span), ReferenceOrigin.START)
            steps.append(step_of(name, rate_hz, span / speed, (slide, still)))
    for name, torque in (("ramp", slow_ramp(0.2, 20.0)), ("pulses", pulses(0.12, 4.0))):
        steps.append(step_of(f"rest before {name}", rate_hz, 1.0, (_torque(np.zeros(1000)), still)))
        steps.append(step_of(f"outer {name}", rate_hz, len(torque) / rate_hz, (_torque(torque), still)))
    return steps


@pytest.mark.heavy
def test_a_run_of_the_virtual_antenna_gives_its_outer_friction(tmp_path: Path) -> None:
    settings = shipped_settings()
    model, seed = embedded_model_of(settings)
    experiment = Experiment(
        "mixed",
        "sliding and presliding",
        tuple(_steps(settings.rate_hz)),
        lambda step, signals: None,
        lambda rows, drawn: [],
    )
    header = run_header(settings, model, seed, "mixed", 1)
    run_experiment(experiment, LockstepAntenna(settings, model, seed), tmp_path / "run", header)
    assert (
        run("identify", [str(tmp_path / "run"), "--out", str(tmp_path / "out"), "--axis", "outer", "--workers", "1"])
        == 0
    )
    record = json.loads((tmp_path / "out" / "identification.json").read_text())
    found = {e["name"]: e for e in record["axes"][0]["estimates"]}
    true = {
        "breakaway": OUTER.static.breakaway,
        "coulomb": OUTER.static.coulomb,
        "sigma0": OUTER.sigma0,
        "sigma1": OUTER.sigma1,
    }
    for name, value in true.items():
        assert found[name]["verdict"] == "identified", name
        assert found[name]["value"] == pytest.approx(value, rel=0.05), name
