"""The state machine: which request counts in which state, and what the host waits for before it goes on."""

from __future__ import annotations

import pytest

from firmware_protocol import mail as m
from firmware_protocol.enumerations import LimitFlags
from gimbal_hil.loop.host import Host, HostCause, HostState, Mode, layout
from tests.host.fake_antenna import FakeAntenna
from tests.host.host_loop import HostLoop, configuration, hold

BRAKING = pytest.mark.parametrize("drive_state", [m.DRIVE_STATE_QUICK_STOP_ACTIVE, m.DRIVE_STATE_FAULT_REACTION_ACTIVE])


def active(**changes: object) -> HostLoop:
    """A host that holds a rate of zero."""
    return HostLoop(Host(configuration(**changes))).connected().command(hold(Mode.RATE)).run(20)


def in_drive_fault(loop: HostLoop, fault: int, state: int = m.DRIVE_STATE_FAULT) -> HostLoop:
    """The drive tells a fault."""
    loop.antenna.drive_state, loop.antenna.fault = state, fault
    return loop


def stuck(loop: HostLoop, drive_state: int) -> HostLoop:
    """The drive stays in a state whatever it is asked."""
    obey = loop.antenna._obey
    loop.antenna._obey = lambda: (obey(), setattr(loop.antenna, "drive_state", drive_state))[0]  # type: ignore[method-assign]
    return loop


@pytest.mark.parametrize("ask", ["stop", "quick_stop", "distrust"])
def test_no_request_but_a_reset_changes_a_fault_or_its_cause(ask: str) -> None:
    loop = in_drive_fault(active(), m.FAULT_CODE_OVERTEMPERATURE).run(3)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.DRIVE_FAULT)
    getattr(loop.host, ask)()
    loop.run(100)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.DRIVE_FAULT)
    assert [text for text in loop.texts() if text.startswith(("active to", "fault to"))] == [
        "active to fault (drive_fault)"
    ]


def test_a_reset_without_a_fault_changes_nothing() -> None:
    loop = active()
    loop.host.reset_fault()
    loop.run(5)
    assert loop.host.state is HostState.ACTIVE


def test_a_stop_without_motion_changes_nothing() -> None:
    loop = HostLoop().connected()
    loop.host.stop()
    loop.run(5)
    assert loop.host.state is HostState.IDLE
    assert not any("stopping" in text for text in loop.texts())


def test_a_verdict_of_the_first_test_is_a_fault_with_torque_off() -> None:
    loop = active()
    loop.host.distrust()
    loop.run(1)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.FIRST_TEST)
    assert loop.sent[-1].torque == (0, 0) and loop.sent[-1].enable == (0, 0)


@pytest.mark.parametrize(("fault", "allowed"), [(m.FAULT_CODE_TRAVEL_LIMIT, 1), (m.FAULT_CODE_OVERSPEED, 0)])
def test_the_way_back_from_a_travel_limit_is_allowed_with_the_reset_of_that_fault_only(
    fault: int, allowed: int
) -> None:
    loop = active()
    loop.antenna.limits = int(LimitFlags.OUTER_TRAVEL_HIGH)
    in_drive_fault(loop, fault).run(10)
    loop.host.reset_fault()
    loop.run(3)
    assert int(loop._mail[m.DRIVE_CONTROL_CLEAR_TRAVEL]) == allowed


def test_a_connection_takes_as_many_whole_sets_in_a_row_as_configured() -> None:
    loop = HostLoop(Host(configuration(supervisor__connect_ticks=200))).run(195)
    assert loop.host.state is HostState.WAITING
    loop.run(30)
    assert loop.host.state is HostState.IDLE


@pytest.mark.parametrize("fault", [m.FAULT_CODE_DEADMAN, m.FAULT_CODE_COMMUNICATION])
def test_what_silence_left_in_an_idle_drive_is_reset_without_a_fault_of_the_host(fault: int) -> None:
    loop = in_drive_fault(HostLoop().connected(), fault).run(300)
    assert loop.host.state is HostState.IDLE
    assert "idle to fault" not in " ".join(loop.texts())


def test_any_other_fault_of_an_idle_drive_is_a_fault_of_the_host() -> None:
    loop = in_drive_fault(HostLoop().connected(), m.FAULT_CODE_OVERTEMPERATURE).run(300)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.DRIVE_FAULT)
    assert "idle to fault (drive_fault)" in loop.texts()


def test_a_drive_that_still_reacts_to_its_fault_is_waited_for_while_idle() -> None:
    loop = stuck(HostLoop().connected(), m.DRIVE_STATE_FAULT_REACTION_ACTIVE)
    loop.antenna.fault = m.FAULT_CODE_OVERTEMPERATURE
    loop.run(50)
    assert "idle to synchronising (drive_left_operation)" in loop.texts()
    assert loop.host.state is HostState.SYNCHRONISING


def test_a_drive_that_leaves_operation_while_idle_is_taken_back_to_it() -> None:
    loop = HostLoop().connected()
    loop.antenna.drive_state = m.DRIVE_STATE_READY_TO_SWITCH_ON
    loop.run(50)
    assert "idle to synchronising (drive_left_operation)" in loop.texts()
    assert (loop.host.state, loop.antenna.drive_state) == (HostState.IDLE, m.DRIVE_STATE_OPERATION_ENABLED)


@pytest.mark.parametrize("state", [m.DRIVE_STATE_FAULT, m.DRIVE_STATE_FAULT_REACTION_ACTIVE])
def test_a_fault_of_the_drive_under_torque_is_told_as_its_fault(state: int) -> None:
    loop = in_drive_fault(active(), m.FAULT_CODE_OVERSPEED, state).run(3)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.DRIVE_FAULT)


def test_another_antenna_that_comes_while_the_drive_is_brought_up_is_refused() -> None:
    loop = HostLoop()
    loop.antenna.drive_state = m.DRIVE_STATE_NOT_READY
    loop.run(50)
    assert loop.host.state is HostState.SYNCHRONISING
    loop.antenna.introduce_unasked, loop.antenna.serial_number = True, 99
    loop.run(5)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.WRONG_ANTENNA)


def test_an_antenna_that_falls_silent_while_its_drive_is_brought_up_is_waited_for() -> None:
    loop = HostLoop()
    loop.antenna.drive_state = m.DRIVE_STATE_NOT_READY
    loop.run(50)
    loop.antenna.silent = True
    loop.run(20)
    assert loop.host.state is HostState.WAITING


@pytest.mark.parametrize(
    ("fault", "state"), [(m.FAULT_CODE_DEADMAN, HostState.IDLE), (m.FAULT_CODE_OVERTEMPERATURE, HostState.FAULT)]
)
def test_of_the_faults_of_a_drive_under_torque_only_its_deadman_is_left_without_an_operator(
    fault: int, state: HostState
) -> None:
    loop = in_drive_fault(active(), fault).run(500)
    assert "active to fault (drive_fault)" in loop.texts()
    assert loop.host.state is state


def test_a_deadman_that_trips_after_another_fault_does_not_end_that_fault() -> None:
    loop = active()
    loop.host.quick_stop()
    loop.run(5)
    in_drive_fault(loop, m.FAULT_CODE_DEADMAN).run(500)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.OPERATOR)


def after_silence(**changes: object) -> HostLoop:
    """A host in FAULT because feedback was lost, and an antenna that has started anew."""
    loop = HostLoop(Host(configuration(**changes))).run(300).command(hold(Mode.RATE)).run(20)
    loop.antenna.silent = True
    loop.run(50)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.FEEDBACK_LOST)
    loop.antenna = FakeAntenna()
    return loop


def test_after_a_quick_stop_in_lost_feedback_only_a_reset_leads_back() -> None:
    loop = after_silence()
    loop.antenna.silent = True
    loop.run(5)
    kind = loop.host.memory.G[layout.STOP_KIND]
    loop.host.quick_stop()
    loop.run(5)
    assert "fault to quick stop (operator)" in loop.texts()
    assert loop.host.memory.G[layout.STOP_KIND] == kind
    loop.antenna = FakeAntenna()
    loop.run(500)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.OPERATOR)
    loop.command(hold(Mode.RATE)).run(20)
    assert loop.host.state is HostState.FAULT and loop.sent[-1].torque == (0, 0)
    loop.host.reset_fault()
    loop.run(500)
    assert loop.host.state is HostState.IDLE


def test_after_a_quick_stop_in_a_deadman_only_a_reset_leads_back() -> None:
    loop = in_drive_fault(active(), m.FAULT_CODE_DEADMAN).run(3)
    loop.host.quick_stop()
    loop.run(500)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.OPERATOR)


def test_after_lost_feedback_as_many_whole_sets_are_waited_for_as_for_a_connection() -> None:
    loop = after_silence(supervisor__connect_ticks=200).run(195)
    assert loop.host.state is HostState.FAULT
    loop.run(50)
    assert loop.host.state is HostState.IDLE


def test_after_lost_feedback_an_antenna_that_does_not_say_who_it_is_stays_without_torque() -> None:
    loop = after_silence()
    loop.antenna.says_who_it_is = False
    loop.run(500)
    assert loop.host.state is HostState.FAULT


@BRAKING
def test_a_drive_that_still_brakes_is_given_its_time_before_the_host_connects_again(drive_state: int) -> None:
    loop = stuck(after_silence(supervisor__stop_time_s=0.4), drive_state)
    loop.run(250)
    assert loop.host.state is HostState.FAULT
    loop.run(200)
    assert loop.host.state is HostState.SYNCHRONISING


def test_rest_is_judged_by_fresh_samples_only() -> None:
    loop = active(supervisor__lost_ticks=50, supervisor__rest_time_s=0.003)
    loop.antenna.silent = True
    loop.run(2)
    loop.host.stop()
    loop.run(20)
    assert loop.host.state is HostState.STOPPING
    loop.antenna.silent = False
    loop.run(20)
    assert loop.host.state is HostState.IDLE


def test_axes_that_rest_are_idle_after_as_many_samples_at_rest_as_configured() -> None:
    loop = active(supervisor__rest_time_s=0.005)
    loop.host.stop()
    loop.run(4)
    assert loop.host.state is HostState.STOPPING
    loop.run(1)
    assert loop.host.state is HostState.IDLE


def test_a_motion_that_is_under_way_may_be_replaced_and_one_that_is_being_stopped_may_not() -> None:
    loop = active().command(hold(Mode.RATE, 0.2, 0.2)).run(5)
    assert loop.host.state is HostState.ACTIVE and "segment 0 ended (replaced)" in loop.texts()
    loop.run(200)
    assert loop.antenna.rate[0] == pytest.approx(0.2, abs=0.02)
    loop.host.stop()
    loop.run(2)
    loop.command(hold(Mode.RATE, 0.2, 0.2)).run(1)
    assert loop.host.state is HostState.STOPPING and any("refused" in text for text in loop.texts()), loop.texts()
