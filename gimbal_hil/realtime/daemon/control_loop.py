"""One tick of the control process: take frames, let the host decide, send, and only then tell the rest of the world."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from firmware_protocol.enumerations import DriveState
from firmware_protocol.errors import EXIT_DONE, EXIT_INTERRUPTED, EXIT_NO, EXIT_SAFETY_STOP
from firmware_protocol.json_object import Json
from gimbal_hil.loop.host import (
    AXES,
    BASE_RATE,
    DRIVE_STATE,
    FIRST_TEST,
    IMAGE_WORDS,
    MEASURED_RATE,
    REST_RATE,
    EventCode,
    FirstTest,
    FirstTestState,
    Host,
    HostCause,
    HostEvent,
    HostState,
    LinkStatus,
    Program,
    axis_c,
    axis_h,
    image_of,
    word_of,
)
from gimbal_hil.loop.timing import Clock, Duration, Miss, MissCause, Tick
from gimbal_hil.realtime.daemon.lease import Lease
from gimbal_hil.realtime.daemon.link_keeper import LinkKeeper
from gimbal_hil.realtime.daemon.refusing import why_not_adjusted, why_not_now
from gimbal_hil.realtime.daemon.service_end import ServiceEnd
from gimbal_hil.realtime.telemetry import (
    Command,
    CommandKind,
    lease_ticks_of,
    take_commands,
    unpack_configuration,
    unpack_motion_number,
    unpack_program,
)

_EVENT_KIND = {
    EventCode.STATE: "state",
    EventCode.SEGMENT_STARTED: "segment",
    EventCode.SEGMENT_ENDED: "segment",
    EventCode.COMMAND_REFUSED: "note",
    EventCode.LINK: "link",
    EventCode.DRIVE: "drive",
    EventCode.TRIPPED: "fault",
    EventCode.BASE: "link",
    EventCode.IDENTITY: "link",
    EventCode.BEYOND_LIMIT: "note",
    EventCode.MODEL: "note",
    EventCode.FRICTION_LEVELS: "note",
    EventCode.POINTING: "state",
}
_OPERATOR = word_of(HostCause.OPERATOR)
#: both ends call it the same: the host's state and the drive's
_FAULTS = (word_of(HostState.FAULT), word_of(DriveState.FAULT))
#: how often the service process is asked whether it lives
_SERVICE_CHECK = Duration(20_000_000)
#: after a stop the drive is given this long to come to rest and switch off before the process ends
_LEAVE_TIMEOUT = Duration(3_000_000_000)

#: before the antenna has answered
_CONNECTING = (HostState.WAITING, HostState.SYNCHRONISING)
_STARTS = (CommandKind.START, CommandKind.START_WITH_IMAGE)
#: commands without parameters that go straight to the host, as the log calls them
_PLAIN: dict[CommandKind, tuple[str, Callable[[Host], None]]] = {
    CommandKind.STOP: ("stop", Host.stop),
    CommandKind.QUICK_STOP: ("quick_stop", Host.quick_stop),
    CommandKind.FAULT_RESET: ("fault_reset", Host.reset_fault),
}
_OF_A_LEASE = (CommandKind.RENEW, CommandKind.RELEASE, CommandKind.CLIENT_GONE)


class Stopping(Enum):
    """How far the loop is on its way out."""

    NOT = "not"
    BRAKING = "braking"  # the host brings the axes to rest under control
    SWITCHING_OFF = "switching_off"  # torque is off, the drive goes through its quick stop


@dataclass(frozen=True, slots=True)
class LoopEnd:
    """Why the loop ends and what the command answers."""

    exit_code: int
    reason: str


@dataclass(frozen=True, slots=True)
class LoopTime:
    """What the loop's time goes by: the clock, the period of a tick, and how many ticks it runs; None: for ever."""

    clock: Clock
    period: Duration
    ticks: int | None = None


class ControlLoop:
    """The step that the tick engine calls. Nothing in it waits for anybody."""

    def __init__(
        self,
        host: Host,
        link: LinkKeeper,
        service: ServiceEnd,
        time: LoopTime,
        pass_over: Callable[[int], None] | None = None,
        first_test: FirstTest | None = None,
    ) -> None:
        """`pass_over(periods)` is called when ticks were skipped: a virtual antenna in this process has to go on
        meanwhile.
        """
        period = time.period
        self._host = host
        self._link = link
        self._service = service
        self._telemetry = service.telemetry
        self._commands = service.commands
        self._clock = time.clock
        self._period_ns = period.ns
        self._last_tick = sys.maxsize if time.ticks is None else time.ticks
        self._pass_over = pass_over
        self._first_test = first_test
        self._service_check_ticks = max(1, _SERVICE_CHECK // period)
        self._leave_ticks = max(1, _LEAVE_TIMEOUT // period)
        self._tick = 0
        self._due: list[Command] = []
        #: of the motion that the host follows, where its client has to stay
        self._lease: Lease | None = None
        self._service_gone = False
        #: the drives' own words for what is wrong with them
        self._complaint = ""
        self._asked: LoopEnd | None = None
        self._stopping = Stopping.NOT
        self._stopping_since = 0
        self._leaving = LoopEnd(EXIT_DONE, "")
        self.ending: LoopEnd | None = None
        if first_test is not None and first_test.state is FirstTestState.DUE:
            self._tell_first_test("the antenna is tried with a small torque before its first motion", first_test)

    def interrupt(self, reason: str) -> None:
        """Called by signal handlers: torque off with the next tick, then out. A second call leaves after that tick."""
        if self._asked is not None and self._asked.exit_code == EXIT_INTERRUPTED:
            self.ending = self._asked
        self._asked = LoopEnd(EXIT_INTERRUPTED, reason)

    def step(self, tick: Tick) -> bool:
        """One tick; False when the loop is done."""
        self._tick = tick.number
        time_ns = tick.number * self._period_ns
        for command in self._due:
            self._obey(command, time_ns)
        if self._lease is not None:
            self._watch_client(self._lease)
        if self._first_test is not None and self._stopping is Stopping.NOT:
            self._try_first(self._first_test)
        if self._asked is not None or self._stopping is not Stopping.NOT or tick.number >= self._last_tick:
            self._leave_when_due()
        if tick.skipped and self._pass_over is not None:
            self._pass_over(tick.skipped)
        received = self._link.receive()
        sent = self._host.tick(tick.number, time_ns, received)
        self._link.send(sent)
        late_ns, computing_ns = tick.woke_ns - tick.deadline_ns, self._clock.now_ns() - tick.woke_ns
        self._telemetry.tick(self._host.row, late_ns, computing_ns, received, sent)
        for event in self._host.events():
            self._telemetry.event(
                event.tick, time_ns, _kind(event), event.text, {"code": word_of(event.code), **event.data}
            )
        if self._link.complaint != self._complaint:
            self._complaint = self._link.complaint
            told = {"code": "drive_complaint", "complaint": self._complaint}
            self._event("drive", self._complaint or "the drives report nothing wrong any more", told)
        self._due = take_commands(self._commands)
        if tick.number % self._service_check_ticks <= tick.skipped:
            self._watch_service()
        return self._go_on()

    def last_words(self) -> None:
        """After a failure of this process: try to switch torque off; if even that fails, the drive's deadman does
        it.
        """
        with contextlib.suppress(Exception):
            for _ in range(3):
                self._host.quick_stop()
                self._tick += 1
                self._link.send(self._host.tick(self._tick, self._tick * self._period_ns, self._link.receive()))

    def tell_miss(self, miss: Miss, cause: MissCause) -> None:
        """For the tick engine: a miss has been explained; the row that it belongs to is that of the tick which ran
        next.
        """
        tick = miss.tick + miss.periods
        self._telemetry.miss(tick, miss.periods, cause)
        used = miss.usage
        data = {
            "cause": cause.value,
            "periods": miss.periods,
            "late_ms": (miss.woke_ns - miss.deadline_ns) / 1e6,
            # since the wake-up before
            "elapsed_ms": (miss.woke_ns - miss.began_ns) / 1e6,
            "step_ms": (miss.ended_ns - miss.began_ns) / 1e6,
            "computing_ms": used.computing_ns / 1e6,
            "queued_ms": used.queued_ns / 1e6,
            "collecting_ms": used.collecting_ns / 1e6,
            "bus_ms": used.bus_wait_ns / 1e6,
            "waits": used.waits,
            "page_faults": used.minor_faults + used.major_faults,
        }
        self._event("timing", f"{miss.periods} ticks missed ({cause.value})", data, tick)

    def tell_link(self, is_open: bool, text: str) -> None:
        """For the link keeper: the link has come or gone."""
        self._event("link", text, {"code": "port", "open": is_open})

    def give_up(self, reason: str) -> None:
        """Nothing can go on: torque off as far as that is still heard, then out with a safety stop."""
        self._ask(LoopEnd(EXIT_SAFETY_STOP, reason))

    def tell_note(self, text: str) -> None:
        """Something that whoever reads the log should know."""
        self._event("note", text, {})

    def _obey(self, command: Command, time_ns: int) -> None:
        """Hand a command to the host just before the tick that acts on it."""
        if command.kind is CommandKind.RECORDING_FAILED:
            self._ask(LoopEnd(EXIT_SAFETY_STOP, f"recording failed: {command.payload.decode()}"))
            return
        if command.kind in _OF_A_LEASE:
            self._hear_of_client(command)
            return
        leaving = self._asked is not None or self._stopping is not Stopping.NOT
        connecting = self._first_test is not None or self._host.state in _CONNECTING
        problem = "the daemon is stopping" if leaving else self._give(command)
        self._telemetry.reply(command.number, self._tick, time_ns, problem, not leaving and connecting)

    def _give(self, command: Command) -> str:
        """Answers why the host does not take the command, empty when it does."""
        host = self._host
        # whoever asked has been told by now that it was not taken
        if command.kind in (*_STARTS, CommandKind.ADJUST) and command.is_stale:
            return "the request is too old: the control process stood still meanwhile"
        if command.kind in _STARTS:
            if self._first_test is not None and host.state not in (*_CONNECTING, HostState.FAULT):
                spoilt = f"; the last try told nothing: {self._first_test.spoilt}" if self._first_test.spoilt else ""
                return f"the antenna is being tried with a small torque before its first motion{spoilt}"
            if host.state not in (HostState.IDLE, HostState.ACTIVE):
                return why_not_now(host)
            if command.kind is CommandKind.START_WITH_IMAGE:
                data = {"command": "image", "words": IMAGE_WORDS, "image": image_of(host)}
                self._event("command", "where the host stands", data)
            host.command(unpack_program(command.payload))
            lease_ticks = lease_ticks_of(command.payload)
            self._lease = Lease(command.number, lease_ticks, self._period_ns) if lease_ticks else None
            return ""  # the service records it: it has the program
        if command.kind is CommandKind.ADJUST:
            numbers = unpack_configuration(command.payload)
            if not (why := why_not_adjusted(host, numbers)):
                host.adjust(numbers)
            return why  # the service records it: it knows the numbers by name
        if command.kind is CommandKind.SHUT_DOWN:
            self._leave(Stopping.BRAKING, LoopEnd(EXIT_DONE, "shut down by the operator"))
            return ""
        word, ask = _PLAIN[command.kind]
        ask(host)
        self._record_command(word)
        return ""

    def _hear_of_client(self, command: Command) -> None:
        """Of the client of the motion that the host follows; one that was replaced has no lease any more."""
        lease = self._lease
        if lease is None or lease.motion != unpack_motion_number(command.payload):
            return
        if command.kind is CommandKind.RENEW:
            lease.renew()
        elif command.kind is CommandKind.CLIENT_GONE:
            lease.client_gone()
        else:
            self._lease = None

    def _watch_client(self, lease: Lease) -> None:
        """Brake to rest under control, just before the host's tick, where the motion has lost its client."""
        lease.pass_tick()
        if not lease.ended:
            return
        self._lease = None
        if self._host.state is HostState.ACTIVE and self._stopping is Stopping.NOT:
            text = f"stopping: whoever asked for the motion {lease.ended}"
            self._event("note", text, {"code": "lease_ended", "reason": lease.ended})
            self._host.stop()
            self._record_command("stop")

    def _try_first(self, test: FirstTest) -> None:
        """The test before the first motion goes on; the daemon ends where the antenna does not pass it."""
        before = test.state
        given = test.before_tick()
        if before is FirstTestState.RUNS and test.state is FirstTestState.DUE:
            self._event("note", f"the first test is made again: {test.spoilt}", {})
        if isinstance(given, Program):
            self._event("command", "start", {"command": "start", "program": given.as_document()})
        elif given:
            self._record_command(given)
        if test.state is FirstTestState.FAILED:
            self._ask(LoopEnd(EXIT_SAFETY_STOP, test.problem))
        if test.state in (FirstTestState.PASSED, FirstTestState.FAILED):
            self._tell_first_test(test.said, test)
            self._first_test = None

    def _tell_first_test(self, text: str, test: FirstTest) -> None:
        self._event("note", text, {"code": FIRST_TEST, "state": test.state.value})

    def _record_command(self, word: str) -> None:
        self._event("command", word, {"command": word})

    def _event(self, kind: str, text: str, data: Json, tick: int | None = None) -> None:
        at = self._tick if tick is None else tick
        self._telemetry.event(at, at * self._period_ns, kind, text, data)

    def _watch_service(self) -> None:
        trouble = None if self._service_gone else self._service.trouble(self._clock)
        if trouble is not None:
            self._service_gone = True
            self._ask(LoopEnd(EXIT_SAFETY_STOP, trouble))

    def _ask(self, ending: LoopEnd) -> None:
        if self._asked is None:
            self._asked = ending

    def _leave(self, how: Stopping, ending: LoopEnd) -> None:
        """BRAKING: to rest under control, then off. SWITCHING_OFF: no torque from this tick on, the drive stops the
        axes by itself.
        """
        if self._leaving != ending:
            self._event("note", f"stopping: {ending.reason}", {"exit_code": ending.exit_code})
        self._stopping, self._stopping_since, self._leaving = how, self._tick, ending
        if how is Stopping.BRAKING:
            self._host.stop()
            self._record_command("stop")
        else:
            self._host.quick_stop()
            self._record_command("quick_stop")

    def _leave_when_due(self) -> None:
        """The next step on the way out, just before the host's tick."""
        age = self._tick - self._stopping_since
        if self._stopping is Stopping.SWITCHING_OFF:
            return
        if self._asked is not None:
            self._leave(Stopping.SWITCHING_OFF, self._asked)
        elif self._stopping is Stopping.NOT:
            if self._tick >= self._last_tick:
                self._leave(Stopping.BRAKING, self._at_end_of_duration())
        elif age > self._leave_ticks or (age > 0 and self._host.state not in (HostState.ACTIVE, HostState.STOPPING)):
            self._leave(Stopping.SWITCHING_OFF, self._leaving)

    def _go_on(self) -> bool:
        """Whether there is another tick: until the drive is off or has had its time."""
        age = self._tick - self._stopping_since
        if self._stopping is Stopping.SWITCHING_OFF and age > 2 and (self._drive_is_off() or age > self._leave_ticks):
            self.ending = self.ending or self._leaving
        return self.ending is None

    def _drive_is_off(self) -> bool:
        """Or it stops the axes by itself and they are at rest already, or nothing is heard of it."""
        if not self._link.is_open or self._host.link_status is LinkStatus.LOST:
            return True
        state = DriveState(int(self._host.memory.G[DRIVE_STATE]))
        return not state.gives_torque or (state is DriveState.QUICK_STOP_ACTIVE and self._at_rest())

    def _at_rest(self) -> bool:
        H, C = self._host.memory.H, self._host.memory.C
        rates = [abs(H[axis_h(axis) + MEASURED_RATE] - H[axis_h(axis) + BASE_RATE]) for axis in range(AXES)]
        return all(rate < C[axis_c(axis) + REST_RATE] for axis, rate in enumerate(rates))

    def _at_end_of_duration(self) -> LoopEnd:
        if self._host.state is HostState.FAULT:
            return LoopEnd(EXIT_SAFETY_STOP, f"the host is in fault ({word_of(self._host.cause)})")
        if self._host.state is HostState.WAITING:
            return LoopEnd(EXIT_NO, "the antenna did not answer")
        return LoopEnd(EXIT_DONE, "the duration is over")


def _kind(event: HostEvent) -> str:
    # an operator's quick stop, as of a duration that is over, is none
    asked = event.data.get("cause") == _OPERATOR
    return "fault" if event.data.get("to") in _FAULTS and not asked else _EVENT_KIND[event.code]
