"""Whoever is refused a motion is told what ends the state that refuses it."""

from __future__ import annotations

from gimbal_hil.realtime.daemon.refusing import why_not_now
from tests.host.host_loop import HostLoop


def test_a_fault_names_the_command_that_leaves_it_and_its_cause() -> None:
    loop = HostLoop().connected()
    loop.host.quick_stop()
    loop.run(3)
    said = why_not_now(loop.host)
    assert "fault" in said and "`gimbal-hil reset`" in said and "operator" in said


def test_before_an_antenna_answers_there_is_nothing_to_reset() -> None:
    said = why_not_now(HostLoop().host)
    assert "once the antenna answers" in said and "reset" not in said
