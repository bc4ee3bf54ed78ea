"""A motion with a lease lasts as long as its client, in virtual time: what the control loop and the desk do."""

from __future__ import annotations

import json
from typing import Any, cast

import pytest

from gimbal_hil.loop.host import AxisCommand, Host, HostState, Mode, Segment, program_of
from gimbal_hil.loop.settings import host_configuration, shipped_settings
from gimbal_hil.loop.timing import Duration, Instant, LockstepClock, RingReader, RingWriter, Tick, create_ring
from gimbal_hil.realtime.daemon.antenna_link import embedded_antenna
from gimbal_hil.realtime.daemon.control_loop import ControlLoop, LoopTime
from gimbal_hil.realtime.daemon.heartbeat import Heartbeat
from gimbal_hil.realtime.daemon.lease import Lease
from gimbal_hil.realtime.daemon.link_keeper import LinkKeeper
from gimbal_hil.realtime.daemon.service_end import ServiceEnd
from gimbal_hil.realtime.operator import Client, OperatorSocket
from gimbal_hil.realtime.service.operator_desk import OperatorDesk
from gimbal_hil.realtime.service.recorder import Recorder
from gimbal_hil.realtime.telemetry import (
    COMMAND_BYTES,
    TELEMETRY_BYTES,
    CommandKind,
    Commands,
    LiveView,
    Telemetry,
    TelemetryKind,
    pack_motion_number,
    pack_program,
    take_commands,
)

Json = dict[str, Any]
PROGRAM = program_of([Segment(AxisCommand(Mode.RATE, parameters=(0.2,)), AxisCommand(Mode.RATE))])
LEASE_TICKS = 100


class Antenna:
    """The shipped antenna and its control loop, tick by tick; the first program has request number 1."""

    def __init__(self) -> None:
        settings, clock = shipped_settings(), LockstepClock()
        antenna = embedded_antenna(settings, settings.link)  # type: ignore[arg-type]
        orders, told = create_ring(COMMAND_BYTES), create_ring(TELEMETRY_BYTES)
        self.host = Host(host_configuration(settings))
        period = Duration.of_seconds(settings.step_s)
        link = LinkKeeper(clock, lambda: antenna, lambda opened, text: None)
        telemetry = Telemetry(RingWriter(told), lockstep=False)
        service = ServiceEnd(telemetry, RingReader(orders), lambda: True)
        loop = ControlLoop(self.host, link, service, LoopTime(clock, period))
        self._step, self._told, self._tick = loop.step, RingReader(told), 0
        self.commands = Commands(RingWriter(orders))
        self.run(50)
        assert self.host.state is HostState.IDLE

    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            self._step(Tick(self._tick, 0, 0, 0))
            self._tick += 1

    def begin(self, lease_ticks: int = LEASE_TICKS) -> int:
        number = self.commands.send(CommandKind.START, pack_program(PROGRAM, lease_ticks))
        assert number is not None
        self.run(30)
        assert self.host.state is HostState.ACTIVE
        return number

    def say(self, kind: CommandKind, motion: int) -> None:
        self.commands.send(kind, pack_motion_number(motion))

    def endings(self) -> list[str]:
        """Reasons of the leases that ended, as they stand in the log, each beside the stop that replay needs."""
        events = [json.loads(record.payload) for record in self._told.take() if record.kind == TelemetryKind.EVENT]
        told = [event for event in events if event["data"].get("code") == "lease_ended"]
        stops = {event["tick"] for event in events if event["data"] == {"command": "stop"}}
        assert {event["tick"] for event in told} <= stops
        return [event["data"]["reason"] for event in told]


def test_a_client_that_says_nothing_is_gone_after_its_ticks_and_the_axes_brake_to_rest() -> None:
    antenna = Antenna()
    antenna.begin()
    antenna.run(LEASE_TICKS - 32)
    assert antenna.host.state is HostState.ACTIVE
    antenna.run(4)
    assert antenna.host.state is HostState.STOPPING
    antenna.run(3000)
    assert antenna.host.state is HostState.IDLE
    assert antenna.endings() == ["said nothing for 0.1 s"]


def test_a_slow_client_is_not_a_dead_one() -> None:
    antenna = Antenna()
    motion = antenna.begin()
    for _ in range(20):
        antenna.run(LEASE_TICKS - 35)
        antenna.say(CommandKind.RENEW, motion)
    assert antenna.host.state is HostState.ACTIVE and antenna.endings() == []


def test_a_closed_connection_ends_the_motion_at_once() -> None:
    antenna = Antenna()
    antenna.say(CommandKind.CLIENT_GONE, antenna.begin())
    antenna.run(3)
    assert antenna.host.state is HostState.STOPPING and antenna.endings() == ["closed its connection"]


@pytest.mark.parametrize("kind", [CommandKind.CLIENT_GONE, CommandKind.RELEASE])
def test_a_client_whose_motion_was_replaced_has_no_say_in_the_next_one(kind: CommandKind) -> None:
    antenna = Antenna()
    before, after = antenna.begin(), antenna.begin()
    antenna.say(kind, before)
    antenna.run(20)
    assert antenna.host.state is HostState.ACTIVE
    antenna.run(LEASE_TICKS)
    assert after == before + 1 and antenna.endings() == ["said nothing for 0.1 s"]


@pytest.mark.parametrize("released", [True, False])
def test_a_motion_that_was_released_or_never_leased_outlives_its_client(released: bool) -> None:
    antenna = Antenna()
    motion = antenna.begin(LEASE_TICKS if released else 0)
    antenna.say(CommandKind.RELEASE if released else CommandKind.RENEW, motion)
    antenna.run(2)
    antenna.say(CommandKind.CLIENT_GONE, motion)
    antenna.run(10 * LEASE_TICKS)
    assert antenna.host.state is HostState.ACTIVE and antenna.endings() == []


def test_a_lease_that_ends_when_nothing_moves_is_no_event() -> None:
    antenna = Antenna()
    antenna.begin()
    antenna.commands.send(CommandKind.STOP)
    antenna.run(3000)
    assert antenna.host.state is HostState.IDLE and antenna.endings() == []


def test_ticks_that_were_skipped_do_not_count() -> None:
    lease = Lease(1, 3, 1_000_000)
    for _ in range(2):
        lease.pass_tick()
    assert lease.ended == ""
    lease.renew()
    lease.pass_tick()
    assert lease.ended == ""


class Told:
    """A door with one client, and what the desk has recorded."""

    def __init__(self) -> None:
        self.answers: list[Json] = []
        self.there = True

    def answer(self, _client: object, line: Json) -> None:
        self.answers.append(line)

    def has(self, _client: object) -> bool:
        return self.there

    def command(self, *told: Any) -> None:
        pass


class Desk:
    """The desk with its commands taken out as the control process would."""

    def __init__(self) -> None:
        ring = create_ring(COMMAND_BYTES)
        self.told, self._reader = Told(), RingReader(ring)
        commands = Commands(RingWriter(ring))
        self.desk = OperatorDesk(commands, cast(Recorder, self.told), LiveView(1_000_000), shipped_settings())
        self.desk.attach(cast(OperatorSocket, self.told))
        self.client = cast(Client, object())

    def ask(self, command: str, **fields: object) -> Json | None:
        return self.desk.handle(self.client, {"id": 1, "command": command, **fields})

    def begin(self, lease: bool = True) -> None:
        assert self.ask("set_point", mode="position", outer=0.1, lease=lease) is None
        (start,) = self.taken(CommandKind.START)
        self.desk.reply({"request": start, "tick": 5, "time_ns": 5, "problem": "", "not_ready": False})

    def taken(self, kind: CommandKind) -> list[int]:
        return [command.number for command in take_commands(self._reader) if command.kind is kind]


def test_the_desk_passes_renewals_on_without_an_answer_and_the_end_of_the_connection_once() -> None:
    desk = Desk()
    desk.begin()
    assert desk.told.answers == [{"id": 1, "ok": True, "tick": 5, "lease_s": 3.0}]
    assert desk.ask("renew") is None and len(desk.taken(CommandKind.RENEW)) == 1
    for _ in range(2):
        desk.desk.client_gone(desk.client)
    assert len(desk.taken(CommandKind.CLIENT_GONE)) == 1 and len(desk.told.answers) == 1


def test_a_client_that_is_gone_before_its_motion_begins_ends_it_all_the_same() -> None:
    desk = Desk()
    desk.told.there = False
    desk.begin()
    assert len(desk.taken(CommandKind.CLIENT_GONE)) == 1


def test_another_client_can_neither_renew_nor_release_a_motion() -> None:
    desk = Desk()
    desk.begin()
    own, desk.client = desk.client, cast(Client, object())
    assert desk.ask("renew") is None and desk.ask("release") == {"ok": True}
    assert desk.taken(CommandKind.RENEW) == desk.taken(CommandKind.RELEASE) == []
    desk.client = own
    assert desk.ask("release") == {"ok": True}
    assert len(desk.taken(CommandKind.RELEASE)) == 1


def test_without_a_lease_a_set_point_stays_when_its_connection_closes() -> None:
    desk = Desk()
    desk.begin(lease=False)
    desk.desk.client_gone(desk.client)
    assert desk.taken(CommandKind.CLIENT_GONE) == [] and desk.told.answers == [{"id": 1, "ok": True, "tick": 5}]


def test_a_service_counts_as_silent_only_from_the_first_look_on() -> None:
    progress = [0]
    heartbeat = Heartbeat(lambda: progress[0], Duration.of_seconds(5.0))
    # the witness took so long to wake that ticks begin late
    assert not heartbeat.missed(Instant(60_000_000_000))
    assert not heartbeat.missed(Instant(64_000_000_000))
    assert heartbeat.missed(Instant(65_000_000_000))


def test_a_lease_ends_once_and_keeps_its_reason() -> None:
    lease = Lease(1, 3, 1_000_000)
    lease.pass_tick()
    lease.client_gone()
    for _ in range(5):
        lease.pass_tick()
    assert lease.ended == "closed its connection"
