"""The C device and the Python one leave the same frames for the same input."""

from __future__ import annotations

import dataclasses
import random
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.codec import record
from firmware_protocol.enumerations import DriveState, FaultCode, StopReaction
from firmware_protocol.schema import MESSAGES
from sim_backend.device import Device, FirmwareSettings, TravelReaction
from sim_backend.firmware import BenchLibrary, LibraryAntenna
from sim_backend.model import model_from_document, shipped_model
from tests.device.bench import bench_model
from tests.firmware.sessions import ACTIONS, Action, Pair, random_actions, run_both

SETTINGS = st.fixed_dictionaries(
    {
        "deadman_window_ticks": st.integers(1, 255),
        "deadman_reaction": st.sampled_from(StopReaction),
        "fault_reaction": st.sampled_from(StopReaction),
        "travel_reaction": st.sampled_from(TravelReaction),
        "startup_ticks": st.integers(1, 20),
        "control_silence_ticks": st.sampled_from([0, 5, 60, 1000]),
        "disagreement_rad_s": st.floats(0.1, 50.0),
        "stop_disagreement_rad_s": st.floats(0.1, 50.0),
        "rest_s": st.floats(0.0, 0.1),
        "hold_s": st.floats(0.0, 0.2),
        "reaction_timeout_s": st.floats(0.0, 0.3),
        "stop_bandwidth_rad_s": st.floats(1.0, 100.0),
        "brake_closing_s": st.floats(0.0, 0.05),
    }
)
AXES = st.fixed_dictionaries(
    {
        "travel_low_rad": st.sampled_from([-np.inf, -3.0, -0.5]),
        "travel_high_rad": st.sampled_from([np.inf, 3.0, 0.5]),
        "rate_limit_rad_s": st.floats(0.5, 15.0),
        "overspeed_rad_s": st.floats(1.0, 20.0),
        "deceleration_rad_s2": st.floats(0.1, 100.0),
        "strange_torque_nm": st.sampled_from([0.0, 0.5, 3.0]),
        "holding_torque_nm": st.sampled_from([0.0, 5.0]),
        "torque_exponent": st.integers(0, 3),
    }
)


def firmware_settings(drive: dict[str, Any], axes: tuple[dict[str, Any], ...]) -> FirmwareSettings:
    usual = FirmwareSettings.for_model(bench_model())
    own = tuple(dataclasses.replace(axis, **given) for axis, given in zip(usual.axes, axes, strict=True))
    return dataclasses.replace(usual, axes=own, **drive)


@settings(max_examples=60)
@given(actions=ACTIONS)
def test_any_session_leaves_the_same_frames(library: BenchLibrary, actions: list[Action]) -> None:
    run_both(Device, partial(LibraryAntenna, library), bench_model(), actions)


@settings(max_examples=60)
@given(drive=SETTINGS, axes=st.tuples(AXES, AXES), rate_hz=st.sampled_from([200.0, 1000.0, 2000.0]), actions=ACTIONS)
def test_with_any_settings_too(
    library: BenchLibrary,
    drive: dict[str, Any],
    axes: tuple[dict[str, Any], ...],
    rate_hz: float,
    actions: list[Action],
) -> None:
    run_both(Device, partial(LibraryAntenna, library), bench_model(), actions, firmware_settings(drive, axes), rate_hz)


def test_a_long_session_passes_through_every_state_and_most_faults(library: BenchLibrary) -> None:
    states: set[int] = set()
    faults: set[int] = set()
    for seed in range(6):
        pair = run_both(Device, partial(LibraryAntenna, library), bench_model(), random_actions(seed, 250))
        states |= pair.states
        faults |= pair.faults
    assert states == set(map(int, DriveState))
    assert len(faults - {int(FaultCode.NONE)}) >= 7


@pytest.mark.heavy
def test_sessions_of_a_hundred_thousand_actions(library: BenchLibrary) -> None:
    frames = 0
    for seed in range(100, 500):
        frames += run_both(Device, partial(LibraryAntenna, library), bench_model(), random_actions(seed, 250)).frames
    assert frames > 3_000_000


def random_frames(library: BenchLibrary, ticks: int, frames: int, seed: int) -> Pair:
    """Blocks of random frames: any payload, and such whose CRC is right."""
    pair = Pair(Device(bench_model(), seed=1), LibraryAntenna(library, bench_model(), seed=1))
    dice = random.Random(seed)
    known = [message.can_id for message in MESSAGES]
    for _ in range(ticks):
        for _ in range(frames // 8):
            name = dice.choice(("drive_control", "set_point", "set_point", "deadman_config"))
            flags = [dice.randrange(2) for _ in range(3)]
            torques = [dice.randrange(-131072, 131072) for _ in range(2)]
            raw = {
                "drive_control": [dice.randrange(7), *flags, dice.randrange(4), 0, 0, 0],
                "set_point": [*torques, 1, 1, 1],
                "deadman_config": [dice.randrange(1, 256), dice.randrange(4)],
            }[name]
            pair.act((name, tuple(raw)))
        words = dice.randbytes(8 * (frames - frames // 8))
        pair._waiting += b"".join(record(dice.choice(known), words[at : at + 8]) for at in range(0, len(words), 8))
        pair.tick()
    return pair


def test_random_frames_are_taken_and_dropped_alike(library: BenchLibrary) -> None:
    pair = random_frames(library, 300, 80, 3)
    assert (pair.both[0].bad_frames, pair.both[0].repeated_frames) == (
        pair.both[1].bad_frames,
        pair.both[1].repeated_frames,
    )
    assert pair.both[0].bad_frames > 15_000 and pair.both[0].set_points[0] > 200


@pytest.mark.heavy
def test_two_million_random_frames_are_taken_and_dropped_alike(library: BenchLibrary) -> None:
    for seed in range(20):
        pair = random_frames(library, 1000, 100, seed)
        assert pair.both[0].bad_frames == pair.both[1].bad_frames


def test_a_single_axis_is_the_same_too(library: BenchLibrary) -> None:
    document = {
        "schema": 1,
        "name": "flywheel",
        "kind": "rotary",
        "axes": {"wheel": {"body": {"inertia": {"zz": 0.1}}, "actuator": {"limit": 40.0}}},
    }
    model = model_from_document(document, "test")
    pair = run_both(Device, partial(LibraryAntenna, library), model, random_actions(2, 120))
    assert int(DriveState.OPERATION_ENABLED) in pair.states


def test_on_a_moving_base_with_effects_it_is_the_same_too(library: BenchLibrary) -> None:
    model = shipped_model().with_base(
        {
            "motion": "sinusoid",
            "amplitude_rad": {"roll": 0.1, "pitch": 0.2, "yaw": 3.0},
            "frequency_hz": {"roll": 1.0, "pitch": 0.7, "yaw": 0.5},
        }
    )
    model = model.with_effect("cogging", "outer", {"amplitude": 0.05, "order": 12.0, "phase": 0.3})
    run_both(Device, partial(LibraryAntenna, library), model, random_actions(4, 200))
