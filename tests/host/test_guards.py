"""The host's own guards: each one trips for its cause, and torque is off or braking afterwards."""

from __future__ import annotations

import math

import pytest

from gimbal_hil.loop.control.layout import RATE_INTEGRAL
from gimbal_hil.loop.host import (
    AxisCommand,
    EndCondition,
    EndKind,
    Guard,
    Host,
    HostCause,
    HostState,
    Mode,
    Segment,
    Shape,
    layout,
)
from tests.host.host_loop import HostLoop, configuration, hold


def faulted(loop: HostLoop, cause: HostCause) -> None:
    """The loop ended in FAULT for this cause, without torque."""
    assert loop.host.state is HostState.FAULT, loop.texts()
    assert loop.host.cause is cause
    assert loop.sent[-1].torque == (0, 0)
    assert loop.sent[-1].enable == (0, 0)


def test_overspeed_is_a_fault() -> None:
    loop = HostLoop().connected().command(hold(Mode.TORQUE, 15.0)).run(600)
    faulted(loop, HostCause.OVERSPEED)


def test_a_gyro_that_disagrees_with_the_encoder_is_a_fault() -> None:
    host = Host(configuration(inner__expectation=None, inner__limits__gyro_encoder_rad=None))
    loop = HostLoop(host).connected().command(hold(Mode.POSITION)).run(50)
    loop.antenna.gyro_error[1] = 1.5
    loop.run(500)
    faulted(loop, HostCause.GYRO_ENCODER_DISAGREE)


def test_a_moving_base_is_no_disagreement() -> None:
    loop = HostLoop().connected().command(hold(Mode.POSITION)).run(50)
    for step in range(500):
        loop.antenna.base_rate = [0.6 * step / 500, 0.9 * step / 500, -1.0 * step / 500]
        loop.run(1)
    loop.run(2000)
    assert loop.host.state is HostState.ACTIVE


def test_a_following_error_that_lasts_is_a_fault() -> None:
    limits = {
        "outer__limits__following_position_rad": 0.1,
        "supervisor__following_time_s": 0.2,
        "outer__expectation": None,
    }
    loop = HostLoop(Host(configuration(**limits))).connected().command(hold(Mode.POSITION)).run(50)
    loop.antenna.load[0] = 16.5
    loop.run(1500)
    faulted(loop, HostCause.FOLLOWING_ERROR)


def test_a_hot_winding_is_a_fault() -> None:
    loop = HostLoop().connected().command(hold(Mode.POSITION)).run(50)
    loop.host.memory.H[layout.axis_h(1) + layout.MOTOR_TEMPERATURE] = 111.0
    loop.run(2)
    faulted(loop, HostCause.TEMPERATURE)


def test_a_torque_that_is_no_number_is_never_sent() -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE)).run(50)
    loop.host.memory.H[layout.axis_h(0) + RATE_INTEGRAL] = math.nan
    loop.run(1)
    faulted(loop, HostCause.NOT_A_NUMBER)


def test_a_stop_that_takes_too_long_is_a_fault() -> None:
    loop = (
        HostLoop(Host(configuration(supervisor__stop_time_s=1.0, outer__expectation=None)))
        .connected()
        .command(hold(Mode.RATE))
        .run(50)
    )
    loop.antenna.load[0] = 16.5
    loop.host.stop()
    loop.run(1200)
    faulted(loop, HostCause.STOP_TIMEOUT)


def test_a_drive_that_leaves_operation_ends_the_motion() -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE, 0.2)).run(50)
    loop.antenna.drive_state = 2
    loop.run(2)
    faulted(loop, HostCause.DRIVE_LEFT_OPERATION)


def test_set_points_that_the_drive_does_not_hear_are_a_fault() -> None:
    loop = HostLoop().connected().command(hold(Mode.POSITION)).run(50)
    stuck = loop.antenna
    original = stuck._obey
    stuck._obey = lambda: (original(), setattr(stuck, "last_sequence", 3))[0]  # type: ignore[method-assign]
    loop.run(100)
    faulted(loop, HostCause.SET_POINT_LOST)


@pytest.mark.parametrize("rate", [0.5, 3.0, -1.5])
def test_an_axis_stops_before_its_soft_limit_and_may_come_back(rate: float) -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE, 0.0, rate)).run(8000)
    assert "segment 0 ended (travel)" in loop.texts()
    assert loop.host.state is HostState.IDLE
    assert 1.0 < abs(loop.antenna.position[1]) <= 2.0 + 1e-3
    loop.command(hold(Mode.RATE, 0.0, math.copysign(0.3, -rate))).run(1000)
    assert loop.host.state is HostState.ACTIVE
    assert abs(loop.antenna.position[1]) < 1.9


def test_the_cable_is_not_wound_further_than_it_may_be() -> None:
    loop = HostLoop()
    loop.antenna.position[0] = 3.9 * math.pi
    loop.connected().command(hold(Mode.RATE, 1.0)).run(2000)
    assert "segment 0 ended (cable_wrap)" in loop.texts()
    assert loop.antenna.position[0] <= 4.0 * math.pi + 1e-3


def test_a_position_reference_beyond_a_soft_limit_is_held_at_the_limit() -> None:
    loop = HostLoop().connected().command(hold(Mode.POSITION, 0.0, 5.0)).run(6000)
    assert loop.host.state is HostState.ACTIVE
    assert loop.antenna.position[1] > 1.99
    assert max(abs(sent.torque[1]) for sent in loop.sent) <= 52800
    assert loop.antenna.position[1] <= 2.0 + 5e-3


def test_an_axis_pushed_out_of_its_travel_is_a_fault() -> None:
    loop = HostLoop(Host(configuration(inner__expectation=None)))
    loop.antenna.position[1] = 1.99
    loop.connected().command(Segment(AxisCommand(), AxisCommand(Mode.TORQUE))).run(5)
    loop.antenna.load[1] = 9.0
    loop.run(400)
    faulted(loop, HostCause.TRAVEL)


def test_torque_limits_hold_on_the_wire() -> None:
    loop = HostLoop().connected().command(hold(Mode.TORQUE, 1e3, -1e3)).run(5)
    assert loop.sent[-1].torque == (124000, -52800)


def test_a_guard_of_the_segment_is_looked_at_before_the_first_torque() -> None:
    guard = Guard(low_rad=0.5)
    segment = Segment(AxisCommand(Mode.TORQUE, Shape.HOLD, (1.0,), guard=guard), AxisCommand(), 100)
    loop = HostLoop().connected().command(segment).run(100)
    assert all(sent.torque == (0, 0) for sent in loop.sent)
    assert "segment 0 ended (guard)" in loop.texts()


def test_a_guard_ends_the_whole_program() -> None:
    guarded = Segment(
        AxisCommand(Mode.RATE, Shape.HOLD, (1.0,), guard=Guard(high_rad=0.3)), AxisCommand(), 1000, label=4
    )
    loop = HostLoop().connected().command(guarded, hold(Mode.RATE, 1.0, label=5)).run(1500)
    assert "segment 4 ended (guard)" in loop.texts()
    assert "segment 5 started" not in loop.texts()
    assert loop.host.state is HostState.IDLE


@pytest.mark.parametrize(
    ("end", "after_ticks"),
    [
        # 1 N m on 0.5 kg m2 is 2 rad/s2, a little less with friction
        (EndCondition(EndKind.POSITION_ABOVE, 0, 0.2), 448),
        (EndCondition(EndKind.RATE_ABOVE, 0, 0.4), 203),
        (EndCondition(EndKind.RATE_ABOVE, 0, 0.4, hold_ticks=20), 222),
        (EndCondition(EndKind.TORQUE_ABOVE, 0, 0.9), 0),
        (EndCondition(EndKind.RATE_BELOW, 1, 0.1, hold_ticks=10), 9),
        (EndCondition(EndKind.POSITION_BELOW, 1, -0.1), 0),
    ],
)
def test_an_end_condition_starts_the_next_segment_when_it_holds(end: EndCondition, after_ticks: int) -> None:
    first = Segment(AxisCommand(Mode.TORQUE, Shape.HOLD, (1.0,)), AxisCommand(), 0, ends=(end,), label=1)
    loop = HostLoop()
    loop.antenna.position[1] = -0.2
    loop.connected().command(first, hold(Mode.RATE, label=2)).run(3000)
    assert "segment 1 ended (end_condition)" in loop.texts()
    assert "segment 2 started" in loop.texts()
    tick = {event.text: event.tick for event in loop.events}
    assert tick["segment 1 ended (end_condition)"] - tick["segment 1 started"] == pytest.approx(after_ticks, abs=3)


def test_a_quick_stop_takes_torque_off_at_once_and_stops_the_drive() -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE, 1.0)).run(300)
    loop.host.quick_stop()
    loop.run(1)
    faulted(loop, HostCause.OPERATOR)
    assert loop.antenna.requests[-1][2] == 1
