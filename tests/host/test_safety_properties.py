"""What must hold whatever happens: torque only under control, never after lost feedback, limits always, no bytes that
raise.
"""

from __future__ import annotations

from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol import mail as m
from gimbal_hil.loop.host import (
    AxisCommand,
    Host,
    HostState,
    LinkStatus,
    Mode,
    ReferenceOrigin,
    Segment,
    Shape,
    program_of,
)
from tests.host.host_loop import HostLoop, configuration

TORQUE_LIMITS = (124000, 52800)
MODES = st.sampled_from([mode for mode in Mode if mode is not Mode.POINTING])
VALUES = st.floats(-20.0, 20.0)
COMMANDS = st.builds(
    lambda mode, value, origin: AxisCommand(mode, Shape.HOLD, (value,), origin),
    MODES,
    VALUES,
    st.sampled_from(list(ReferenceOrigin)),
)
ACTIONS = st.one_of(
    st.tuples(st.just("command"), COMMANDS, COMMANDS),
    st.tuples(
        st.sampled_from(
            ["stop", "quick_stop", "reset", "silence", "voice", "corrupt", "cut", "clean", "fault", "restart"]
        )
    ),
    st.tuples(st.just("load"), st.floats(-10.0, 10.0), st.floats(-5.0, 5.0)),
    st.tuples(st.just("gyro"), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)),
    st.tuples(st.just("base"), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
    st.tuples(st.just("skip"), st.integers(1, 300)),
)


def corrupted(random: Random) -> object:
    """Bytes changed, dropped and doubled at random."""

    def mangle(block: bytes) -> bytes:
        octets = bytearray(block)
        for _ in range(random.randrange(4)):
            if octets:
                octets[random.randrange(len(octets))] ^= 1 << random.randrange(8)
        return bytes(octets * random.choice((1, 1, 1, 2)))[: random.randrange(80)]

    return mangle


def act(loop: HostLoop, action: tuple[object, ...], random: Random) -> None:
    """One thing that happens to host or antenna."""
    host, antenna = loop.host, loop.antenna
    match action:
        case ("command", AxisCommand() as outer, AxisCommand() as inner):
            host.command(program_of([Segment(outer, inner, random.choice((0, 50)))]))
        case ("stop",):
            host.stop()
        case ("quick_stop",):
            host.quick_stop()
        case ("reset",):
            host.reset_fault()
        case ("silence",):
            antenna.silent = True
        case ("voice",):
            antenna.silent = False
        case ("corrupt",):
            loop.mangle = corrupted(random)  # type: ignore[assignment]
        case ("cut",):
            loop.mangle = lambda block: block[:25]
        case ("clean",):
            loop.mangle = lambda block: block
        case ("fault",):
            antenna.drive_state, antenna.fault = m.DRIVE_STATE_FAULT, random.randrange(10)
        case ("restart",):
            antenna.drive_state = m.DRIVE_STATE_NOT_READY if random.random() < 0.3 else m.DRIVE_STATE_SWITCH_ON_DISABLED
        case ("load", float() as outer_load, float() as inner_load):
            antenna.load[:] = [outer_load, inner_load]
        case ("gyro", float() as outer_error, float() as inner_error):
            antenna.gyro_error[:] = [outer_error, inner_error]
        case ("base", float() as p, float() as r):
            antenna.base_rate[:] = [p, 0.0, r]
        case ("skip", int() as ticks):
            loop.number += ticks


@settings(max_examples=60)
@given(st.lists(st.tuples(ACTIONS, st.integers(1, 120)), max_size=12), st.integers(0, 2**31))
def test_torque_is_sent_only_while_active_or_stopping_within_limits_and_with_feedback(
    story: list[tuple[tuple[object, ...], int]], seed: int
) -> None:
    loop, random = HostLoop().connected(), Random(seed)
    for action, ticks in story:
        act(loop, action, random)
        for _ in range(ticks):
            loop.run(1)
            sent = loop.sent[-1]
            if sent.state not in (HostState.ACTIVE, HostState.STOPPING) or loop.host.link_status is LinkStatus.LOST:
                assert sent.torque == (0, 0)
            assert all(abs(torque) <= limit for torque, limit in zip(sent.torque, TORQUE_LIMITS, strict=True))
            assert all(enable or not torque for torque, enable in zip(sent.torque, sent.enable, strict=True))


@given(st.lists(st.binary(max_size=200), max_size=30), st.integers(0, 2**40))
def test_no_bytes_raise_or_bring_torque(blocks: list[bytes], first: int) -> None:
    host = Host(configuration())
    host.command(program_of([Segment(AxisCommand(Mode.TORQUE, Shape.HOLD, (5.0,)), AxisCommand())]))
    for number, block in enumerate(blocks):
        set_point = host.tick(first + number, 0, block)[-10:]
        assert set_point[:6] == b"\x20\x00\x00\x00\x00\x00"
        assert host.state in (HostState.WAITING, HostState.SYNCHRONISING)


def test_a_flood_of_bytes_is_cut_to_the_newest() -> None:
    loop = HostLoop().connected()
    loop.mangle = lambda block: bytes(200_000) + block
    loop.run(100)
    assert loop.host.state is HostState.IDLE
    assert loop.host.link_status is LinkStatus.OK


@settings(max_examples=25)
@given(st.lists(st.tuples(ACTIONS, st.integers(1, 60)), max_size=8), st.integers(0, 2**31))
def test_the_same_calls_bring_the_same_bytes_and_rows(story: list[tuple[tuple[object, ...], int]], seed: int) -> None:
    loop, random = HostLoop(), Random(seed)
    loop.run(30)
    calls: list[tuple[int, tuple[object, ...]]] = []
    for action, ticks in story:
        calls.append((len(loop.blocks), action))
        act(loop, action, random)
        loop.run(ticks)
    again, replayed, random = Host(configuration()), HostLoop(), Random(seed)
    replayed.host = again
    place = 0
    for index, ((received, sent), record) in enumerate(zip(loop.blocks, loop.sent, strict=True)):
        while place < len(calls) and calls[place][0] == index:
            act(replayed, calls[place][1], random)
            place += 1
        assert again.tick(record.tick, record.tick * 1_000_000, received) == sent
    assert again.row == loop.host.row
