"""A request that the control process takes too late: no motion, and nothing that the record does not know of."""

from __future__ import annotations

import json
import time
from typing import Any, cast

import numpy as np
import pytest

from gimbal_hil.loop.host import AxisCommand, FirstTest, Host, HostState, Mode, Segment, program_of
from gimbal_hil.loop.settings import host_configuration, shipped_settings
from gimbal_hil.loop.timing import NS_PER_S, Duration, LockstepClock, RingReader, RingWriter, TickEngine, create_ring
from gimbal_hil.realtime.daemon.antenna_link import embedded_antenna
from gimbal_hil.realtime.daemon.control_loop import ControlLoop, LoopTime
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
    pack_configuration,
    pack_program,
)

pytestmark = pytest.mark.realtime

Json = dict[str, Any]
PROGRAM = program_of([Segment(AxisCommand(Mode.TORQUE, parameters=(0.1,)), AxisCommand())])


class Told:
    """Takes what a desk answers and has recorded."""

    def __init__(self) -> None:
        self.answers: list[Json] = []
        self.commands: list[tuple[Any, ...]] = []

    def answer(self, _client: object, line: Json) -> None:
        self.answers.append(line)

    def command(self, *told: Any) -> None:
        self.commands.append(told)


START = (CommandKind.START, pack_program(PROGRAM))
ADJUST = (CommandKind.ADJUST, pack_configuration(2.0 * host_configuration(shipped_settings())))


def looped(tries_first: bool = False) -> tuple[Host, TickEngine, int, int]:
    """A control loop on the embedded antenna, its engine, and the rings of its orders and of what it tells."""
    settings, clock = shipped_settings(), LockstepClock()
    antenna = embedded_antenna(settings, settings.link)  # type: ignore[arg-type]
    orders, told = create_ring(COMMAND_BYTES), create_ring(TELEMETRY_BYTES)
    host, telemetry = Host(host_configuration(settings)), Telemetry(RingWriter(told), lockstep=False)
    period, link = Duration.of_seconds(settings.step_s), LinkKeeper(clock, lambda: antenna, lambda opened, text: None)
    service = ServiceEnd(telemetry, RingReader(orders), lambda: True)
    first = FirstTest(host, settings.step_s) if tries_first else None
    loop = ControlLoop(host, link, service, LoopTime(clock, period), first_test=first)
    return host, TickEngine(clock, period, loop.step), orders, told


def problems(told: int) -> list[str]:
    """What became of the requests that were answered."""
    return [json.loads(r.payload)["problem"] for r in RingReader(told).take() if r.kind == TelemetryKind.REPLY]


@pytest.mark.parametrize(
    ("request_", "age_s", "state"),
    [(START, 1.0, HostState.ACTIVE), (START, 3.5, HostState.IDLE), (ADJUST, 3.5, HostState.IDLE)],
)
def test_a_motion_begins_and_a_gain_changes_only_while_the_caller_still_waits(
    request_: tuple[CommandKind, bytes], age_s: float, state: HostState, monkeypatch: pytest.MonkeyPatch
) -> None:
    host, engine, orders, told = looped()
    engine.run(50)
    assert host.state is HostState.IDLE
    asked_ns = time.monotonic_ns()
    before = host.memory.C.copy()
    Commands(RingWriter(orders)).send(*request_)
    monkeypatch.setattr(time, "monotonic_ns", lambda: round(asked_ns + age_s * NS_PER_S))
    engine.run(3)
    assert host.state is state
    assert [bool(problem) for problem in problems(told)] == [state is HostState.IDLE]
    np.testing.assert_array_equal(host.memory.C, before)


def test_a_request_before_the_antenna_answers_is_told_so_and_not_that_the_antenna_is_being_tried() -> None:
    host, engine, orders, told = looped(tries_first=True)
    engine.run(1)
    assert host.state in (HostState.WAITING, HostState.SYNCHRONISING)
    Commands(RingWriter(orders)).send(*START)
    engine.run(3)
    (problem,) = problems(told)
    assert "which passes once the antenna answers" in problem


def test_a_motion_that_began_late_is_recorded_although_its_caller_was_told_no(monkeypatch: pytest.MonkeyPatch) -> None:
    seen, now = Told(), [100.0]
    commands = Commands(RingWriter(create_ring(COMMAND_BYTES)))
    view, settings = LiveView(1_000_000), shipped_settings()
    desk = OperatorDesk(commands, cast(Recorder, seen), view, settings)
    desk.attach(cast(OperatorSocket, seen))
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    line = {"id": 7, "command": "set_point", "mode": "position", "outer": 0.1, "inner": 0.0}
    assert desk.handle(cast(Client, None), line) is None
    now[0] += 4.0
    desk.give_up()
    assert [(answer["ok"], answer["not_ready"]) for answer in seen.answers] == [(False, True)]
    view.ticks = 1
    assert desk.handle(cast(Client, None), {**line, "id": 8}) is None
    now[0] += 4.0
    desk.give_up()
    assert [(answer["ok"], answer["not_ready"]) for answer in seen.answers[1:]] == [(False, False)]
    desk.reply({"request": 1, "tick": 5, "time_ns": 5, "problem": "", "not_ready": False})
    desk.reply({"request": 2, "tick": 5, "time_ns": 5, "problem": "the request is too old", "not_ready": False})
    assert [told[0] for told in seen.commands] == [5] and len(seen.answers) == 2
