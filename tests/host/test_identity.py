"""Who answers on the link: no torque before it has said so, none for another than the one pinned, and its own units of
torque.
"""

from __future__ import annotations

import pytest

from firmware_protocol.schema import PROTOCOL_VERSION, name_code
from gimbal_hil.loop.host import EventCode, Host, HostCause, HostState, Mode
from gimbal_hil.loop.settings import host_configuration, settings_from_document, shipped_settings
from tests.host.fake_antenna import FakeAntenna
from tests.host.host_loop import HostLoop, configuration, hold


def _pinned(**antenna: object) -> Host:
    document = shipped_settings().model_dump(mode="json", by_alias=True) | {"antenna": antenna}
    return Host(host_configuration(settings_from_document(document, "test")))


def test_an_antenna_that_does_not_say_who_it_is_gets_no_torque() -> None:
    loop = HostLoop()
    loop.antenna.says_who_it_is = False
    loop.command(hold(Mode.TORQUE, 0.5)).run(500)
    assert loop.host.state is HostState.WAITING
    assert all(sent.torque == (0, 0) and sent.enable == (0, 0) for sent in loop.sent)
    loop.antenna.says_who_it_is = True
    loop.run(130)
    assert loop.host.state is HostState.IDLE


def test_the_log_tells_who_answered() -> None:
    loop = HostLoop().connected()
    told = [event for event in loop.events if event.code is EventCode.IDENTITY]
    assert [event.data for event in told] == [{"name_code": name_code("fake"), "serial_number": 7, "refusal": "none"}]


@pytest.mark.parametrize(
    ("pinned", "change", "refusal"),
    [
        ({"name": "fake", "serial_number": 7}, {}, None),
        ({"name": "another"}, {}, "name"),
        ({"serial_number": 8}, {}, "serial_number"),
        ({}, {"protocol_version": PROTOCOL_VERSION + 1}, "protocol"),
    ],
)
def test_only_the_antenna_that_is_pinned_and_speaks_this_protocol_gets_torque(
    pinned: dict[str, object], change: dict[str, int], refusal: str | None
) -> None:
    loop = HostLoop(host=_pinned(**pinned))
    for name, value in change.items():
        setattr(loop.antenna, name, value)
    loop.run(100)
    told = next(event for event in loop.events if event.code is EventCode.IDENTITY)
    if refusal is None:
        assert loop.host.state is HostState.IDLE
        return
    assert told.data["refusal"] == refusal and "refused" in told.text
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.WRONG_ANTENNA)
    assert all(sent.torque == (0, 0) and sent.enable == (0, 0) for sent in loop.sent)


@pytest.mark.parametrize(
    ("attribute", "value"),
    [
        ("serial_number", 9),
        ("name", "other"),
        ("protocol_version", PROTOCOL_VERSION + 1),
        ("torque_exponents", (1, 0)),
        ("torque_exponents", (0, 1)),
    ],
)
def test_another_antenna_on_the_same_line_is_noticed_although_the_link_never_fell_silent(
    attribute: str, value: object
) -> None:
    loop = HostLoop().connected().command(hold(Mode.TORQUE, 0.1)).run(20)
    stranger = loop.antenna
    # an antenna that is switched on says who it is without being asked
    stranger.introduce_unasked = True
    setattr(stranger, attribute, value)
    loop.run(3)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.WRONG_ANTENNA)


def test_an_antenna_that_says_again_who_it_is_goes_on() -> None:
    loop = HostLoop().connected().command(hold(Mode.TORQUE, 0.1)).run(20)
    loop.antenna.introduce_unasked = True
    loop.run(50)
    assert loop.host.state is HostState.ACTIVE
    told = [event for event in loop.events if event.code is EventCode.IDENTITY]
    assert len(told) == 1


def test_the_right_antenna_after_a_wrong_one_is_taken_once_it_has_said_who_it_is() -> None:
    loop = HostLoop(host=_pinned(serial_number=7))
    loop.antenna.serial_number = 8
    loop.run(100)
    assert loop.host.cause is HostCause.WRONG_ANTENNA
    loop.antenna.serial_number = 7
    loop.host.reset_fault()
    loop.run(100)
    assert loop.host.state is HostState.IDLE


def test_after_a_lost_link_whoever_returns_is_asked_again() -> None:
    loop = HostLoop(host=_pinned(serial_number=7)).connected()
    loop.antenna.silent = True
    loop.run(50)
    loop.antenna = FakeAntenna()
    loop.antenna.serial_number = 8
    loop.run(150)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.WRONG_ANTENNA)


def test_four_hundred_newton_metres_reach_an_antenna_whose_units_are_larger() -> None:
    host = Host(configuration(outer__limits__torque_nm=400.0))
    loop = HostLoop(host=host)
    loop.antenna.torque_exponents = (5, 0)
    loop.connected().command(hold(Mode.TORQUE, 380.0, 0.01)).run(5)
    assert loop.sent[-1].torque == (95000, 80)
    step_nm = 0.125e-3 * 32
    assert loop.host.status()["axes"]["outer"]["torque_nm"] == 95000 * step_nm == 380.0


def test_an_antenna_whose_frames_cannot_carry_the_configured_torque_is_refused() -> None:
    loop = HostLoop(host=Host(configuration(outer__limits__torque_nm=400.0))).run(60)
    assert (loop.host.state, loop.host.cause) == (HostState.FAULT, HostCause.WRONG_ANTENNA)
    assert any("torque_range" in text for text in loop.texts())
