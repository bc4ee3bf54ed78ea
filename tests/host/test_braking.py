"""Braking distance counts on what torque limit, disturbance and weight leave, and a torque that leaves nothing is
refused; what holds an axis by its brake beside one that moves.
"""

from __future__ import annotations

import numpy as np
import pytest

from firmware_protocol import mail as m
from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.control.layout import TORQUE_LIMIT
from gimbal_hil.loop.host import UNNAMED, AxisCommand, Host, HostState, Mode, Segment, Shape, layout, limits
from gimbal_hil.loop.settings import (
    DaemonSettings,
    adjusted,
    host_configuration,
    require_braking,
    settings_from_document,
    shipped_settings,
)
from tests.host.host_loop import HostLoop, configuration, hold

H_OF, C_OF = (
    (layout.AXIS_H, layout.AXIS_H + layout.AXIS_H_SIZE),
    (layout.AXIS_C, layout.AXIS_C + layout.AXIS_C_SIZE),
)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("load_nm", [0.0, 1.4])
def test_an_axis_whose_torque_was_lowered_stops_before_its_limit(sign: float, load_nm: float) -> None:
    travel = {"outer__limits__position_low_rad": -2.0, "outer__limits__position_high_rad": 2.0}
    loop = HostLoop(Host(configuration(outer__limits__torque_nm=2.5, **travel)))
    loop.connected().command(hold(Mode.RATE, sign)).run(700)
    assert loop.host.state is HostState.ACTIVE
    # what the expectation allows for pulls it on while it brakes
    loop.antenna.load[0] = sign * load_nm
    while loop.host.state is not HostState.IDLE and loop.number < 4000:
        loop.run(10)
    # nothing holds this antenna once it is at rest
    assert "segment 0 ended (travel)" in loop.texts()
    assert 1.5 < sign * loop.antenna.position[0] <= 2.0


def test_a_position_near_a_limit_is_reached_with_little_torque_and_without_a_stop() -> None:
    # without friction that the loops do not know of, it comes to rest at the limit as with all its torque
    loop = HostLoop(Host(configuration(inner__limits__torque_nm=1.6))).connected()
    loop.command(hold(Mode.POSITION, 0.0, 1.95)).run(9000)
    assert loop.host.state is HostState.ACTIVE, loop.texts()
    assert loop.antenna.position[1] == pytest.approx(1.95, abs=0.01)


@pytest.mark.parametrize(
    ("torque_nm", "pull_nm", "expected"),
    [(6.6, 0.0, 30.0), (2.4, 0.0, 20.0), (2.4, 0.7, 10.0), (1.0, 0.5, 1.5), (0.5, 0.0, 1.5)],
)
def test_the_weight_and_the_disturbance_are_taken_off_the_torque(
    torque_nm: float, pull_nm: float, expected: float
) -> None:
    C, H = configuration(), np.zeros(layout.H_SIZE)
    C[C_OF[1] + TORQUE_LIMIT], H[H_OF[1] + layout.PULL] = torque_nm, pull_nm
    assert limits.braking(H, C, H_OF[1], C_OF[1]) == pytest.approx(expected)
    C[C_OF[1] + layout.EXPECTED_INERTIA] = 0.0
    assert limits.braking(H, C, H_OF[1], C_OF[1]) == 30.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_weight_is_that_of_the_body_where_it_stands_whichever_way_it_pulls(
    side: float,
) -> None:
    C = configuration(inner__expectation__moment_kg_m=[side * 0.05, 0.0, 0.0])
    loop = HostLoop(Host(C)).connected().command(hold(Mode.POSITION)).run(20)
    assert loop.host.memory.H[H_OF[1] + layout.PULL] == pytest.approx(0.05 * 9.81, rel=1e-3)
    loop.antenna.position[1] = 1.2
    loop = HostLoop(Host(C))
    loop.antenna.position[1] = 1.2
    loop.connected().command(hold(Mode.POSITION, 0.0, 1.2)).run(20)
    assert loop.host.memory.H[H_OF[1] + layout.PULL] == pytest.approx(0.05 * 9.81 * np.cos(1.2), rel=1e-2)


@pytest.mark.parametrize(
    ("axis", "torque_nm", "least"), [("inner", 2.0, "2.21"), ("outer", 1.8, "1.88"), ("inner", 1.0, "2.21")]
)
def test_a_torque_that_leaves_nothing_to_brake_with_is_refused_with_the_reason(
    axis: str, torque_nm: float, least: str
) -> None:
    changes = {axis: {"limits.torque_nm": torque_nm}}
    settings = adjusted(shipped_settings(), changes)
    with pytest.raises(
        BadInputError, match=rf"{axis}\.limits\.torque_nm.*nothing to brake {axis}.*expected at least {least}"
    ):
        require_braking(settings, changes)
    # another number of the same axis is none of its business
    require_braking(settings, {axis: {"rate_loop.ki_per_rad": 800.0}})
    enough = {axis: {"limits.torque_nm": float(least) + 0.01}}
    require_braking(adjusted(shipped_settings(), enough), enough)


def test_without_an_expectation_an_axis_brakes_by_as_much_less_as_it_has_torque() -> None:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    document["axes"]["outer"]["expectation"] = None
    settings: DaemonSettings = settings_from_document(document, "test")
    for torque_nm, expected in ((7.75, 7.5), (15.5, 15.0)):
        C = host_configuration(adjusted(settings, {"outer": {"limits.torque_nm": torque_nm}}))
        assert C[C_OF[0] + layout.BRAKING_RAD_S2] == pytest.approx(expected)


def test_the_brake_of_an_axis_that_is_not_named_is_closed_while_the_other_one_moves_or_stops_and_no_longer() -> None:
    C = configuration(supervisor__unnamed_axis="brake")
    moving = AxisCommand(Mode.RATE, Shape.HOLD, (0.5,))
    for axis, slot in ((1, m.DRIVE_CONTROL_BRAKE_INNER), (0, m.DRIVE_CONTROL_BRAKE_OUTER)):
        loop = HostLoop(Host(C)).connected()
        told = _brake_commands(loop, slot)
        loop.command(Segment(moving, UNNAMED) if axis == 1 else Segment(UNNAMED, moving)).run(150)
        assert told[-1] == m.BRAKE_COMMAND_ENGAGE
        loop.host.stop()
        while loop.run(1).host.state is not HostState.IDLE:
            assert told[-1] == m.BRAKE_COMMAND_ENGAGE
        loop.run(150)
        assert told[-1] == m.BRAKE_COMMAND_AUTOMATIC
        # and never for one that is off because somebody said so
        told.clear()
        loop.command(Segment(moving, AxisCommand()) if axis == 1 else Segment(AxisCommand(), moving)).run(150)
        assert loop.host.state is HostState.ACTIVE and set(told) == {m.BRAKE_COMMAND_AUTOMATIC}


def _brake_commands(loop: HostLoop, slot: int) -> list[int]:
    """What the antenna is told of a brake, as it is told."""
    told: list[int] = []
    obey = loop.antenna._obey

    def listening() -> None:
        mail = loop.antenna._mail
        if mail[m.DRIVE_CONTROL] > 0:
            told.append(int(mail[slot]))
        obey()

    loop.antenna._obey = listening  # type: ignore[method-assign]
    return told
