"""Following programs: no bump, no gap, stopping, replacing, and what comes after the end."""

from __future__ import annotations

import itertools

import pytest

from gimbal_hil.loop.host import AxisCommand, HostState, Mode, ReferenceOrigin, Segment, Shape, layout, program_of
from tests.host.host_loop import HostLoop, hold


def here(mode: Mode) -> AxisCommand:
    """Hold what there is."""
    return AxisCommand(mode, Shape.HOLD, (0.0,), ReferenceOrigin.START)


@pytest.mark.parametrize("mode", [Mode.POSITION, Mode.RATE, Mode.INERTIAL_RATE])
def test_enabling_where_the_axes_are_brings_no_torque(mode: Mode) -> None:
    loop = HostLoop()
    loop.antenna.position[:] = [0.7, -0.3]
    loop.antenna.rate[:] = [0.4, -0.2]
    loop.connected().command(Segment(here(mode), here(mode))).run(1)
    assert loop.host.state is HostState.ACTIVE
    assert max(map(abs, loop.sent[-1].torque)) <= 1


def test_changing_the_mode_keeps_the_torque() -> None:
    loop = HostLoop().connected()
    loop.antenna.load[:] = [2.0, -1.0]
    loop.command(Segment(here(Mode.POSITION), here(Mode.POSITION))).run(3000)
    before = loop.sent[-1].torque
    assert abs(before[0] + 16000) < 200
    loop.command(Segment(here(Mode.RATE), here(Mode.INERTIAL_RATE))).run(1)
    assert all(abs(a - b) < 80 for a, b in zip(before, loop.sent[-1].torque, strict=True))


def test_segments_follow_one_another_without_a_tick_between() -> None:
    loop = (
        HostLoop()
        .connected()
        .command(*(hold(Mode.RATE, 0.1, duration_ticks=50, label=k) for k in range(1, 4)))
        .run(200)
    )
    started = [event.tick for event in loop.events if event.text.endswith("started")]
    ended = [event.tick for event in loop.events if "ended" in event.text]
    assert [b - a for a, b in itertools.pairwise(started)] == [50, 50]
    assert [s + 49 for s in started] == ended


def test_after_the_end_a_position_is_held_and_a_rate_becomes_zero() -> None:
    loop = HostLoop().connected()
    segment = Segment(
        AxisCommand(Mode.RATE, Shape.HOLD, (0.5,)), AxisCommand(Mode.POSITION, Shape.RAMP, (0.0, 0.2, 10.0)), 1000
    )
    loop.command(segment).run(3000)
    assert loop.host.state is HostState.ACTIVE
    assert not loop.host.following
    assert abs(loop.antenna.rate[0]) < 1e-3
    assert loop.antenna.position[1] == pytest.approx(0.1998, abs=2e-3)


def test_a_stop_brakes_to_rest_and_switches_off() -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE, 2.0, 1.0)).run(500)
    loop.host.stop()
    loop.run(1)
    assert loop.host.state is HostState.STOPPING
    loop.run(600)
    assert loop.host.state is HostState.IDLE
    assert max(map(abs, loop.antenna.rate)) < 0.03
    assert loop.sent[-1].enable == (0, 0)


def test_a_stop_works_in_torque_mode_and_while_feedback_is_late() -> None:
    loop = HostLoop().connected().command(hold(Mode.TORQUE, 3.0)).run(200)
    loop.antenna.silent = True
    loop.run(2)
    loop.host.stop()
    loop.run(1)
    loop.antenna.silent = False
    loop.run(1000)
    assert loop.host.state is HostState.IDLE
    assert abs(loop.antenna.rate[0]) < 0.03


def test_a_new_program_replaces_the_one_in_force() -> None:
    loop = HostLoop().connected().command(hold(Mode.POSITION, 0.2, label=1)).run(100)
    loop.command(hold(Mode.POSITION, 0.3, label=2)).run(2000)
    assert "segment 1 ended (replaced)" in loop.texts()
    assert loop.antenna.position[0] == pytest.approx(0.3, abs=2e-3)


def test_a_command_without_an_antenna_is_refused_and_reported() -> None:
    loop = HostLoop()
    loop.antenna.silent = True
    loop.run(5).command(hold(Mode.TORQUE, 1.0)).run(5)
    assert "command refused in state waiting" in loop.texts()
    assert all(sent.torque == (0, 0) for sent in loop.sent)


def test_skipped_ticks_move_the_reference_on_and_are_in_the_row() -> None:
    loop = (
        HostLoop()
        .connected()
        .command(Segment(AxisCommand(Mode.POSITION, Shape.RAMP, (0.0, 0.1, 10.0)), AxisCommand()))
        .run(100)
    )
    loop.number += 37
    loop.run(1)
    reference = loop.host.memory.H[layout.axis_h(0) + layout.REFERENCE]
    assert reference == pytest.approx(0.1 * (100 + 37) * 1e-3)
    assert int.from_bytes(loop.host.row[68:72], "little") == 37


def test_a_stall_of_the_host_is_no_disagreement_of_gyro_and_encoder() -> None:
    loop = HostLoop().connected().command(hold(Mode.RATE, 1.0)).run(500)
    loop.number += 200
    for _ in range(200):
        loop.answer = loop.antenna.tick(b"")
    loop.run(100)
    assert loop.host.state is HostState.ACTIVE


def test_a_joint_rate_is_held_on_a_moving_base() -> None:
    loop = HostLoop().connected()
    loop.antenna.base_rate = [0.2, 0.3, 0.4]
    loop.run(20).command(hold(Mode.RATE, 0.1, 0.1)).run(2000)
    assert loop.antenna.rate[0] == pytest.approx(0.1, abs=5e-3)
    assert loop.antenna.rate[1] == pytest.approx(0.1, abs=5e-3)


def test_an_inertial_rate_is_held_against_the_base() -> None:
    loop = HostLoop().connected()
    loop.antenna.base_rate = [0.2, 0.3, 0.4]
    loop.run(20).command(hold(Mode.INERTIAL_RATE)).run(1500)
    assert loop.antenna.rate[0] == pytest.approx(-0.4, abs=5e-3)


def test_many_segments_leave_all_their_events() -> None:
    loop = HostLoop().connected()
    loop.host.command(program_of([hold(Mode.RATE, duration_ticks=1, label=k) for k in range(300)]))
    loop.run(310)
    assert [f"segment {k} started" for k in range(300)] == [text for text in loop.texts() if text.endswith("started")]
