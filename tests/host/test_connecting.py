"""Connecting: waiting for an antenna, its drive states, the deadman, loss and return."""

from __future__ import annotations

import pytest

from firmware_protocol import mail as m
from gimbal_hil.loop.host import Host, HostCause, HostState, LinkStatus, Mode
from tests.host.fake_antenna import FakeAntenna
from tests.host.host_loop import HostLoop, configuration, hold


def test_a_host_without_an_antenna_waits_with_torque_off_and_goes_on_sending() -> None:
    loop = HostLoop()
    loop.antenna.silent = True
    loop.run(500)
    assert loop.host.state is HostState.WAITING
    assert loop.host.link_status is LinkStatus.LOST
    assert all(block for _, block in loop.blocks)
    assert all(sent.torque == (0, 0) and sent.enable == (0, 0) for sent in loop.sent)


def test_the_drive_is_taken_to_operation_enabled_and_told_its_deadman() -> None:
    loop = HostLoop().connected()
    assert loop.antenna.drive_state == m.DRIVE_STATE_OPERATION_ENABLED
    assert loop.antenna.deadman and set(loop.antenna.deadman) == {(20, m.STOP_REACTION_DECELERATE_AND_HOLD)}


def test_drive_control_comes_on_change_and_ten_times_a_second() -> None:
    loop = HostLoop().connected()
    before = len(loop.antenna.requests)
    loop.run(1000)
    assert len(loop.antenna.requests) - before == 10


def test_lost_feedback_switches_torque_off_after_the_configured_ticks_and_faults() -> None:
    loop = HostLoop().connected().command(hold(Mode.TORQUE, 0.5, 0.2)).run(20)
    assert loop.sent[-1].torque == (4000, 1600)
    loop.antenna.silent = True
    loop.run(1)
    silent_from = loop.number
    loop.run(5)
    assert [sent.torque for sent in loop.sent[silent_from:]] == [(4000, 1600)] * 5
    loop.run(200)
    assert loop.host.state is HostState.FAULT
    assert loop.host.cause is HostCause.FEEDBACK_LOST
    assert all(sent.torque == (0, 0) and sent.enable == (0, 0) for sent in loop.sent[silent_from + 5 :])


def test_an_antenna_that_returns_is_connected_again_and_stays_without_torque() -> None:
    loop = HostLoop().connected().command(hold(Mode.TORQUE, 0.5)).run(20)
    loop.antenna.silent = True
    loop.run(100)
    restarted = FakeAntenna()
    loop.antenna = restarted
    lost_at = loop.number
    loop.run(100)
    assert loop.host.state is HostState.IDLE
    assert restarted.drive_state == m.DRIVE_STATE_OPERATION_ENABLED
    assert all(sent.torque == (0, 0) for sent in loop.sent[lost_at:])


def test_without_automatic_reconnect_the_fault_waits_for_the_operator() -> None:
    loop = HostLoop(Host(configuration(supervisor__automatic_reconnect=False))).connected()
    loop.antenna.silent = True
    loop.run(50)
    loop.antenna.silent = False
    loop.run(10000)
    assert loop.host.state is HostState.FAULT
    loop.host.reset_fault()
    loop.run(100)
    assert loop.host.state is HostState.IDLE


@pytest.mark.parametrize(
    ("fault", "state"),
    [
        (m.FAULT_CODE_DEADMAN, HostState.IDLE),
        (m.FAULT_CODE_COMMUNICATION, HostState.IDLE),
        (m.FAULT_CODE_NONE, HostState.IDLE),
        (m.FAULT_CODE_OVERTEMPERATURE, HostState.FAULT),
    ],
)
def test_only_what_a_lost_link_leaves_behind_is_reset_without_being_asked(fault: int, state: HostState) -> None:
    loop = HostLoop()
    loop.antenna.drive_state, loop.antenna.fault = m.DRIVE_STATE_FAULT, fault
    loop.run(300)
    assert loop.host.state is state
    loop.host.reset_fault()
    loop.run(300)
    assert loop.host.state is HostState.IDLE


def test_a_drive_fault_ends_the_motion() -> None:
    loop = HostLoop().connected().command(hold(Mode.TORQUE, 0.5)).run(20)
    loop.antenna.drive_state, loop.antenna.fault = m.DRIVE_STATE_FAULT, m.FAULT_CODE_OVERSPEED
    loop.run(2)
    assert loop.host.state is HostState.FAULT
    assert loop.host.cause is HostCause.DRIVE_FAULT
    assert loop.sent[-1].torque == (0, 0)
    assert "segment 0 ended (drive_fault)" in loop.texts()


def test_half_a_feedback_set_is_no_feedback() -> None:
    loop = HostLoop().connected()
    loop.mangle = lambda block: block[:10]
    loop.run(10)
    assert loop.host.link_status is LinkStatus.LOST


def test_a_synchronisation_that_takes_too_long_is_a_fault() -> None:
    loop = HostLoop(Host(configuration(supervisor__synchronise_time_s=0.2)))
    loop.antenna.drive_state = m.DRIVE_STATE_NOT_READY
    loop.run(300)
    assert loop.host.state is HostState.FAULT
    assert loop.host.cause is HostCause.SYNCHRONISATION_TIMEOUT
