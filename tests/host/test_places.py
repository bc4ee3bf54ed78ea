"""Positions to which no axis can have gone, and feedback that stands still under a torque that must move the axis."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gimbal_hil.loop.host import Host, HostCause, HostState, Mode, layout
from gimbal_hil.loop.settings import AxisSettings, shipped_settings
from tests.host.host_loop import HostLoop, configuration, hold

#: shipped limits without the guards that see the same later
JUMPS_ONLY = {
    f"{axis}__limits__{key}": None
    for axis in ("outer", "inner")
    for key in ("gyro_encoder_rad", "gyro_encoder_rad_s", "stuck_gyro_ticks", "following_position_rad")
}


def _held(**changes: object) -> HostLoop:
    return HostLoop(Host(configuration(**JUMPS_ONLY, **changes))).connected().command(hold(Mode.RATE)).run(100)


def _axes() -> list[AxisSettings]:
    return list(shipped_settings().axes.values())


def _shifted(loop: HostLoop, axis: int, by: float) -> None:
    loop.antenna.position[axis] += by


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("jump", [0.06, -0.06, 6.283])
def test_a_position_that_jumps_is_noticed_with_the_first_sample(axis: int, jump: float) -> None:
    loop = _held()
    _shifted(loop, axis, jump)
    loop.run(3)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.POSITION_JUMP), loop.texts()


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("step", [0.04, -0.04])
def test_a_step_that_a_coarse_encoder_makes_is_no_jump(axis: int, step: float) -> None:
    loop = _held()
    _shifted(loop, axis, step)
    loop.run(3)
    assert loop.host.cause is not HostCause.POSITION_JUMP


def test_fast_motion_is_no_jump() -> None:
    loop = HostLoop(Host(configuration(**JUMPS_ONLY))).connected().command(hold(Mode.RATE, 5.0, -5.0)).run(800)
    assert loop.host.cause is not HostCause.POSITION_JUMP


@pytest.mark.parametrize("axis", [0, 1])
def test_a_jump_of_an_axis_without_torque_waits_for_an_operator(axis: int) -> None:
    loop = HostLoop(Host(configuration(**JUMPS_ONLY))).connected()
    _shifted(loop, axis, -1.0)
    loop.run(300)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.POSITION_JUMP)
    loop.host.reset_fault()
    loop.run(300)
    assert loop.host.state is HostState.IDLE


@pytest.mark.parametrize(
    ("moved", "cause"),
    [(0.2, "FEEDBACK_LOST"), (-0.2, "FEEDBACK_LOST"), (0.3, "POSITION_JUMP"), (-0.3, "POSITION_JUMP")],
)
def test_after_a_silence_an_axis_may_have_crept_but_not_jumped(moved: float, cause: str) -> None:
    loop = HostLoop(Host(configuration(**JUMPS_ONLY))).connected()
    loop.antenna.silent = True
    loop.run(200)
    _shifted(loop, 0, moved)
    loop.antenna.silent = False
    loop.run(400)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause[cause]), loop.texts()


@pytest.mark.parametrize("rate", [2.0, -2.0])
def test_an_axis_that_moved_as_the_silence_began_or_ended_may_have_gone_on(rate: float) -> None:
    for ended in (False, True):
        loop = HostLoop(Host(configuration(**JUMPS_ONLY))).connected().command(hold(Mode.RATE, 0.0 if ended else rate))
        loop.run(400)
        loop.antenna.silent = True
        loop.run(10)
        loop.antenna.rate[0] = 0.0
        loop.run(190)
        _shifted(loop, 0, 0.6 * rate / 2.0)
        loop.antenna.rate[0] = rate if ended else 0.0
        loop.antenna.silent = False
        loop.run(400)
        assert loop.host.cause is not HostCause.POSITION_JUMP, (ended, loop.texts())


@pytest.mark.parametrize("ticks", [2, 6])
def test_a_jump_while_the_host_connects_keeps_it_from_taking_over(ticks: int) -> None:
    loop = HostLoop(Host(configuration(**JUMPS_ONLY))).run(ticks)
    before = loop.host.state
    assert before in (HostState.WAITING, HostState.SYNCHRONISING)
    _shifted(loop, 1, 0.5)
    loop.run(300)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.POSITION_JUMP), loop.texts()
    assert f"{before.name.lower()} to fault (position_jump)" in loop.texts(), loop.texts()


def test_a_fault_keeps_its_own_cause_when_a_jump_follows() -> None:
    loop = HostLoop(Host(configuration(outer__limits__rate_rad_s=1.0))).connected().command(hold(Mode.RATE)).run(50)
    loop.antenna.rate[0] = 3.0
    loop.run(30)
    cause = loop.host.cause
    assert loop.host.state is HostState.FAULT and cause is not HostCause.POSITION_JUMP
    _shifted(loop, 0, 1.0)
    loop.run(30)
    assert loop.host.cause is cause


def test_where_an_axis_stands_when_it_is_first_heard_is_no_jump() -> None:
    loop = HostLoop(Host(configuration(**JUMPS_ONLY)))
    loop.antenna.position[0] = 3.0
    loop.connected()


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("axis", [0, 1])
def test_feedback_that_stands_still_under_much_torque_is_frozen(axis: int, sign: float) -> None:
    loop = _held()
    place, rate = loop.antenna.position[axis], loop.antenna.rate[axis]
    _moves(loop, lambda: _set(loop, axis, place, rate))
    _under_torque(loop, axis, sign, 90)
    assert loop.host.cause is not HostCause.FEEDBACK_FROZEN, loop.texts()
    loop.run(30)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.FEEDBACK_FROZEN), loop.texts()


def test_an_axis_that_goes_on_evenly_under_torque_is_not_frozen() -> None:
    loop = _held()
    _moves(loop, lambda: _set(loop, 0, loop.antenna.position[0] + 1e-5, 0.01))
    _under_torque(loop, 0, 1.0, 150)
    assert loop.host.cause is not HostCause.FEEDBACK_FROZEN, loop.texts()


def _set(loop: HostLoop, axis: int, place: float, rate: float) -> None:
    loop.antenna.position[axis], loop.antenna.rate[axis] = place, rate


def _moves(loop: HostLoop, instead: Callable[[], None]) -> None:
    """After each tick's motion something else is put in the place of one axis' own."""
    seen = loop.antenna._move

    def move() -> None:
        seen()
        instead()

    loop.antenna._move = move  # type: ignore[method-assign]


def _under_torque(loop: HostLoop, axis: int, sign: float, ticks: int, share: float = 1.1) -> None:
    """A share of the torque that is neither the motor's nor the weight's: a little more than it."""
    torque = [sign * share * one.expectation.disturbance_nm if k == axis else 0.0 for k, one in enumerate(_axes())]
    loop.command(hold(Mode.TORQUE, *torque)).run(ticks)


@pytest.mark.parametrize("has_moved", [True, False])
@pytest.mark.parametrize("share", [0.05, 0.3])
@pytest.mark.parametrize("axis", [0, 1])
def test_an_axis_that_has_moved_stands_still_under_no_more_than_was_against_it(
    axis: int, share: float, has_moved: bool
) -> None:
    loop = _held()
    if has_moved:
        loop.command(hold(Mode.RATE, *(0.2 if k == axis else 0.0 for k in range(2)))).run(200)
        loop.command(hold(Mode.RATE)).run(200)
    _stands(loop, axis, lambda: 0.0)
    _under_torque(loop, axis, 1.0, 90, share)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    loop.run(60)
    trips = has_moved and share > 0.1
    assert (loop.host.cause is HostCause.FEEDBACK_FROZEN) == trips, loop.texts()


@pytest.mark.parametrize("axis", [0, 1])
def test_a_load_that_was_seen_to_come_may_be_held_without_a_sign_of_life(axis: int) -> None:
    loop = _held()
    loop.command(hold(Mode.RATE, *(0.2 if k == axis else 0.0 for k in range(2)))).run(200)
    loop.command(hold(Mode.RATE)).run(200)
    counts = [1e-4]
    _stands(loop, axis, lambda: counts[0] * (loop.number & 1))
    # wind, which the loop holds against: the sensor still flickers
    _under_torque(loop, axis, 1.0, 200, 0.5)
    counts[0] = 0.0
    for share in (0.5, 0.9):
        _under_torque(loop, axis, 1.0, 300, share)
        assert loop.host.state is HostState.ACTIVE, loop.texts()


def _stands(loop: HostLoop, axis: int, off_rad: Callable[[], float]) -> None:
    """From now on the axis says that it stands where it is, so far off."""
    place = loop.antenna.position[axis]
    _moves(loop, lambda: _set(loop, axis, place + off_rad(), 0.0))


@pytest.mark.parametrize(("period", "trips"), [(7, True), (100, True), (200, True), (201, False)])
@pytest.mark.parametrize("axis", [0, 1])
def test_samples_that_repeat_themselves_tell_nothing_new(axis: int, period: int, trips: bool) -> None:
    loop = _held()
    loop.command(hold(Mode.RATE, *(0.2 if k == axis else 0.0 for k in range(2)))).run(200)
    loop.command(hold(Mode.RATE)).run(200)
    old = np.random.default_rng(3).uniform(-1e-3, 1e-3, period)
    _stands(loop, axis, lambda: float(old[loop.number % period]))
    # nobody can know before they have come twice
    loop.run(2 * period + 100)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    _under_torque(loop, axis, 1.0, 200, 0.3)
    assert (loop.host.cause is HostCause.FEEDBACK_FROZEN) == trips, loop.texts()


def test_what_repeats_itself_and_then_says_something_new_is_no_more_repeated() -> None:
    loop = _held()
    loop.command(hold(Mode.RATE, 0.2)).run(200)
    loop.command(hold(Mode.RATE)).run(200)
    fresh = [0.0]
    _stands(loop, 0, lambda: 1e-4 * (loop.number % 5) + fresh[0])
    loop.run(250)
    repeats = layout.axis_g(0) + layout.REPEATS
    assert loop.host.memory.G[repeats] == 1
    fresh[0] = 1e-4
    loop.run(32)
    assert loop.host.memory.G[repeats] == 0
    _under_torque(loop, 0, 1.0, 80, 0.3)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    # nor is it after a silence, until it has come as often again
    loop.command(hold(Mode.RATE)).run(200)
    assert loop.host.memory.G[repeats] == 1
    loop.antenna.silent = True
    loop.run(200)
    loop.antenna.silent = False
    loop.run(60)
    assert loop.host.memory.G[repeats] == 0
