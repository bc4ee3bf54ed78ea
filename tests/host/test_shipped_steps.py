"""The shipped gains on the virtual antenna: steps of both axes, as shipped, and with a slow gyro and a late link."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from firmware_protocol.links import DirectionFaults, FaultsConfig
from gimbal_hil.loop.host import AxisCommand, Mode, Segment, Shape, program_of
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.lockstep import CompiledPath, FramePath, Recorded
from sim_backend.model import shipped_model

STEP = program_of(
    [
        Segment(
            AxisCommand(Mode.POSITION, Shape.HOLD, (0.0,)),
            AxisCommand(Mode.POSITION, Shape.HOLD, (0.0,)),
            1500,
            label=0,
        ),
        Segment(
            AxisCommand(Mode.POSITION, Shape.HOLD, (1.0,)),
            AxisCommand(Mode.POSITION, Shape.HOLD, (0.5,)),
            4000,
            label=1,
        ),
    ]
)


def after_step(recorded: Recorded, name: str) -> NDArray[np.float64]:
    """Position of an axis from the step on."""
    return recorded.signals()[f"{name}.position"][recorded.segment == 1]


@pytest.mark.parametrize(("name", "size", "settling_s"), [("outer", 1.0, 1.0), ("inner", 0.5, 0.7)])
def test_a_position_step_settles_with_little_overshoot(name: str, size: float, settling_s: float) -> None:
    path = CompiledPath(shipped_settings(), shipped_model(), 1)
    path.connect()
    position = after_step(path.run(STEP), name)
    assert position.max() <= 1.02 * size
    late = np.flatnonzero(np.abs(position - size) > 0.02 * size)
    assert late[-1] * 1e-3 < settling_s
    assert np.abs(position[-500:] - size).max() < 0.003 * size


@pytest.mark.parametrize("size", [0.2, 2.5, 10.0])
def test_a_step_of_any_size_within_travel_is_a_motion_that_the_loops_follow(size: float) -> None:
    still = AxisCommand(Mode.POSITION, Shape.HOLD, (0.0,))
    inner = AxisCommand(Mode.POSITION, Shape.HOLD, (min(size, 1.9),))
    there = Segment(AxisCommand(Mode.POSITION, Shape.HOLD, (size,)), inner, 8000, label=1)
    path = CompiledPath(shipped_settings(), shipped_model(), 1)
    path.connect()
    # a fault of the host ends the run with an error
    recorded = path.run(program_of([Segment(still, still, 1500, label=0), there]))
    for name, end in (("outer", size), ("inner", min(size, 1.9))):
        position = after_step(recorded, name)
        assert position.max() <= end + 0.02 * min(end, 1.0)
        assert np.abs(position[-500:] - end).max() < 0.003


@pytest.mark.parametrize("name", ["outer", "inner"])
def test_a_slow_gyro_and_a_late_link_are_survived(name: str) -> None:
    model = shipped_model()
    for axis in ("outer", "inner"):
        model = model.with_number(axis, "gyro.bandwidth", 2.0 * math.pi * 200.0)
    late = DirectionFaults(delay=1.0, delay_ticks=1)
    path = FramePath(shipped_settings(), model, 1, FaultsConfig(send=late, receive=late))
    path.connect()
    recorded = path.run(STEP)
    assert recorded.ticks == 5500
    position = after_step(recorded, name)
    size = {"outer": 1.0, "inner": 0.5}[name]
    assert position.max() <= 1.05 * size
    assert np.abs(position[-500:] - size).max() < 0.005 * size
    rate = recorded.signals()[f"{name}.rate"][recorded.segment == 1][-500:]
    assert np.std(rate) < 5e-3
