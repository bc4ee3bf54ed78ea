"""Whoever is refused a motion is told what ends the state that refuses it."""

from __future__ import annotations

import pytest

from gimbal_hil.loop.host import Host, HostState, Mode
from gimbal_hil.realtime.daemon import refusing
from tests.host.host_loop import HostLoop, configuration, hold

TRAVEL = {"outer__limits__position_low_rad": -2.0, "outer__limits__position_high_rad": 2.0}


def test_a_fault_names_the_command_that_leaves_it_and_its_cause() -> None:
    loop = HostLoop().connected()
    loop.host.quick_stop()
    loop.run(3)
    said = refusing.why_not_now(loop.host)
    assert "fault" in said and "`gimbal-hil reset`" in said and "operator" in said


def test_before_an_antenna_answers_there_is_nothing_to_reset() -> None:
    said = refusing.why_not_now(HostLoop().host)
    assert "once the antenna answers" in said and "reset" not in said


def moving(rate: float, until_rad: float) -> HostLoop:
    """The outer axis on its way to this place, at this rate (rad/s) if it gets so fast."""
    loop = HostLoop(Host(configuration(**TRAVEL)))
    loop.connected().command(hold(Mode.RATE, rate))
    while loop.antenna.position[0] * (1.0 if rate > 0.0 else -1.0) < until_rad:
        loop.run(1)
        assert loop.host.state is HostState.ACTIVE and loop.number < 20000
    return loop


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("rate", "until_rad"), [(1.0, 1.9), (3.0, 1.0), (3.0, 1.4)])
def test_a_torque_that_could_not_brake_an_axis_any_more_is_refused_while_it_moves(
    sign: float, rate: float, until_rad: float
) -> None:
    loop = moving(sign * rate, until_rad)
    weaker = configuration(outer__limits__torque_nm=1.2, **TRAVEL)
    said = refusing.why_not_adjusted(loop.host, weaker)
    assert "outer moves at" in said and "could not be braked before its limit" in said
    # with what it has it can be, and gains may change
    assert not refusing.why_not_adjusted(loop.host, configuration(outer__rate_loop__kp_s_per_rad=50.0, **TRAVEL))
    loop.run(3000)
    assert loop.host.state is HostState.IDLE and abs(loop.antenna.position[0]) <= 2.0
    assert not refusing.why_not_adjusted(loop.host, weaker)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_torque_that_can_still_brake_an_axis_is_taken_and_does(sign: float) -> None:
    loop = moving(sign, 1.0)
    weaker = configuration(outer__limits__torque_nm=1.2, **TRAVEL)
    assert not refusing.why_not_adjusted(loop.host, weaker)
    loop.host.adjust(weaker)
    loop.run(4000)
    assert loop.host.state is HostState.IDLE and abs(loop.antenna.position[0]) <= 2.0


def test_a_limit_is_not_set_before_an_axis_that_moves_towards_it() -> None:
    loop = moving(3.0, 0.5)
    nearer = TRAVEL | {"outer__limits__position_high_rad": 0.6}
    assert "outer moves at 3 rad/s" in refusing.why_not_adjusted(loop.host, configuration(**nearer))
    # away from it: it may
    loop = moving(-3.0, 0.2)
    assert not refusing.why_not_adjusted(loop.host, configuration(**nearer))


def test_an_axis_that_brakes_keeps_what_it_brakes_with() -> None:
    loop = moving(3.0, 1.0)
    while loop.host.state is HostState.ACTIVE:
        loop.run(1)
    assert loop.host.state is HostState.STOPPING
    assert refusing.why_not_adjusted(loop.host, configuration(outer__limits__torque_nm=2.0, **TRAVEL))
    assert not refusing.why_not_adjusted(loop.host, configuration(**TRAVEL))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_rate_limit_below_what_an_axis_moves_at_is_refused_until_it_rests(sign: float) -> None:
    loop = moving(sign * 1.0, 0.4)
    slower = configuration(outer__limits__rate_rad_s=0.7, **TRAVEL)
    assert "outer moves at" in refusing.why_not_adjusted(loop.host, slower)
    assert not refusing.why_not_adjusted(loop.host, configuration(outer__limits__rate_rad_s=1.4, **TRAVEL))
    loop.host.stop()
    loop.run(1000)
    assert loop.host.state is HostState.IDLE and not refusing.why_not_adjusted(loop.host, slower)
    # a free axis may be as fast as it likes, as before
    loop.antenna.rate[0] = sign * 1.0
    loop.run(2)
    assert not refusing.why_not_adjusted(loop.host, slower)


def test_an_axis_that_is_too_fast_already_may_get_any_limit() -> None:
    loop = moving(1.0, 0.4)
    loop.host.adjust(configuration(outer__limits__rate_rad_s=0.9, **TRAVEL))
    assert not refusing.why_not_adjusted(loop.host, configuration(outer__limits__rate_rad_s=0.8, **TRAVEL))


def test_a_lowered_rate_limit_slows_the_next_motion_down_instead_of_ending_it() -> None:
    loop = HostLoop(Host(configuration(**TRAVEL))).connected()
    loop.host.adjust(configuration(outer__limits__rate_rad_s=0.7, **TRAVEL))
    loop.command(hold(Mode.POSITION, 1.5, 0.0))
    fastest = 0.0
    for _ in range(5000):
        loop.run(1)
        fastest = max(fastest, abs(loop.antenna.rate[0]))
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    assert loop.antenna.position[0] == pytest.approx(1.5, abs=0.01) and 0.5 < fastest < 0.7
