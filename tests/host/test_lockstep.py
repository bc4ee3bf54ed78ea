"""Frame path, compiled path and plain Python: the same bits for any program."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from enum import Enum
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.links import Cut, DirectionFaults, FaultsConfig
from firmware_protocol.schema import RECORD_SIZE
from gimbal_hil.data.runs.schema import FrameDirection, frames_of_blocks
from gimbal_hil.loop.host import AxisCommand, HostState, Mode, ReferenceOrigin, Segment, Shape, program_of
from gimbal_hil.loop.settings import DaemonSettings, shipped_settings
from gimbal_hil.pointing.arena import controller_settings
from gimbal_hil.realtime.lockstep import CompiledPath, FramePath
from sim_backend.device import Device
from sim_backend.model import AntennaModel, shipped_model
from tests.host.bits_of_a_run import digest_of_run, digest_over_frames
from tests.host.random_models import random_model, random_segments
from tests.host.wide_settings import wide_settings

SETTINGS, WIDE, MODEL = shipped_settings(), wide_settings(), shipped_model()
KNOWING = controller_settings("all")
SWINGING = MODEL.with_base(
    {
        "motion": "sinusoid",
        "amplitude_rad": {"roll": 0.05, "pitch": 0.04, "yaw": 0.06},
        "frequency_hz": {"roll": 0.7, "pitch": 0.4, "yaw": 1.0},
        "ins_age_s": 0.005,
    }
)
SMALL = st.floats(-0.5, 0.5)
TIMES = st.floats(0.02, 0.3)
POSITIVE = st.floats(0.1, 5.0)
SHAPES = st.one_of(
    st.tuples(st.just(Shape.HOLD), st.tuples(SMALL)),
    st.tuples(st.just(Shape.RAMP), st.tuples(SMALL, SMALL, POSITIVE)),
    st.tuples(st.just(Shape.SINE), st.tuples(SMALL, SMALL, POSITIVE, SMALL)),
    st.tuples(st.just(Shape.CHIRP), st.tuples(SMALL, SMALL, POSITIVE, SMALL, TIMES)),
    st.tuples(st.just(Shape.TRAPEZOID), st.tuples(SMALL, POSITIVE, POSITIVE)),
    st.tuples(st.just(Shape.SMOOTH), st.tuples(SMALL, TIMES)),
    st.tuples(st.just(Shape.PULSES), st.tuples(SMALL, SMALL, TIMES, TIMES, st.sampled_from([0.0, 1.0]), st.just(9.0))),
)
AXES = st.builds(
    lambda mode, shape, origin: AxisCommand(mode, shape[0], shape[1], origin),
    st.sampled_from([mode for mode in Mode if mode is not Mode.POINTING]),
    SHAPES,
    st.sampled_from(list(ReferenceOrigin)),
)
#: directions in space, some of them near the zenith; both axes have the mode, and no shape has a start
DIRECTIONS = st.builds(
    lambda shape, scale: AxisCommand(Mode.POINTING, shape[0], (scale * shape[1][0], *shape[1][1:])),
    st.one_of(
        st.tuples(st.just(Shape.HOLD), st.tuples(SMALL)),
        st.tuples(st.just(Shape.RAMP), st.tuples(SMALL, SMALL, POSITIVE)),
        st.tuples(st.just(Shape.SINE), st.tuples(SMALL, SMALL, POSITIVE, SMALL)),
    ),
    st.sampled_from([1.0, 3.1]),
)
TIMETABLES = st.builds(
    lambda rows, first: AxisCommand(Mode.POINTING, Shape.TIMETABLE, (0.05, 1.0, first), table=tuple(rows)),
    st.lists(st.floats(-1.6, 1.6), min_size=1, max_size=12),
    st.sampled_from([-1.0, -301.0, 200.0]),
)
POINTING = st.one_of(st.tuples(DIRECTIONS, DIRECTIONS), st.tuples(TIMETABLES, TIMETABLES))
PAIRS = st.one_of(st.tuples(AXES, AXES), POINTING)
SEGMENTS = st.builds(lambda pair, ticks: Segment(pair[0], pair[1], ticks), PAIRS, st.integers(1, 400))
#: the shipped loops, and those that take all that the model knows
CONTROLLERS = st.sampled_from([SETTINGS, KNOWING])


@settings(max_examples=20)
@given(st.lists(SEGMENTS, min_size=1, max_size=5), st.integers(0, 2**31 - 1), st.sampled_from([1, 7]), CONTROLLERS)
def test_both_paths_leave_the_same_log_for_any_program(
    segments: list[Segment], seed: int, every: int, configured: DaemonSettings
) -> None:
    numbered = [
        Segment(s.outer, s.inner, s.duration_ticks, label=k, record_every=3 * (k % 2)) for k, s in enumerate(segments)
    ]
    program = program_of(numbered)
    frame, compiled = FramePath(configured, SWINGING, seed), CompiledPath(configured, SWINGING, seed)
    first, second = frame.connect(), compiled.connect()
    assert first.log.tobytes() == second.log.tobytes()
    one, other = frame.run(program, every=every), compiled.run(program, every=every)
    assert one.ticks == other.ticks
    assert one.log.tobytes() == other.log.tobytes()
    assert one.events == other.events
    assert frame.host.memory.floats.tobytes() == compiled.host.memory.floats.tobytes()
    assert frame.device.X.tobytes() == compiled.device.X.tobytes()


class Way(Enum):
    """How host and antenna are bound."""

    TICK_BY_TICK = "frames, with somebody told of every tick"
    FRAMES = "frames, in one compiled loop"
    MAIL = "without frames but for the log"


def digest_of_any_run(model: AntennaModel, seed: int, longest: int, way: Way) -> tuple[str, int]:
    """Digest of rows, events, frames and final state of an antenna following a random plan, and how many ticks it
    ran.
    """
    program, every = program_of(random_segments(seed, longest)), 1 + 6 * (seed % 2)
    ticks: list[int] = []
    directions: list[int] = []
    blocks: list[bytes] = []

    def exchange(tick: int, received: bytes, sent: bytes) -> None:
        ticks.extend((tick, tick))
        directions.extend((FrameDirection.DEVICE_TO_HOST, FrameDirection.HOST_TO_DEVICE))
        blocks.extend((received, sent))

    # with the shipped limits most programs end early on a random antenna, and what comes after a trip is compared too
    configured = SETTINGS if seed % 4 == 0 else KNOWING if seed % 4 == 1 and len(model.axes) == 2 else WIDE
    path: FramePath | CompiledPath
    if way is Way.MAIL:
        path = CompiledPath(configured, model, seed, keep_frames=True)
    elif way is Way.FRAMES:
        path = FramePath(configured, model, seed, keep_frames=True)
    else:
        path = FramePath(configured, model, seed, exchange=exchange)
    # an antenna may be one that never connects, for instance moving too fast from the start
    connected = path.advance(60)
    path.host.command(program)
    ran = path.advance(6 * longest, until_done=True, every=every)
    frames = (
        frames_of_blocks(np.array(ticks), np.array(directions), blocks)
        if way is Way.TICK_BY_TICK
        else np.concatenate([connected.frames, ran.frames])
    )
    digest = hashlib.sha256(
        connected.log.tobytes() + ran.log.tobytes() + repr(connected.events + ran.events).encode() + frames.tobytes()
    )
    for array in (path.host.memory.floats, path.host.memory.G, path.device.X, path.device.drive_words):
        digest.update(array.tobytes())
    return digest.hexdigest(), connected.ticks + ran.ticks


def same_bits(seeds: range, longest: int) -> int:
    """Whether all ways agree on all seeds; answers the ticks compared."""
    compared = 0
    for seed in seeds:
        model = random_model(seed)
        first, *others = (digest_of_any_run(model, seed, longest, way) for way in Way)
        assert others == [first, first], f"seed {seed}"
        compared += first[1]
    return compared


def test_all_ways_leave_the_same_bits_for_any_antenna_plan_and_seed() -> None:
    # one and two axes, any base, sensors, stops, heat, slips, 238 effects; 54,679 ticks
    assert same_bits(range(150), 300) > 40_000


@pytest.mark.heavy
def test_all_ways_leave_the_same_bits_for_thousands_of_antennas() -> None:
    assert same_bits(range(1000, 4000), 1500) > 3_000_000


class OtherFirmware(Device):
    """An antenna whose frames are answered by something else."""

    def tick(self, received: bytes = b"") -> bytes:
        self.asked = getattr(self, "asked", 0) + 1
        return super().tick(received)


def test_a_device_with_a_tick_of_its_own_is_asked_at_every_tick() -> None:
    device = OtherFirmware(MODEL, rate_hz=SETTINGS.rate_hz, seed=3)
    path = FramePath(SETTINGS, MODEL, 3, device=device)
    path.advance(50)
    assert device.asked == 50


def test_the_compiled_path_encodes_the_frames_that_the_frame_path_sends() -> None:
    ticks, directions, blocks = [], [], []

    def exchange(tick: int, received: bytes, sent: bytes) -> None:
        ticks.extend((tick, tick))
        directions.extend((FrameDirection.DEVICE_TO_HOST, FrameDirection.HOST_TO_DEVICE))
        blocks.extend((received, sent))

    program = program_of([Segment(AxisCommand(Mode.POSITION, Shape.HOLD, (0.2,)), AxisCommand(Mode.RATE), 300)])
    frame = FramePath(SETTINGS, MODEL, 3, exchange=exchange)
    frame.connect()
    frame.run(program)
    compiled = CompiledPath(SETTINGS, MODEL, 3, keep_frames=True)
    kept = np.concatenate([compiled.connect().frames, compiled.run(program).frames])
    expected = frames_of_blocks(np.array(ticks), np.array(directions), blocks)
    assert len(expected) == sum(map(len, blocks)) // RECORD_SIZE
    assert kept.tobytes() == expected.tobytes()


def test_plain_python_gives_the_same_bits_as_compiled_code() -> None:
    root = Path(__file__).resolve().parents[2]
    environment = dict(os.environ, NUMBA_DISABLE_JIT="1", PYTHONPATH=str(root))
    plain = subprocess.run(
        [sys.executable, "-W", "ignore", "-m", "tests.host.bits_of_a_run"],
        env=environment,
        cwd=root,
        capture_output=True,
        text=True,
        check=True,
    )
    assert plain.stdout.split() == [digest_of_run(), digest_over_frames()]


@pytest.mark.parametrize("rate", [0.01, 0.05])
def test_a_link_with_faults_never_brings_torque_without_feedback(rate: float) -> None:
    faults = DirectionFaults(
        drop=rate, duplicate=rate, reorder=rate, corrupt=rate, truncate=rate / 2, delay=rate, delay_ticks=2
    )
    frame = FramePath(SETTINGS, MODEL, 1, FaultsConfig(seed=4, send=faults, receive=faults))
    frame.advance(3000)
    for _ in range(10):
        if frame.host.state is HostState.IDLE:
            frame.host.command(
                program_of([Segment(AxisCommand(Mode.POSITION, Shape.HOLD, (0.3,)), AxisCommand(Mode.POSITION))])
            )
        rows = frame.advance(500).rows
        off = (rows["host_state"] != HostState.ACTIVE) & (rows["host_state"] != HostState.STOPPING)
        assert not np.any(rows["torque_outer"][off]) and not np.any(rows["torque_inner"][off])


def test_a_cut_line_ends_in_fault_and_comes_back_idle() -> None:
    cuts = FaultsConfig(cuts=(Cut(start_tick=600, ticks=300),))
    frame = FramePath(SETTINGS, MODEL, 1, cuts)
    frame.connect()
    frame.host.command(program_of([Segment(AxisCommand(Mode.RATE, Shape.HOLD, (0.5,)), AxisCommand(Mode.POSITION))]))
    frame.advance(700)
    assert frame.host.state is HostState.FAULT
    frame.advance(8000)
    assert frame.host.state is HostState.IDLE
    assert abs(frame.device.joint_rates[0]) < 0.05
