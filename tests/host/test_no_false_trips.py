"""Guards are quiet while nothing is wrong: the shipped limits on healthy antennas of many kinds, in motions that come
near them.
"""

from __future__ import annotations

from typing import Any

import pytest

from gimbal_hil.loop.host import AxisCommand, HostState, Mode, ReferenceOrigin, Segment, Shape, program_of
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.lockstep import CompiledPath
from sim_backend.model import AntennaModel, shipped_model

SWAY = {
    "motion": "sinusoid",
    "amplitude_rad": {"roll": 0.15, "pitch": 0.1, "yaw": 0.2},
    "frequency_hz": {"roll": 0.5, "pitch": 0.8, "yaw": 0.3},
}
TURN = {"motion": "constant_rate", "rate_rad_s": {"p": 0.05, "q": -0.08, "r": 0.4}}


def _model(
    outer: dict[str, float] | None = None, inner: dict[str, float] | None = None, base: dict[str, Any] | None = None
) -> AntennaModel:
    model = shipped_model()
    for axis, numbers in (("outer", outer), ("inner", inner)):
        if numbers:
            model = model.with_numbers(axis, numbers)
    return model if base is None else model.with_base(base)


def _both(numbers: dict[str, float]) -> AntennaModel:
    return _model(numbers, numbers)


ANTENNAS = {
    "shipped": shipped_model,
    "sixteen-bit encoders": lambda: _both({"encoder.step": 9.587e-5}),
    "noisy gyros": lambda: _both({"gyro.noise": 2e-3}),
    "noisy encoders": lambda: _both({"encoder.noise": 2e-5}),
    "gyros without noise or steps": lambda: _both({"gyro.noise": 0.0, "gyro.step": 0.0}),
    "slow gyros": lambda: _both({"gyro.bandwidth": 1256.0}),
    "gyros with a bias": lambda: _model({"gyro.bias": 0.008}, {"gyro.bias": -0.008}),
    "gyros off by two per cent": lambda: _both({"gyro.scale_error": 0.02}),
    "half the inertia": lambda: _model({"body.inertia.zz": 0.25}),
    "a slow actuator": lambda: _both({"actuator.time_constant": 0.002}),
    "a swaying base": lambda: _model(base=SWAY),
    "a turning base": lambda: _model(base=TURN),
}


def _hold(
    mode: Mode,
    outer: float = 0.0,
    inner: float = 0.0,
    seconds: float = 1.0,
    origin: ReferenceOrigin = ReferenceOrigin.ABSOLUTE,
) -> Segment:
    commands = (AxisCommand(mode, Shape.HOLD, (value,), origin) for value in (outer, inner))
    return Segment(*commands, round(seconds * 1000))


def _ramp(mode: Mode, outer: tuple[float, float], inner: tuple[float, float], seconds: float) -> Segment:
    # value, slope, seconds
    return Segment(
        AxisCommand(mode, Shape.RAMP, (*outer, seconds)),
        AxisCommand(mode, Shape.RAMP, (*inner, seconds)),
        round(seconds * 1000),
    )


MOTIONS = {
    "steps": [_hold(Mode.POSITION, *target, 1.5) for target in ((0.5, 0.3), (-0.5, -0.3), (1.5, 0.8), (0.0, 0.0))],
    "slow sliding": [
        _hold(Mode.RATE, *rate, 3.0) for rate in ((0.005, 0.005), (-0.01, -0.01), (0.05, 0.05), (-0.1, -0.1))
    ],
    "fast to and fro": [_hold(Mode.RATE, *rate, 0.5) for rate in ((3.0, 1.2), (-3.0, -1.2), (3.0, 1.2), (-3.0, -1.2))],
    "holding": [_hold(Mode.POSITION, 0.0, 0.0, 8.0, ReferenceOrigin.START)],
    "torque below breaking away": [
        Segment(
            AxisCommand(Mode.TORQUE, Shape.SINE, (0.0, 0.2, 0.5, 0.0)),
            AxisCommand(Mode.POSITION, Shape.HOLD, (0.0,), ReferenceOrigin.START),
            6000,
        )
    ],
    "chirp": [
        Segment(
            AxisCommand(Mode.RATE, Shape.CHIRP, (0.0, 0.5, 0.5, 40.0, 5.0)),
            AxisCommand(Mode.RATE, Shape.CHIRP, (0.0, 0.5, 0.5, 40.0, 5.0)),
            5000,
        )
    ],
}


@pytest.mark.parametrize("antenna", ANTENNAS)
def test_nothing_trips_on_a_healthy_antenna_with(antenna: str) -> None:
    for motion, segments in MOTIONS.items():
        engine = CompiledPath(shipped_settings(), ANTENNAS[antenna](), seed=3)
        engine.connect()
        engine.advance(200)
        recorded = engine.run(program_of(segments))
        texts = [event.text for event in recorded.events]
        assert engine.host.state in (HostState.ACTIVE, HostState.IDLE), (antenna, motion, texts)
        assert sum("ended (duration)" in text for text in texts) == len(segments), (antenna, motion, texts)
