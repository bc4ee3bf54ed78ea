"""Sensors that lie slowly, stand still or contradict the torque: each guard trips for its cause, and the stop uses no
suspect.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from firmware_protocol import mail as m
from firmware_protocol.enumerations import LimitFlags, StopReaction
from gimbal_hil.loop.host import Host, HostCause, HostState, Mode, layout
from gimbal_hil.loop.host.reactions import BY_ENCODER, stop_for
from tests.host.host_loop import HostLoop, configuration, hold

#: shipped limits without the guards that would see the fault before the one that is meant
DRIFT_ONLY = {"outer__expectation": None, "inner__expectation": None, "outer__limits__stuck_gyro_ticks": None}


def _noise(loop: HostLoop) -> None:
    """A gyro with noise on both axes, the same every time."""
    before, dice = loop.antenna._move, np.random.default_rng(5)

    def move() -> None:
        before()
        loop.antenna.gyro_error[:] = 1e-4 * dice.standard_normal(2)

    loop.antenna._move = move  # type: ignore[method-assign]


def _tripped(loop: HostLoop, cause: HostCause) -> None:
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, cause), loop.texts()
    assert loop.sent[-1].torque == (0, 0) and loop.sent[-1].enable == (0, 0)
    assert int(loop._mail[m.DRIVE_CONTROL_STOP]) == stop_for(cause) and loop.antenna.requests[-1][2] == 1


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("rate", [0.05, -0.3])
def test_an_encoder_that_stands_still_on_a_slow_axis_is_noticed(axis: int, rate: float) -> None:
    loop = (
        HostLoop(Host(configuration(**DRIFT_ONLY)))
        .connected()
        .command(hold(Mode.RATE, *((rate, 0.0) if axis == 0 else (0.0, rate))))
        .run(200)
    )
    frozen, seen = loop.antenna.position[axis], loop.antenna._fill
    loop.antenna._fill = lambda mail: seen(mail, {axis: frozen})  # type: ignore[method-assign]
    loop.run(round(0.04 / abs(rate) * 1000) + 100)
    _tripped(loop, HostCause.SENSOR_DRIFT)


@pytest.mark.parametrize("axis", [0, 1])
def test_an_encoder_that_walks_away_while_the_axis_is_held_is_noticed(axis: int) -> None:
    loop = HostLoop(Host(configuration(**DRIFT_ONLY))).connected().command(hold(Mode.RATE)).run(100)
    seen, start = loop.antenna._fill, loop.number
    loop.antenna._fill = lambda mail: seen(mail, {axis: 0.03e-3 * (loop.number - start)})  # type: ignore[method-assign]
    loop.run(2500)
    _tripped(loop, HostCause.SENSOR_DRIFT)


def test_a_small_bias_of_a_gyro_is_no_drift() -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE)).run(50)
    loop.antenna.gyro_error = [0.008, -0.008]
    loop.run(4000)
    assert loop.host.state is HostState.ACTIVE, loop.texts()


def test_a_gyro_with_noise_that_repeats_itself_is_stuck() -> None:
    loop = HostLoop()
    _noise(loop)
    loop.connected().run(50).command(hold(Mode.RATE, 0.2, 0.2)).run(300)
    seen = loop.antenna._fill
    stuck = int(loop.antenna._mail[m.FEEDBACK_INNER_RATE])
    loop.antenna._fill = lambda mail: (seen(mail), mail.__setitem__(m.FEEDBACK_INNER_RATE, stuck))[0]  # type: ignore[method-assign]
    loop.run(70)
    _tripped(loop, HostCause.GYRO_STUCK)


def test_a_gyro_without_noise_may_repeat_itself() -> None:
    loop = HostLoop().connected().run(50).command(hold(Mode.RATE)).run(1000)
    assert loop.host.state is HostState.ACTIVE, loop.texts()


def test_a_quiet_gyro_of_an_axis_that_swings_on_its_bristles_may_repeat_itself() -> None:
    loop = HostLoop().connected()
    for k in range(300):
        loop.antenna.gyro_error = [5e-4 * math.sin(0.05 * k)] * 2
        loop.run(1)
    assert all(loop.host.memory.H[layout.axis_h(axis) + layout.GYRO_STEP] > 0.0 for axis in range(2))
    loop.antenna.gyro_error = [0.0, 0.0]
    loop.command(hold(Mode.RATE, 0.2, 0.2)).run(1000)
    assert loop.host.state is HostState.ACTIVE, loop.texts()


def test_feedback_that_stands_still_at_rest_is_noticed() -> None:
    loop = HostLoop()
    _noise(loop)
    loop.connected().run(50).command(hold(Mode.POSITION)).run(100)
    held = [
        int(loop._mail[slot])
        for slot in (m.FEEDBACK_OUTER_POSITION, m.FEEDBACK_OUTER_RATE, m.FEEDBACK_INNER_POSITION, m.FEEDBACK_INNER_RATE)
    ]
    slots = (m.FEEDBACK_OUTER_POSITION, m.FEEDBACK_OUTER_RATE, m.FEEDBACK_INNER_POSITION, m.FEEDBACK_INNER_RATE)

    def fill(mail: object, positions: object = None) -> None:
        for slot, raw in zip(slots, held, strict=True):
            mail[slot] = raw  # type: ignore[index]

    loop.antenna._fill = fill  # type: ignore[method-assign]
    loop.run(70)
    _tripped(loop, HostCause.FEEDBACK_FROZEN)


def test_an_answer_whose_tick_stands_still_is_noticed_within_a_few_ticks() -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE)).run(50)
    loop.antenna.tick_stands_still = True
    loop.run(8)
    _tripped(loop, HostCause.FEEDBACK_FROZEN)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_motor_that_turns_the_wrong_way_is_caught_before_it_is_fast(axis: int) -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE, 0.2, 0.2)).run(200)
    loop.antenna.motor_sign[axis] = -1.0
    began = loop.number
    loop.run(120)
    _tripped(loop, HostCause.RUNAWAY)
    tripped = next(event.tick for event in loop.events if "to fault" in event.text)
    assert tripped - began <= 50 and abs(loop.antenna.rate[axis] - 0.2) < 1.0


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_motor_turned_round_while_the_axis_is_held_is_caught_before_it_is_fast(axis: int, side: float) -> None:
    loop, h = HostLoop(), layout.axis_h(axis)
    _noise(loop)
    loop.connected().command(hold(Mode.POSITION)).run(300)
    # no axis is quite at rest
    loop.antenna.motor_sign[axis], loop.antenna.rate[axis] = -1.0, side * 5e-4
    began, gained = loop.number, 0.0
    while loop.host.state is HostState.ACTIVE and loop.number < began + 100:
        loop.run(1)
        gained = abs(loop.host.memory.H[h + layout.MOMENTUM])
    loop.run(3)
    _tripped(loop, HostCause.RUNAWAY)
    assert loop.number - 3 - began <= 50 and abs(loop.antenna.rate[axis]) < 0.2
    # less might be noise
    assert gained > 0.25 * loop.host.memory.C[layout.axis_c(axis) + layout.DISTURBANCE]


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("ticks", [1, 10, 40, 150])
def test_a_held_axis_may_be_pushed_by_as_much_as_is_allowed_and_as_suddenly(axis: int, side: float, ticks: int) -> None:
    most = side * (1.5, 1.0)[axis]
    loop = HostLoop()
    _noise(loop)
    loop.connected().command(hold(Mode.POSITION)).run(300)
    for _ in range(2):
        for k in range(ticks):
            loop.antenna.load[axis] = most * (k + 1) / ticks
            loop.run(1)
        loop.run(60)
        loop.antenna.load[axis] = 0.0
        loop.run(400)
    assert loop.host.state is HostState.ACTIVE, loop.texts()


@pytest.mark.parametrize("axis", [0, 1])
def test_a_sudden_torque_that_acts_a_little_late_is_no_motor_turned_round(axis: int) -> None:
    loop = HostLoop()
    _noise(loop)
    loop.connected().run(50)
    obey, waiting = loop.antenna._obey, [0.0, 0.0]

    def late() -> None:
        obey()
        waiting.append(loop.antenna.torque[axis])
        loop.antenna.torque[axis] = waiting.pop(0)

    loop.antenna._obey = late  # type: ignore[method-assign]
    most = (14.0, 6.0)[axis]
    for torque in (most, -most, most, -most, 0.0):
        loop.command(hold(Mode.TORQUE, *((torque, 0.0) if axis == 0 else (0.0, torque)))).run(20)
        assert loop.host.state is HostState.ACTIVE, (torque, loop.texts())


def test_the_weight_of_a_body_on_a_tilted_base_is_expected_and_its_absence_is_not() -> None:
    for weighs in (True, False):
        loop = HostLoop(Host(configuration(outer__expectation__moment_kg_m=[0.9, 0.0, 0.0]))).connected()
        loop.antenna.base_roll = 0.5
        # about z: -(moment along x) times gravity along y of the base, while the outer joint is near zero
        loop.antenna.load[0] = -0.9 * 9.81 * math.sin(0.5) if weighs else 0.0
        loop.run(20).command(hold(Mode.POSITION)).run(300)
        assert (loop.host.state is HostState.ACTIVE) == weighs, loop.texts()
        assert loop.host.cause is (HostCause.NONE if weighs else HostCause.RUNAWAY)


def test_an_acceleration_of_the_pivot_counts_as_weight() -> None:
    loop = HostLoop(Host(configuration(outer__expectation__moment_kg_m=[0.9, 0.0, 0.0]))).connected()
    # m/s^2 to the left: the body stays behind
    loop.antenna.base_acceleration[1] = 6.0
    loop.antenna.load[0] = -0.9 * 6.0
    loop.run(20).command(hold(Mode.POSITION)).run(300)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    loop.antenna.base_acceleration[1] = -6.0
    loop.run(120)
    _tripped(loop, HostCause.RUNAWAY)


def test_motion_without_torque_is_noticed() -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE)).run(50)
    loop.antenna.load[0] = 12.0
    loop.run(60)
    _tripped(loop, HostCause.RUNAWAY)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_torque_that_the_drive_says_it_cuts_is_not_expected_to_move_the_axis(axis: int, side: float) -> None:
    high, low = LimitFlags.OUTER_TRAVEL_HIGH << (2 * axis), LimitFlags.OUTER_TRAVEL_LOW << (2 * axis)
    cut, other = (high, low) if side > 0.0 else (low, high)
    for flags, cause in ((cut, HostCause.NONE), (other, HostCause.RUNAWAY), (0, HostCause.RUNAWAY)):
        loop = HostLoop().connected()
        loop.antenna.limits, loop.antenna.motor_sign[axis] = int(flags), 0.0
        loop.command(hold(Mode.TORQUE, *((side * 5.0, 0.0) if axis == 0 else (0.0, side * 3.0)))).run(100)
        assert loop.host.cause is cause, (flags, loop.texts())


def test_torque_without_motion_is_noticed() -> None:
    loop = HostLoop().connected().command(hold(Mode.TORQUE, 14.0, 0.0)).run(3)
    loop.antenna.motor_sign[0] = 0.0
    loop.run(60)
    _tripped(loop, HostCause.RUNAWAY)


def test_an_axis_that_goes_past_a_soft_limit_without_torque_is_told_once() -> None:
    for side in (1.0, -1.0):
        loop = HostLoop().connected()
        loop.antenna.rate[1] = side * 3.0
        loop.run(1500)
        word = "upper" if side > 0 else "lower"
        assert loop.texts().count(f"inner moved past its {word} soft limit without torque") == 1


def test_a_cause_that_leaves_a_sensor_in_doubt_is_stopped_without_sensors() -> None:
    for cause in (
        HostCause.GYRO_ENCODER_DISAGREE,
        HostCause.SENSOR_DRIFT,
        HostCause.FEEDBACK_FROZEN,
        HostCause.RUNAWAY,
        HostCause.OVERSPEED,
        HostCause.FOLLOWING_ERROR,
    ):
        assert stop_for(cause) is StopReaction.BRAKE
    assert {stop_for(cause) for cause in BY_ENCODER} == {StopReaction.DECELERATE_AND_HOLD}
