"""A stop changes the torque by no more than the first step of braking takes, whatever the loops have of a model."""

from __future__ import annotations

import numpy as np
import pytest

from gimbal_hil.loop.control import layout as control
from gimbal_hil.loop.host import AxisCommand, HostState, Mode, Segment, Shape, layout, program_of
from gimbal_hil.pointing.arena import CONTROLLERS, LAWS, controller_settings
from gimbal_hil.realtime.lockstep import CompiledPath
from sim_backend.model import shipped_model
from tests.parts import heavy_but

AXES = ("outer", "inner")
#: where the shaped reference, taken for a rate, would ask for the most
START = (2.5, 0.9)
#: torque of gyro noise from tick to tick
NOISE_NM = 0.1
DOES = {
    "rests": (AxisCommand(Mode.POSITION, Shape.HOLD, (2.5,)), AxisCommand(Mode.POSITION, Shape.HOLD, (0.9,))),
    "turns": (AxisCommand(Mode.RATE, Shape.HOLD, (0.2,)), AxisCommand(Mode.INERTIAL_RATE, Shape.HOLD, (-0.1,))),
    "is pushed": (AxisCommand(Mode.TORQUE, Shape.HOLD, (0.5,)), AxisCommand(Mode.OFF)),
}


def antenna(controller: str, does: str) -> CompiledPath:
    """One that does something since half a second, after it came to rest at START."""
    engine = CompiledPath(controller_settings(controller), shipped_model("realistic"), 1)
    engine.connect()
    outer, inner = (AxisCommand(Mode.POSITION, Shape.SMOOTH, (value, 2.0)) for value in START)
    engine.run(program_of([Segment(outer, inner, 2500)]))
    engine.host.command(program_of([Segment(*DOES[does])]))
    return engine


def torques(engine: CompiledPath, ticks: int) -> np.ndarray:
    signals = engine.advance(ticks).signals()
    return np.column_stack([signals[f"{axis}.torque"] for axis in AXES])


@pytest.mark.parametrize("does", DOES)
#: those whose loops the host closes; a law of the arena brakes nothing
@pytest.mark.parametrize("controller", heavy_but(("thesis", "all"), [c for c in CONTROLLERS if c not in LAWS]))
def test_a_stop_begins_with_the_torque_that_acts(controller: str, does: str) -> None:
    engine = antenna(controller, does)
    before = torques(engine, 500)[-1]
    engine.host.stop()
    jump = np.abs(torques(engine, 1)[0] - before)
    assert engine.host.state is HostState.STOPPING
    for axis in range(2):
        C = engine.host.memory.C[layout.axis_c(axis) :]
        gain = control.OBSERVER_RATE_KP if C[control.OBSERVED] > 0.0 else control.RATE_KP
        first = C[control.TORQUE_SCALE] * C[gain] * C[layout.BRAKING_RAD_S2] * engine.settings.step_s
        assert jump[axis] < NOISE_NM + (0.0 if does == "rests" else first)


@pytest.mark.parametrize("controller", ["friction", "observer", "all"])
def test_from_holding_a_place_to_holding_a_rate_the_torque_goes_on(controller: str) -> None:
    engine = antenna(controller, "rests")
    before = torques(engine, 500)[-1]
    outer, inner = AxisCommand(Mode.RATE, Shape.HOLD, (0.0,)), AxisCommand(Mode.RATE, Shape.HOLD, (0.0,))
    engine.host.command(program_of([Segment(outer, inner)]))
    assert np.all(np.abs(torques(engine, 1)[0] - before) < NOISE_NM)
