"""What an axis is held to counts in either direction, for the axis and the mode that it is meant for, and for no
other.
"""

from __future__ import annotations

import math

import pytest

from gimbal_hil.loop.control.layout import LOOP_ERROR
from gimbal_hil.loop.host import AxisCommand, Host, HostCause, HostState, Mode, Segment, layout
from tests.host.host_loop import HostLoop, configuration, hold

SIDES = pytest.mark.parametrize("side", [1.0, -1.0])


def unmodelled(**changes: object) -> Host:
    """A host that does not hold motion against torque: what moves the axis here is nobody's torque."""
    return Host(configuration(outer__expectation=None, inner__expectation=None, **changes))


@SIDES
def test_an_axis_that_its_gyro_sees_moving_is_stopped_although_its_encoder_lags(side: float) -> None:
    loop = HostLoop(unmodelled())
    loop.antenna.position[1] = side * 1.999
    loop.connected().command(hold(Mode.TORQUE)).run(20)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    loop.antenna.gyro_error[1] = side * 0.3
    loop.run(3)
    assert "segment 0 ended (travel)" in loop.texts()


@SIDES
def test_a_creep_below_the_noise_of_the_gyro_is_stopped_at_the_limit_by_the_encoder(side: float) -> None:
    loop = HostLoop(unmodelled())
    loop.antenna.friction, loop.antenna.position[1] = (0.0, 0.0), side * 1.9985
    loop.connected().command(hold(Mode.TORQUE)).run(5)
    loop.antenna.rate[1] = side * 0.012
    loop.run(100)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    loop.run(200)
    assert "segment 0 ended (travel)" in loop.texts()
    assert 1.999 < abs(loop.antenna.position[1]) <= 2.0 + 1e-4


@SIDES
@pytest.mark.parametrize("position", [2.03, 2.2])
def test_an_axis_at_rest_beyond_its_limit_is_left_alone(position: float, side: float) -> None:
    loop = HostLoop(unmodelled())
    loop.antenna.position[1] = side * position
    loop.connected().command(hold(Mode.TORQUE)).run(100)
    assert loop.host.state is HostState.ACTIVE, loop.texts()


@SIDES
def test_an_axis_without_torque_may_swing_beyond_its_limit_while_the_other_one_works(side: float) -> None:
    loop = HostLoop(unmodelled())
    loop.antenna.position[1] = side * 1.8
    loop.connected().command(Segment(AxisCommand(Mode.RATE), AxisCommand())).run(10)
    loop.antenna.rate[1] = side * 1.0
    loop.run(500)
    assert abs(loop.antenna.position[1]) > 2.1
    assert loop.host.state is HostState.ACTIVE, loop.texts()


@SIDES
def test_an_axis_that_is_held_at_its_limit_may_be_pushed_a_little_past_it(side: float) -> None:
    loop = HostLoop(unmodelled())
    loop.antenna.position[1] = side * 1.99
    loop.connected().command(hold(Mode.POSITION, 0.0, side * 2.0)).run(1500)
    loop.antenna.load[1] = side * 1.0
    before = loop.number
    farthest = 0.0
    while loop.number < before + 200:
        loop.run(1)
        farthest = max(farthest, abs(loop.antenna.position[1]))
    assert 2.001 < farthest < 2.025
    assert loop.host.state is HostState.ACTIVE, loop.texts()


@SIDES
def test_the_cable_is_not_wound_further_than_it_may_be_in_either_direction(side: float) -> None:
    loop = HostLoop()
    loop.antenna.position[0] = side * 3.9 * math.pi
    loop.connected().command(hold(Mode.RATE, side)).run(2000)
    assert "segment 0 ended (cable_wrap)" in loop.texts()
    assert abs(loop.antenna.position[0]) <= 4.0 * math.pi + 1e-3


@SIDES
@pytest.mark.parametrize("axis", [0, 1])
def test_an_axis_that_is_too_fast_is_a_fault_in_either_direction(axis: int, side: float) -> None:
    torques = [0.0, 0.0]
    torques[axis] = side * (15.0, 6.0)[axis]
    free = unmodelled(inner__limits__position_low_rad=None, inner__limits__position_high_rad=None, inner__adjustable={})
    loop = HostLoop(free).connected().command(hold(Mode.TORQUE, *torques)).run(600)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.OVERSPEED), loop.texts()


@SIDES
@pytest.mark.parametrize(
    ("mode", "position_rad", "rate_rad_s", "cause"),
    [
        (Mode.POSITION, 0.1, 9.0, HostCause.FOLLOWING_ERROR),
        (Mode.POSITION, 9.0, 0.1, HostCause.NONE),
        (Mode.RATE, 9.0, 0.1, HostCause.FOLLOWING_ERROR),
        (Mode.RATE, 0.1, 9.0, HostCause.NONE),
        (Mode.INERTIAL_RATE, 9.0, 0.1, HostCause.FOLLOWING_ERROR),
        (Mode.TORQUE, 0.1, 0.1, HostCause.NONE),
    ],
)
def test_a_loop_is_held_to_the_following_error_of_its_own_kind(
    mode: Mode, position_rad: float, rate_rad_s: float, cause: HostCause, side: float
) -> None:
    limits = {"following_position_rad": position_rad, "following_rate_rad_s": rate_rad_s}
    changes = {f"inner__limits__{name}": value for name, value in limits.items()}
    loop = HostLoop(unmodelled(supervisor__following_time_s=0.05, **changes)).connected().command(hold(mode)).run(5)
    for _ in range(100):
        loop.host.memory.H[layout.axis_h(1) + LOOP_ERROR] = side * 0.5
        loop.run(1)
    assert loop.host.cause is cause, loop.texts()


def test_coming_back_from_beyond_a_soft_limit_is_no_event_and_going_out_again_is() -> None:
    loop = HostLoop()
    loop.antenna.position[1] = 1.9
    loop.connected()
    for rate in (1.0, -1.0, 1.0):
        loop.antenna.rate[1] = rate
        loop.run(250)
    told = [text for text in loop.texts() if "soft limit" in text]
    assert told == ["inner moved past its upper soft limit without torque"] * 2
