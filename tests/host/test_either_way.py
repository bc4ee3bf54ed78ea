"""What the guards remember does not depend on which way an axis turns, and counts only what it should."""

from __future__ import annotations

import math
from typing import Any

import pytest

from firmware_protocol.enumerations import LimitFlags
from gimbal_hil.loop.host import AxisCommand, Host, HostCause, HostState, Mode, ReferenceOrigin, Segment, Shape
from gimbal_hil.loop.host.layout import GYRO_QUIET_CHANGES, GYRO_QUIET_TICKS, GYRO_STEP, SEEN_MOMENTUM, axis_g, axis_h
from gimbal_hil.loop.host.plausibility import _window
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


def momentum_seen(loop: HostLoop, axis: int) -> float:
    """What was against an axis while its sensors told something new."""
    return float(loop.host.memory.H[axis_h(axis) + SEEN_MOMENTUM])


@AXES
@pytest.mark.parametrize("rate_rad_s", [0.2, -0.2])
def test_what_may_hold_an_axis_is_learned_once_it_has_moved_in_either_direction(axis: int, rate_rad_s: float) -> None:
    loop = HostLoop()
    _noise(loop)
    loop.connected().command(hold(Mode.RATE)).run(100)
    # noise is no motion
    assert momentum_seen(loop, axis) == 0.0
    loop.command(hold(Mode.RATE, *(rate_rad_s if k == axis else 0.0 for k in range(2)))).run(200)
    assert momentum_seen(loop, axis) > 0.0 and momentum_seen(loop, 1 - axis) == 0.0


def told(loop: HostLoop, axis: int, rates: list[float], scale: float = 1.0) -> HostLoop:
    """The gyro tells these rates one after the other while the axis stands still without torque."""
    for rate in rates:
        loop.antenna.gyro_error[axis] = scale * rate
        loop.run(1)
    return loop


@AXES
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_step_of_a_gyro_is_the_least_change_that_it_told_either_way(axis: int, side: float) -> None:
    loop = HostLoop().connected()
    step = axis_h(axis) + GYRO_STEP
    told(loop, axis, [0.004, 0.001, 0.001, 0.003, 0.003, 0.003, 0.001], side).run(1)
    assert loop.host.memory.H[step] == pytest.approx(0.002, rel=0.02)
    told(loop, axis, [0.005, 0.005], side).run(1)
    assert loop.host.memory.H[step] == pytest.approx(0.002, rel=0.02)


@AXES
def test_noise_counts_alike_whichever_way_it_bends(axis: int) -> None:
    # two steps up, then slowly down: it bends up twice as often by as much as it bends down
    shape = [0.0, 0.001, 0.006, 0.006, 0.005, 0.009, 0.009, 0.002, 0.008, 0.0]
    found = []
    for side in (1.0, -1.0):
        loop = HostLoop().connected()
        told(loop, axis, shape * 3, side).run(2)
        found.append(int(loop.host.memory.G[axis_g(axis) + GYRO_QUIET_CHANGES]))
    assert found[0] == found[1] > 10


@AXES
def test_samples_beside_one_that_was_lost_tell_nothing_of_noise(axis: int) -> None:
    loop = HostLoop().connected()
    before = quiet_ticks(loop, axis)
    loop.antenna.silent = True
    loop.run(2)
    loop.antenna.silent = False
    loop.run(10)
    # of twelve ticks two without a sample, one after them and one whose line begins there
    assert before < quiet_ticks(loop, axis) <= before + 12 - 3


@pytest.mark.parametrize("ticks", [2, 7])
def test_a_window_over_several_ticks_forgets_as_much_as_tick_by_tick(ticks: int) -> None:
    held = 5.0
    for _ in range(ticks):
        held = 0.9 * held + 0.3
    kept, new = _window(0.9, ticks)
    assert kept * 5.0 + new * 0.3 * ticks == pytest.approx(held)


@AXES
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("now_fast", [True, False])
def test_an_axis_that_is_fast_at_either_end_of_a_tick_may_be_two_periods_off(
    axis: int, side: float, now_fast: bool
) -> None:
    loop = HostLoop(Host(configuration(**DRIFT_ONLY | {"inner__limits__stuck_gyro_ticks": None}))).connected()
    fast = side * 9.0
    loop.antenna.friction = (0.0, 0.0)
    if not now_fast:
        loop.antenna.rate[axis] = fast
        loop.run(3)
        # without torque nobody asks how fast an axis is
        assert loop.host.state is HostState.IDLE, loop.texts()
    loop.antenna.rate[axis] = fast if now_fast else 0.0
    # beside the way that both rates explain: more than a step of the coarsest encoder, by less than two periods
    turned = 0.5 * 0.001 * fast
    loop.antenna.position[axis] += turned - (0.001 * fast if now_fast else 0.0) - side * 0.062
    loop.run(2)
    assert loop.host.cause is not HostCause.POSITION_JUMP, loop.texts()
