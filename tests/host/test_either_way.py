"""What the guards remember does not depend on which way an axis turns, and counts only what it should."""

from __future__ import annotations

import math
from typing import Any

import pytest

from firmware_protocol.enumerations import LimitFlags
from gimbal_hil.loop.host import AxisCommand, Host, HostCause, HostState, Mode, ReferenceOrigin, Segment, Shape
from gimbal_hil.loop.host.layout import GYRO_QUIET_CHANGES, GYRO_QUIET_TICKS, axis_g
from tests.host.host_loop import HostLoop, configuration, hold
from tests.host.test_plausibility import DRIFT_ONLY, _noise, _tripped

AXES = pytest.mark.parametrize("axis", [0, 1])


def tripped_after(loop: HostLoop, start: int) -> int:
    """Ticks from `start` to the fault."""
    return next(event.tick for event in loop.events if "to fault" in event.text) - start


@AXES
def test_an_encoder_that_walks_away_is_noticed_after_the_same_way_in_either_direction(axis: int) -> None:
    found = []
    for sign in (1.0, -1.0):
        loop = HostLoop(Host(configuration(**DRIFT_ONLY))).connected().command(hold(Mode.TORQUE)).run(50)
        seen, start = loop.antenna._fill, loop.number

        def fill(mail: Any, sign: float = sign, loop: HostLoop = loop, seen: Any = seen, start: int = start) -> None:
            seen(mail, {axis: sign * 0.2e-3 * (loop.number - start)})

        loop.antenna._fill = fill  # type: ignore[method-assign]
        loop.run(400)
        _tripped(loop, HostCause.SENSOR_DRIFT)
        found.append(tripped_after(loop, start))
    # five per cent of the way make eight ticks here
    assert abs(found[0] - found[1]) <= 2


@AXES
def test_a_gyro_that_is_off_is_noticed_after_the_same_way_in_either_direction(axis: int) -> None:
    found = []
    for sign in (1.0, -1.0):
        loop = HostLoop(Host(configuration(**DRIFT_ONLY))).connected().command(hold(Mode.TORQUE)).run(50)
        start = loop.number
        loop.antenna.gyro_error[axis] = 0.2 * sign
        loop.run(400)
        _tripped(loop, HostCause.SENSOR_DRIFT)
        found.append(tripped_after(loop, start))
    assert abs(found[0] - found[1]) <= 2


@AXES
def test_a_motor_that_does_nothing_is_noticed_as_early_in_either_direction(axis: int) -> None:
    found = []
    for sign in (1.0, -1.0):
        loop = HostLoop().connected()
        loop.antenna.motor_sign[axis] = 0.0
        start, torques = loop.number, [0.0, 0.0]
        torques[axis] = 6.0 * sign
        loop.command(hold(Mode.TORQUE, *torques)).run(200)
        _tripped(loop, HostCause.RUNAWAY)
        found.append(tripped_after(loop, start))
    assert abs(found[0] - found[1]) <= 1


@AXES
@pytest.mark.parametrize(("onwards", "own"), [(True, True), (False, True), (True, False)])
def test_only_torque_that_the_drive_cuts_because_the_axis_is_too_fast_is_no_runaway(
    axis: int, onwards: bool, own: bool
) -> None:
    loop = HostLoop().connected()
    flag = (LimitFlags.OUTER_RATE, LimitFlags.INNER_RATE)[axis if own else 1 - axis]
    loop.antenna.limits, loop.antenna.motor_sign[axis] = int(flag), 0.0
    loop.antenna.rate[axis] = 1.0 if onwards else -1.0
    loop.run(3)
    torques = [0.0, 0.0]
    torques[axis] = 6.0
    loop.command(hold(Mode.TORQUE, *torques)).run(150)
    # torque against the motion, or while the other axis is too fast, is not cut: there the motor does nothing
    cut = onwards and own
    assert loop.host.state is (HostState.ACTIVE if cut else HostState.FAULT), loop.texts()
    assert cut or loop.host.cause is HostCause.RUNAWAY


def test_a_gyro_may_be_stuck_where_its_guard_is_off() -> None:
    loop = HostLoop(Host(configuration(outer__limits__stuck_gyro_ticks=None, inner__limits__stuck_gyro_ticks=None)))
    _noise(loop)
    loop.connected().run(50).command(hold(Mode.RATE, 0.1, 0.1)).run(200)
    assert loop.host.state is HostState.ACTIVE, loop.texts()


def quiet_ticks(loop: HostLoop, axis: int) -> int:
    """Samples by which a gyro is known."""
    return int(loop.host.memory.G[axis_g(axis) + GYRO_QUIET_TICKS])


@AXES
@pytest.mark.parametrize("rate_rad_s", [0.5, -0.5])
def test_a_gyro_is_known_by_samples_at_rest_without_torque_only(axis: int, rate_rad_s: float) -> None:
    loop = HostLoop().connected()
    before = quiet_ticks(loop, axis)
    loop.run(20)
    assert quiet_ticks(loop, axis) == before + 20
    loop.command(hold(Mode.RATE)).run(20)
    assert quiet_ticks(loop, axis) <= before + 21
    loop.host.stop()
    loop.run(200)
    assert loop.host.state is HostState.IDLE
    before = quiet_ticks(loop, axis)
    loop.antenna.gyro_error[axis] = rate_rad_s
    loop.run(20)
    assert quiet_ticks(loop, axis) <= before + 1


def test_samples_at_rest_are_counted_up_to_an_end() -> None:
    loop = HostLoop().connected()
    loop.host.memory.G[axis_g(0) + GYRO_QUIET_TICKS] = 9_995
    loop.run(20)
    assert quiet_ticks(loop, 0) == 10_000


@AXES
def test_the_weight_of_an_axis_under_torque_counts_although_the_other_one_is_off(axis: int) -> None:
    moment = {("outer", "inner")[axis] + "__expectation__moment_kg_m": [0.3 if axis else 0.9, 0.0, 0.0]}
    loop = HostLoop(Host(configuration(**moment))).connected()
    if axis == 0:
        loop.antenna.base_roll = 0.5
    # along x: on a base that rolls for the outer axis, on a level one for the inner
    loop.antenna.load[axis] = 0.3 * 9.81 if axis else -0.9 * 9.81 * math.sin(0.5)
    loop.run(20)
    off, on = AxisCommand(Mode.OFF), AxisCommand(Mode.POSITION, Shape.HOLD, (0.0,), ReferenceOrigin.ABSOLUTE)
    loop.command(Segment(*((on, off) if axis == 0 else (off, on)))).run(200)
    assert loop.host.state is HostState.ACTIVE, loop.texts()


def test_a_gyro_of_which_too_little_was_seen_at_rest_may_repeat_itself() -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE)).run(3)
    for axis in range(2):
        g = axis_g(axis)
        loop.host.memory.G[g + GYRO_QUIET_TICKS] = loop.host.memory.G[g + GYRO_QUIET_CHANGES] = 0
    loop.run(200)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
