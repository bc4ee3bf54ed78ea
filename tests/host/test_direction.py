"""Mode pointing: joints that look in one direction in space while the base turns, by exact kinematics."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from firmware_protocol import schema
from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.host import (
    AxisCommand,
    HostState,
    LinkStatus,
    Mode,
    ReferenceOrigin,
    Segment,
    Shape,
    layout,
    program_of,
)
from gimbal_hil.loop.host.direction import direction_now, joints_of, nearest_turn
from gimbal_hil.pointing.arena import Trial, chosen, controller_settings, run_trial, shipped_scenarios
from gimbal_hil.realtime.lockstep import CompiledPath, FramePath
from sim_backend.model import AntennaModel, shipped_model

Vector = NDArray[np.float64]


def rotation(roll: float, pitch: float, yaw: float) -> NDArray[np.float64]:
    """R_eb = Rz(yaw) Ry(pitch) Rx(roll), written out by its factors."""
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(a), np.sin(a)) for a in (roll, pitch, yaw))
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(z @ y @ x)


def angles(t: float) -> Vector:
    """Roll, pitch and yaw of a base that swings."""
    return np.array([0.2 * np.sin(1.7 * t), 0.3 * np.cos(1.1 * t), 0.5 * t + 0.1 * np.sin(2.0 * t)])


def true_joints(t: float, azimuth: float, elevation: float) -> Vector:
    towards = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), -np.sin(elevation)]
    x, y, z = rotation(*angles(t)).T @ towards
    return np.array([np.arctan2(y, x), -np.arcsin(z)])


def body_rate(t: float) -> Vector:
    """From R^T R', by differences."""
    h = 1e-5
    skew = rotation(*angles(t)).T @ (rotation(*angles(t + h)) - rotation(*angles(t - h))) / (2.0 * h)
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])


def told(t: float, age_s: float) -> tuple[Vector, Vector]:
    """H and C of a host that was told the attitude of `age_s` ago and knows the rates of now."""
    H, C = np.zeros(layout.H_SIZE), np.zeros(layout.C_SIZE)
    C[layout.EXTRAPOLATES_BASE] = 1.0
    H[layout.BASE_ANGLES : layout.BASE_ANGLES + 3] = angles(t - age_s)
    H[layout.BASE_NOW : layout.BASE_NOW + 3] = body_rate(t)
    H[layout.BASE_TURNING : layout.BASE_TURNING + 3] = (body_rate(t + 1e-4) - body_rate(t - 1e-4)) / 2e-4
    H[layout.ATTITUDE_AGE_S] = age_s
    return H, C


@pytest.mark.parametrize("t", [0.0, 0.7, 2.3])
def test_position_rate_and_acceleration_are_those_of_the_true_kinematics(t: float) -> None:
    H, C = told(t, 0.0)
    found = np.array(joints_of(*direction_now(0.4, -0.6, 0.0, 0.0, H, C)))
    h = 1e-3
    before, now, after = (true_joints(t + shift, 0.4, -0.6) for shift in (-h, 0.0, h))
    np.testing.assert_allclose(found[:, 0], now, atol=1e-12)
    np.testing.assert_allclose(found[:, 1], (after - before) / (2.0 * h), atol=1e-5)
    np.testing.assert_allclose(found[:, 2], (after - 2.0 * now + before) / h**2, atol=2e-4)


def test_an_old_attitude_is_turned_on_to_now() -> None:
    H, C = told(1.0, 0.02)
    found = np.array(joints_of(*direction_now(0.4, -0.6, 0.0, 0.0, H, C)))
    # what is left is the third derivative over the age
    np.testing.assert_allclose(found[:, 0], true_joints(1.0, 0.4, -0.6), atol=5e-6)
    C[layout.EXTRAPOLATES_BASE] = 0.0
    held = np.array(joints_of(*direction_now(0.4, -0.6, 0.0, 0.0, H, C)))
    assert np.abs(held[:, 0] - true_joints(1.0, 0.4, -0.6)).max() > 1e-3


def test_a_direction_that_moves_takes_its_own_rates_along() -> None:
    H, C = told(0.7, 0.0)
    found = np.array(joints_of(*direction_now(0.4, -0.6, 0.02, -0.01, H, C)))
    h = 1e-4
    after, before = (true_joints(0.7 + s * h, 0.4 + 0.02 * s * h, -0.6 - 0.01 * s * h) for s in (1.0, -1.0))
    np.testing.assert_allclose(found[:, 1], (after - before) / (2.0 * h), atol=1e-5)


def test_the_azimuth_goes_on_over_a_whole_turn_as_far_as_the_cable_allows() -> None:
    assert nearest_turn(-3.1, 3.1, -12.0, 12.0) == pytest.approx(-3.1 + 2.0 * np.pi)
    assert nearest_turn(-3.1, 3.1, -3.15, 3.15) == pytest.approx(-3.1)
    assert nearest_turn(0.1, 12.5, -12.6, 12.6) == pytest.approx(0.1 + 4.0 * np.pi - 2.0 * np.pi)


def command(mode: Mode, value: float, **more: object) -> AxisCommand:
    return AxisCommand(mode, Shape.HOLD, (value,), **more)  # type: ignore[arg-type]


def test_a_direction_takes_both_axes_and_has_no_start() -> None:
    with pytest.raises(BadInputError, match="mode pointing on one axis"):
        program_of([Segment(command(Mode.POINTING, 0.1), command(Mode.POSITION, 0.1))])
    start = command(Mode.POINTING, 0.1, origin=ReferenceOrigin.START)
    with pytest.raises(BadInputError, match="mode pointing with a start"):
        program_of([Segment(start, command(Mode.POINTING, 0.1))])


def swinging() -> AntennaModel:
    swing = {"roll": 0.05, "pitch": 0.04, "yaw": 0.06}
    base = {"motion": "sinusoid", "amplitude_rad": swing, "frequency_hz": {"roll": 0.7, "pitch": 0.4, "yaw": 1.0}}
    return shipped_model("realistic").with_base({**base, "ins_age_s": 0.005})


@pytest.mark.parametrize("controller", ["shipped", "all"])
def test_both_paths_leave_the_same_bits_and_afterwards_the_joints_are_held(controller: str) -> None:
    program = program_of(
        [Segment(command(Mode.POINTING, 0.4), command(Mode.POINTING, -0.5), 1500, label=0)],
    )
    logs = []
    for path in (CompiledPath, FramePath):
        engine = path(controller_settings(controller), swinging(), 3)
        engine.connect()
        first = engine.run(program)
        rest = engine.advance(200)
        assert engine.host.state is HostState.ACTIVE
        held = rest.signals()["outer.position_ref"]
        assert np.ptp(held) == 0.0 and held[0] == first.signals()["outer.position_ref"][-1]
        logs.append(np.concatenate([first.log, rest.log]))
    np.testing.assert_array_equal(logs[0], logs[1])


def followed(lost: str) -> Vector:
    """What both joints are asked for (rad) on a base that swings, when one frame of its navigation's set is lost."""
    engine = FramePath(controller_settings("all"), swinging(), 3)
    engine.connect()
    host, device, answer = engine.host, engine.device, b""
    host.command(program_of([Segment(command(Mode.POINTING, 0.4), command(Mode.POINTING, -0.5))]))
    asked = []
    for tick in range(engine.tick, engine.tick + 600):
        frames = [answer[at : at + 10] for at in range(0, len(answer), 10)]
        carried = {int.from_bytes(frame[:2], "little") for frame in frames}
        if lost and len(asked) > 500 and {MESSAGES[lost], MESSAGES[SET_OF[lost]]} <= carried:
            frames = [frame for frame in frames if int.from_bytes(frame[:2], "little") != MESSAGES[lost]]
            lost = ""
        answer = device.tick(host.tick(tick, tick * engine.step_ns, b"".join(frames)))
        references = [host.memory.H[layout.axis_h(axis) + layout.REFERENCE] for axis in range(2)]
        # without a full set nothing is asked for anew
        asked.append(references if host.link_status is LinkStatus.OK else [np.nan, np.nan])
    assert not lost and host.state is HostState.ACTIVE
    return np.array(asked)


MESSAGES = {message.name: message.can_id for message in schema.MESSAGES}
#: with which frame one is lost: the status tells what the time is
SET_OF = {"base_attitude": "base_attitude", "base_heading": "base_heading", "drive_status": "base_heading"}


@pytest.mark.parametrize("lost", SET_OF)
def test_a_lost_frame_makes_the_attitude_older_and_not_wrong(lost: str) -> None:
    error = np.abs(followed(lost) - followed(""))
    assert np.count_nonzero(np.isnan(error)) <= 4
    assert np.nanmax(error) < 60e-6


def test_a_direction_near_the_zenith_is_followed_as_far_as_joints_can_and_nothing_trips() -> None:
    engine = CompiledPath(controller_settings("all"), swinging(), 3)
    engine.connect()
    zenith = Segment(command(Mode.POINTING, 0.4), command(Mode.POINTING, -1.5658), 6000)
    signals = engine.run(program_of([zenith])).signals()
    assert engine.host.state is HostState.ACTIVE
    assert all(np.all(np.isfinite(signals[name])) for name in ("outer.position", "inner.position", "outer.torque"))


@pytest.mark.parametrize(("words", "most_rad"), [("moderate", 35e-6), ("severe", 60e-6), ("turn", 10e-6)])
def test_all_parts_hold_a_direction_in_the_air_and_ten_times_better_than_shipped(words: str, most_rad: float) -> None:
    scenario = next(one for one in chosen(shipped_scenarios(), "a direction held in") if words in one.name)
    found = {
        name: run_trial(
            Trial(scenario, name, controller_settings(name), "realistic", shipped_model("realistic"), seed=1)
        ).los_rms
        for name in ("shipped", "all")
    }
    assert found["all"] < most_rad
    assert found["all"] < 0.12 * found["shipped"]
