"""The tester of an antenna's firmware: speaks to it message by message and keeps every feedback set that comes.

It judges frames by the plain codec, not by the code that it tests. Torque is in shares of what the wire carries, so
that no unit has to be known; axes are 0 (carrying) and 1 (carried), and `axes` what they are called.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from firmware_protocol.codec import Rejection, alive_counter, from_raw, pack, record, records, schema_of, unpack_raw
from firmware_protocol.enumerations import BrakeCommand, DriveRequest, DriveState, FaultCode, StopReaction
from firmware_protocol.layout import CRC_TABLE, INITIAL_BY_NAME
from firmware_protocol.messages import (
    AnyMessage,
    DeadmanConfig,
    DriveControl,
    DriveEvent,
    DriveStatus,
    FeedbackInner,
    FeedbackOuter,
    SetPoint,
)
from firmware_protocol.schema import (
    BY_CAN_ID,
    BY_NAME,
    COUNTER_START,
    CRC_START,
    PAYLOAD_SIZE,
    RECORD_SIZE,
    TORQUE_STEP_NM,
    Direction,
)
from firmware_protocol.words import crc12, insert
from gimbal_hil.loop.host import AXIS_NAMES
from gimbal_hil.proof.conformance.carriers import Carrier

#: window of the deadman outside of the checks that are about it: 0.2 s at 1 kHz, which no tester's stall reaches often
QUIET_WINDOW = 200
#: what `settle` waits for a fault reaction that holds, at most
_SETTLE_TICKS = 9000
#: a request is repeated so often, in ticks
_REPEAT_TICKS = 10
#: largest torque of the wire, before the axis' exponent
WIRE_TORQUE_NM = BY_NAME["set_point"].fields[0].raw_high * TORQUE_STEP_NM
_NEXT = {
    DriveState.SWITCH_ON_DISABLED: DriveRequest.SHUTDOWN,
    DriveState.READY_TO_SWITCH_ON: DriveRequest.SWITCH_ON,
    DriveState.SWITCHED_ON: DriveRequest.ENABLE_OPERATION,
}
REACTIONS = (DriveState.FAULT_REACTION_ACTIVE, DriveState.FAULT)


class UnmetError(Exception):
    """The antenna did otherwise; the text says what was expected and what came."""


class NotShownError(Exception):
    """The antenna leaves out what the requirement is about; the text says what."""


@dataclass(frozen=True, slots=True)
class FeedbackSet:
    """What came from one drive_status to the next."""

    #: the tester's tick in which it came, and the antenna's own tick without wrapping
    sent: int
    tick: int
    #: in the order in which they came, drive_status last
    messages: tuple[AnyMessage, ...]
    status: DriveStatus

    def motion(self, axis: int) -> FeedbackOuter | FeedbackInner | None:
        """Sensors of an axis, None where that frame did not come."""
        kind = (FeedbackOuter, FeedbackInner)[axis]
        return next((message for message in self.messages if isinstance(message, kind)), None)


@dataclass
class Counts:
    """What was wrong with the frames that came: text of each kind of defect, and how often."""

    frames: int = 0
    defects: dict[str, int] = field(default_factory=dict)
    jumps: dict[str, int] = field(default_factory=dict)

    def note(self, what: str) -> None:
        """One more of this defect."""
        self.defects[what] = self.defects.get(what, 0) + 1


class Stand:
    """One antenna on the bench. `told` is called with every exchange: tick, block received, block sent."""

    def __init__(
        self,
        carrier: Carrier,
        told: Callable[[int, bytes, bytes], None] | None = None,
        counters: dict[str, int] | None = None,
        axes: tuple[str, str] = AXIS_NAMES,
    ) -> None:
        self.carrier, self.told, self.axes = carrier, told, axes
        self.rate_hz = carrier.rate_hz
        self.ticks = 0
        self.sequence = 0
        self.sets: list[FeedbackSet] = []
        self.counts = Counts()
        self.steps: list[str] = []
        #: alive counters, which go on from one stand to the next on the same antenna
        self._counters = {} if counters is None else counters
        self._heard: dict[int, int] = {}
        self._partial: list[AnyMessage] = []

    # --- one tick
    def exchange(self, *messages: AnyMessage, raw: bytes = b"") -> list[FeedbackSet]:
        """Send messages behind `raw` records, let one tick pass, answer the sets that came."""
        block = raw + b"".join(map(self.frame, messages))
        received = self.carrier.exchange(block)
        if self.told is not None:
            self.told(self.ticks, received, block)
        self.ticks += 1
        before = len(self.sets)
        for can_id, payload in records(received):
            self._take(can_id, payload)
        if len(received) % RECORD_SIZE:
            self.counts.note("a fragment of a frame")
        return self.sets[before:]

    def frame(self, message: AnyMessage) -> bytes:
        """A message as a record, with the next alive counter of its kind."""
        definition = schema_of(message)
        counter = self._counters.get(definition.name, 0)
        self._counters[definition.name] = (counter + 1) & 15
        return record(definition.can_id, pack(message, counter))

    def sealed(self, name: str, raw: tuple[int, ...]) -> bytes:
        """A record of these raw integers, counter and CRC right, whatever the fields' bounds are."""
        definition = BY_NAME[name]
        counter = self._counters.get(name, 0)
        self._counters[name] = (counter + 1) & 15
        word = counter << COUNTER_START
        for each, number in zip(definition.fields, raw, strict=True):
            word = insert(word, definition.start(each.name), each.bits, number)
        word |= crc12(word, INITIAL_BY_NAME[name], CRC_TABLE) << CRC_START
        return record(definition.can_id, word.to_bytes(PAYLOAD_SIZE, "little"))

    def counter_goes_back(self, name: str, by: int) -> None:
        """Have the alive counter of a message repeat: the next frame gets the one of `by` frames ago."""
        self._counters[name] = (self._counters.get(name, 0) - by) & 15

    def set_point(
        self,
        torque: tuple[float, float] = (0.0, 0.0),
        enable: tuple[bool, bool] = (False, False),
        ahead: int = 1,
    ) -> SetPoint:
        """The next set-point; `torque` in shares of the wire's range. `ahead` is the step of the sequence."""
        self.sequence = (self.sequence + ahead) % 1024
        outer, inner = (share * WIRE_TORQUE_NM for share in torque)
        return SetPoint(outer, inner, self.sequence, *enable)

    def tick(
        self,
        torque: tuple[float, float] = (0.0, 0.0),
        enable: tuple[bool, bool] = (False, False),
        *others: AnyMessage,
    ) -> list[FeedbackSet]:
        """One tick with a fresh set-point and other messages."""
        return self.exchange(*others, self.set_point(torque, enable))

    def tick_repeated(self, ahead: int) -> list[FeedbackSet]:
        """One tick with a set-point that repeats the sequence (0) or goes back (below 0), under a fresh counter."""
        return self.exchange(self.set_point(ahead=ahead))

    def ask(self, request: DriveRequest = DriveRequest.NONE, ticks: int = 6, **flags: Any) -> None:
        """A drive_control, said three times within `ticks` ticks, because on a link that merges two the last counts."""
        for k in range(ticks):
            messages = [control(request, **flags)] if k % 2 == 0 and k < 6 else []
            self.tick((0.0, 0.0), (False, False), *messages)

    def run(self, ticks: int, *, silent: bool = False) -> list[FeedbackSet]:
        """Ticks in a row, with set-points and requests as a quiet host sends them, or `silent`."""
        found: list[FeedbackSet] = []
        for k in range(ticks):
            if silent:
                found += self.exchange()
            else:
                found += self.tick(
                    (0.0, 0.0), (False, False), *([control()] if k % _REPEAT_TICKS == _REPEAT_TICKS - 1 else [])
                )
        return found

    # --- what is known of the antenna
    @property
    def latest(self) -> FeedbackSet:
        """The last set that came; UnmetError before the first."""
        if not self.sets:
            raise UnmetError("no feedback set has come")
        return self.sets[-1]

    @property
    def state(self) -> DriveState:
        """State in the last set."""
        return self.latest.status.state

    def said(self, kind: type, since: int) -> list[tuple[FeedbackSet, AnyMessage]]:
        """Messages of a kind in the sets from index `since` on."""
        return [(one, m) for one in self.sets[since:] for m in one.messages if isinstance(m, kind)]

    def step(self, text: str) -> None:
        """Note what is done now, for the log of steps."""
        self.steps.append(f"tick {self.ticks}: {text}")

    # --- where it is taken
    def settle(self, window: int = QUIET_WINDOW, reaction: StopReaction = StopReaction.BRAKE) -> None:
        """Take the antenna to SWITCH_ON_DISABLED without a fault, with this deadman; UnmetError where it does not go.

        What was heard of its frames is forgotten, what is wrong with them as well.
        """
        configured = 0
        for k in range(_SETTLE_TICKS):
            asked = self._towards_rest(k, window, reaction)
            self.tick((0.0, 0.0), (False, False), *asked)
            if not self.sets:
                continue
            status = self.latest.status
            off = status.state is DriveState.SWITCH_ON_DISABLED and status.fault is FaultCode.NONE
            # a deadman_config counts that went out after torque was off
            configured = configured + 1 if off and (configured or len(asked) > 1) else 0
            if configured > _REPEAT_TICKS // 2 and window - 5 <= status.deadman_margin_ticks <= window:
                break
        else:
            where = f"{self.state.name}, fault {self.latest.status.fault.name}" if self.sets else "silent"
            raise UnmetError(f"it cannot be brought to SWITCH_ON_DISABLED within {_SETTLE_TICKS} ticks: it is {where}")
        self.sets = self.sets[-1:]
        self.counts = Counts()

    def _towards_rest(self, k: int, window: int, reaction: StopReaction) -> list[AnyMessage]:
        if k % _REPEAT_TICKS:
            return []
        state = self.sets[-1].status.state if self.sets else DriveState.NOT_READY
        if state is DriveState.FAULT:
            # low, then high: an edge
            return [control(fault_reset=k % (2 * _REPEAT_TICKS) > 0)]
        powered = (DriveState.OPERATION_ENABLED, DriveState.QUICK_STOP_ACTIVE, *REACTIONS)
        asked = DriveRequest.NONE if state is DriveState.SWITCH_ON_DISABLED else DriveRequest.DISABLE_VOLTAGE
        deadman = [] if state in powered else [DeadmanConfig(window, reaction)]
        return [control(asked), *deadman]

    def to_state(self, wanted: DriveState, most: int = 400) -> None:
        """Up the ladder of states from SWITCH_ON_DISABLED on; QUICK_STOP_ACTIVE by way of OPERATION_ENABLED."""
        asked = -_REPEAT_TICKS
        for k in range(most):
            if self.state is wanted:
                return
            request = _NEXT.get(self.state)
            if wanted is DriveState.QUICK_STOP_ACTIVE and self.state is DriveState.OPERATION_ENABLED:
                request = DriveRequest.QUICK_STOP
            due = request is not None and k - asked >= _REPEAT_TICKS
            asked = k if due else asked
            before = self.state
            self.tick((0.0, 0.0), (False, False), *([control(request or DriveRequest.NONE)] if due else []))
            if self.state is not before:
                asked = -_REPEAT_TICKS
        raise UnmetError(f"{wanted.name} is not reached within {most} ticks; it is {self.state.name}")

    def until(self, holds: Callable[[FeedbackSet], bool], most: int, *, silent: bool = False) -> FeedbackSet | None:
        """Go on until a set of which this holds has come; None when none has within `most` ticks."""
        for k in range(most):
            messages = (control(),) if k % _REPEAT_TICKS == _REPEAT_TICKS - 1 else ()
            found = self.exchange() if silent else self.tick((0.0, 0.0), (False, False), *messages)
            for one in found:
                if holds(one):
                    return one
        return None

    # --- frames that come
    def _take(self, can_id: int, payload: bytes) -> None:
        definition = BY_CAN_ID.get(can_id)
        self.counts.frames += 1
        if definition is None:
            return self.counts.note(f"unknown identifier 0x{can_id:03x}")
        if definition.direction is not Direction.DEVICE_TO_HOST:
            return self.counts.note(f"{definition.name}, which only a host sends")
        raw = unpack_raw(definition, payload)
        if isinstance(raw, Rejection):
            return self.counts.note(f"{definition.name}: {raw.value}")
        counter = alive_counter(payload)
        last = self._heard.get(can_id)
        if last is not None and (counter - last) & 15 != 1:
            self.counts.jumps[definition.name] = self.counts.jumps.get(definition.name, 0) + 1
        self._heard[can_id] = counter
        self._keep(from_raw(definition, raw))

    def _keep(self, message: AnyMessage) -> None:
        self._partial.append(message)
        if isinstance(message, DriveStatus):
            before = self.sets[-1].tick if self.sets else message.tick
            tick = before + ((message.tick - before) & 4095)
            self.sets.append(FeedbackSet(self.ticks - 1, tick, tuple(self._partial), message))
            self._partial = []


def control(
    request: DriveRequest = DriveRequest.NONE,
    *,
    fault_reset: bool = False,
    quick_stop: bool = False,
    stop: StopReaction = StopReaction.BRAKE,
    identify: bool = False,
) -> DriveControl:
    """A drive_control that leaves the holding brakes to the drive."""
    automatic = BrakeCommand.AUTOMATIC
    return DriveControl(request, fault_reset, quick_stop, False, stop, automatic, automatic, identify)


def events_in(sets: list[FeedbackSet]) -> list[DriveEvent]:
    """All drive_events of some sets."""
    return [message for one in sets for message in one.messages if isinstance(message, DriveEvent)]
