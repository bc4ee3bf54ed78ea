"""The antenna's side of the wire on behalf of two drives: state machine, deadman, feedback sets. Sans-IO.

Towards the host this is an antenna (docs/reference/wire.md): it may tell of a drive state after CiA 402, echoes the
sequence of the set-point that acted before the sample, and stops when set-points stay away. It lives in the host's
process: that it counts a deadman guards against a host that no longer decides, not against one that is gone; for that
there is the drive's own watchdog. A state is told once both drives have said it (`obedience.py`), never because it was
commanded.
"""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.adapters.answering import Answering
from firmware_protocol.adapters.drive import AxisSample, ForeignDrive, Power, on_the_joint, shaft_torque
from firmware_protocol.adapters.obedience import Obedience, Order
from firmware_protocol.adapters.transitions import asked_for, destination
from firmware_protocol.codec import Rejection, alive_counter, pack, record, records, schema_of, unpack
from firmware_protocol.enumerations import BrakeState, DriveRequest, DriveState, FaultCode, LimitFlags, StopReaction
from firmware_protocol.links import CanFrame, DriveSection
from firmware_protocol.messages import (
    AnyMessage,
    DeadmanConfig,
    DriveControl,
    DriveEvent,
    DriveStatus,
    FeedbackInner,
    FeedbackOuter,
    Identity,
    IdentityUnit,
    MotorStatusInner,
    MotorStatusOuter,
    SetPoint,
)
from firmware_protocol.schema import (
    POSITION_STEP_RAD,
    PROTOCOL_VERSION,
    RATE_STEP_RAD_S,
    TORQUE_STEP_NM,
    name_code,
)

_STATE, _REQUEST = DriveState, DriveRequest
_LARGEST_RAW = 2**17 - 1
#: what a feedback frame can carry; beyond it a position or a rate would be told as one that it is not
_LARGEST_POSITION_RAD, _LARGEST_RATE_RAD_S = (2**25 - 1) * POSITION_STEP_RAD, (2**21 - 1) * RATE_STEP_RAD_S
_SEQUENCES = 1024
_STATUS_EVERY, _IDENTITY_EVERY = 50, 1000
_DETAIL_BY_ITSELF, _DETAIL_RESET = 0, 7
#: ticks without drive_control, and ticks in which a drive has lost its torque, that are too many while torque is on
_CONTROL_TICKS, _LOST_POWER_TICKS = 1000, 20
#: a drive's own stop after a fault may take so long, s; then it is to let go
_REACTION_S = 1.0
#: requests of a host that wants no stop any more; one that asks for operation has not yet heard of the fault
_NO_STOP = (_REQUEST.NONE, _REQUEST.SHUTDOWN, _REQUEST.DISABLE_VOLTAGE)
#: faults that the host takes back by itself, because a lost link leaves them behind
_OF_A_LINK = (FaultCode.DEADMAN, FaultCode.COMMUNICATION)
_LIMITS = (LimitFlags.OUTER_TORQUE, LimitFlags.INNER_TORQUE)


def torque_exponent(largest_nm: float) -> int:
    """How often the wire's torque step is doubled for an axis of this largest torque."""
    exponent = 0
    while _LARGEST_RAW * TORQUE_STEP_NM * 2.0**exponent < largest_nm:
        exponent += 1
    return exponent


class Gateway:
    """An antenna made of two drives, the carrying axis first."""

    def __init__(
        self, drives: Sequence[ForeignDrive], sections: Sequence[DriveSection], name: str, period_s: float = 1e-3
    ) -> None:
        self.drives, self._sections, self._name = tuple(drives), tuple(sections), name
        self._obedience, self._reaction_ticks = Obedience(self.drives, period_s), round(_REACTION_S / period_s)
        self._wanted: tuple[DriveState, DriveRequest] | None = None
        self._reacting = 0
        self.state, self.fault = _STATE.SWITCH_ON_DISABLED, FaultCode.NONE
        self._units = [2.0 ** torque_exponent(section.torque_nm) for section in sections]
        self._counters: dict[str, int] = {}
        self._heard: dict[int, int] = {}
        self._set_point = SetPoint(0.0, 0.0, 0, False, False)
        self._acted = 0
        self._edge_tick: int | None = None
        self._window, self._margin, self._tick, self._control_age = 20, 0, 0, 0
        self._when_unfed = StopReaction.DECELERATE_AND_HOLD
        self._enabling, self._powerless, self._reset_level, self._identify = False, 0, True, True
        self._told: list[AnyMessage] = []
        self._seen = [0, 0]
        self._answering = Answering() if all(drive.is_asked for drive in self.drives) else None
        self._carried, self._out_of_range = [AxisSample(), AxisSample()], [False, False]

    def begin(self) -> list[CanFrame]:
        """Frames for a bus that was just opened."""
        return [frame for drive in self.drives for frame in (*drive.begin(), *drive.ask())]

    def hear(self, block: bytes) -> list[CanFrame]:
        """A block of the host's, which is the edge of a tick; answers what the drives are to be sent."""
        fed, control = False, None
        self._acted = self._set_point.sequence
        for can_id, payload in records(block):
            message = self._fresh(can_id, payload)
            if isinstance(message, SetPoint):
                self._pass_to(message.sequence)
                self._set_point, self._margin, fed = message, self._window, True
            elif isinstance(message, DriveControl):
                control = message
            elif isinstance(message, DeadmanConfig) and self.state is not _STATE.OPERATION_ENABLED:
                self._window, self._when_unfed = message.window_ticks, message.reaction
        frames = self._advance(control, fed)
        if fed:
            self._edge_tick = self._tick
        return frames

    def _pass_to(self, sequence: int) -> None:
        """A set-point has the number of the host's tick: a host that was kept from running skips ticks, and the samples
        that it then gets are as far apart as they are.
        """
        if self._edge_tick is not None:
            passed = (sequence - self._set_point.sequence) % _SEQUENCES
            self._tick = max(self._tick, self._edge_tick + passed - 1)

    def pass_over(self) -> list[CanFrame]:
        """A tick in which the host said nothing."""
        self._acted = self._set_point.sequence
        return self._advance(None, False)

    def take(self, frames: Sequence[CanFrame]) -> int:
        """Frames of the bus; how many nobody here understood."""
        return sum(not any(drive.take(frame) for drive in self.drives) for frame in frames)

    def feedback(self) -> bytes:
        """The feedback set of this tick, once both drives have said something new; else nothing. For one look a
        tick.
        """
        new = [drive.sample.updates - seen for drive, seen in zip(self.drives, self._seen, strict=True)]
        punctual = self._answering is None or self._answering.is_of_this_tick(new)
        if not all(new):
            return b""
        self._seen = [drive.sample.updates for drive in self.drives]
        if not punctual:
            return b""
        samples = self._samples()
        messages, self._told = self._told, []
        if self._tick % _STATUS_EVERY == 0:
            messages += self._motor_status(samples)
        if self._identify or self._tick % _IDENTITY_EVERY == 0:
            messages += self._who()
            self._identify = False
        outer, inner = samples
        messages += [
            FeedbackOuter(outer.position_rad, _rate(outer)),
            FeedbackInner(inner.position_rad, _rate(inner)),
            DriveStatus(
                self.state,
                self.fault,
                self._set_point.sequence if self._answering is None else self._acted,
                min(self._margin, 255),
                self._limits(),
                self._tick % 4096,
            ),
        ]
        return b"".join(self._record(message) for message in messages)

    def _samples(self) -> list[AxisSample]:
        """What both joints last said; one that no frame can carry is not told, and the last one that it can stands."""
        for place, (drive, section) in enumerate(zip(self.drives, self._sections, strict=True)):
            found = on_the_joint(drive.sample, section)
            self._out_of_range[place] = not (
                abs(found.position_rad) <= _LARGEST_POSITION_RAD and abs(_rate(found)) <= _LARGEST_RATE_RAD_S
            )
            if not self._out_of_range[place]:
                self._carried[place] = found
        return list(self._carried)

    def silent(self) -> list[bool]:
        """For each drive whether it has told no position since the last feedback set."""
        return [drive.sample.updates == seen for drive, seen in zip(self.drives, self._seen, strict=True)]

    def complaints(self) -> list[str]:
        """For each drive its own word for its fault, what speaks against it, and that it does not do as told; nothing
        where there is nothing to say of either.
        """
        samples = [drive.sample for drive in self.drives]
        if not self._obedience.starving and not any(sample.fault or sample.caution for sample in samples):
            return []
        return [
            ", ".join(
                word for word in (drive.sample.fault, drive.sample.caution, self._obedience.complaint(place)) if word
            )
            for place, drive in enumerate(self.drives)
        ]

    def _advance(self, control: DriveControl | None, fed: bool) -> list[CanFrame]:
        self._tick += 1
        if not fed:
            self._margin = max(0, self._margin - 1)
        self._control_age = 0 if control is not None else self._control_age + 1
        frames = self._follow(control)
        if self._obedience.order is not Order.FOLLOW:
            return [*frames, *self._obedience.frames()]
        if self.state is _STATE.OPERATION_ENABLED:
            return [*frames, *self._commands()]
        return [*frames, *(frame for drive in self.drives for frame in drive.enable())]

    def _follow(self, control: DriveControl | None) -> list[CanFrame]:
        """One transition at most: a fault before a request."""
        reset = False
        if control is not None:
            reset, self._reset_level = control.fault_reset and not self._reset_level, control.fault_reset
            self._identify = self._identify or control.identify
            if self._obedience.order is Order.NONE and all(drive.sample.updates for drive in self.drives):
                self._obedience.give(Order.RELEASE)
        fault = self._found_fault()
        if self.state is _STATE.FAULT:
            return self._in_fault(fault, reset)
        if self.state is _STATE.FAULT_REACTION_ACTIVE:
            self._react(control, fault, reset)
        elif fault is not FaultCode.NONE:
            self._fail(fault)
        elif self._obedience.order is not Order.NONE:
            self._request(control)
            self._arrive()
        return []

    def _in_fault(self, fault: FaultCode, reset: bool) -> list[CanFrame]:
        """Nothing is under torque; where a drive says that it is, this is no fault state any more."""
        self._remember(fault)
        if any(drive.sample.power.is_powered for drive in self.drives):
            self._fail(self.fault)
        elif reset and (any(drive.sample.power is Power.FAULT for drive in self.drives) or any(self._out_of_range)):
            return [frame for drive in self.drives for frame in drive.reset()]
        elif reset:
            self.fault = FaultCode.NONE
            self._enter(_STATE.SWITCH_ON_DISABLED, FaultCode.NONE, _DETAIL_RESET)
        return []

    def _react(self, control: DriveControl | None, fault: FaultCode, reset: bool) -> None:
        """The drives stop by themselves, for some time; a fault is told once none is under torque any more."""
        self._remember(fault)
        self._reacting += 1
        asked = control is not None and asked_for(control) in _NO_STOP
        if self._obedience.without_torque():
            self._obedience.feed_again()
            self._obedience.let_go()
            self._enter(_STATE.FAULT, self.fault, _DETAIL_BY_ITSELF)
        elif reset or asked or self._reacting > self._reaction_ticks:
            self._obedience.let_go()

    def _remember(self, fault: FaultCode) -> None:
        """What a lost link leaves behind is taken back by itself; a drive's own fault in it is not."""
        if self.fault in _OF_A_LINK and fault not in (FaultCode.NONE, *_OF_A_LINK):
            self.fault = fault

    def _fail(self, fault: FaultCode) -> None:
        """The drives' own stop where they are under torque; where the position is in doubt, one without a sensor."""
        if fault is FaultCode.ENCODER:
            self._obedience.stop(StopReaction.BRAKE)
        elif self._obedience.order is Order.FOLLOW:
            self._obedience.stop(self._when_unfed if fault is FaultCode.DEADMAN else StopReaction.DECELERATE_AND_HOLD)
        self.fault, self._reacting, self._wanted = fault, 0, None
        self._enter(_STATE.FAULT_REACTION_ACTIVE, fault, _DETAIL_BY_ITSELF)

    def _request(self, control: DriveControl | None) -> None:
        """What the host asks for begins; it is told once the drives have done it."""
        if self._enabling and all(drive.sample.power is Power.ON for drive in self.drives):
            self._enabling = False
            self._enter(_STATE.OPERATION_ENABLED, FaultCode.NONE, _REQUEST.ENABLE_OPERATION)
            return
        if control is None:
            return
        request = asked_for(control)
        heading = self.state if self._wanted is None else self._wanted[0]
        wanted = destination(heading, request)
        if request is _REQUEST.ENABLE_OPERATION and self.state is heading is _STATE.SWITCHED_ON:
            # told as enabled once both drives say so, and never without set-points
            self._enabling = self._margin > 0
            self._obedience.give(Order.FOLLOW if self._enabling else Order.RELEASE)
            return
        if wanted is heading and request in (_REQUEST.NONE, _REQUEST.SWITCH_ON, _REQUEST.ENABLE_OPERATION):
            return
        self._enabling = False
        if wanted is _STATE.QUICK_STOP_ACTIVE:
            self._obedience.stop(control.stop)
        elif request in (_REQUEST.DISABLE_VOLTAGE, _REQUEST.QUICK_STOP):
            self._obedience.let_go()
        else:
            self._obedience.give(Order.RELEASE)
        if wanted is not heading:
            self._wanted = (wanted, request)

    def _arrive(self) -> None:
        """Tell a state once the drives have: the one asked for, or that a quick stop has ended by itself."""
        if self._wanted is not None and self._obedience.is_done():
            (state, request), self._wanted = self._wanted, None
            self._enter(state, FaultCode.NONE, request)
        elif self.state is _STATE.QUICK_STOP_ACTIVE and self._obedience.without_torque():
            self._obedience.let_go()
            self._enter(_STATE.SWITCH_ON_DISABLED, FaultCode.NONE, _DETAIL_BY_ITSELF)

    def _found_fault(self) -> FaultCode:
        powers = [drive.sample.power for drive in self.drives]
        gave_up = self._obedience.gave_up()
        if any(power.is_faulty for power in powers):
            return FaultCode.INTERNAL
        if any(self._out_of_range):
            return FaultCode.ENCODER
        if gave_up:
            return FaultCode.COMMUNICATION if self._obedience.is_silent() else FaultCode.INTERNAL
        if self.state is not _STATE.OPERATION_ENABLED or self._obedience.order is not Order.FOLLOW:
            self._powerless = 0
            return FaultCode.NONE
        self._powerless = 0 if all(power is Power.ON for power in powers) else self._powerless + 1
        if self._margin == 0:
            return FaultCode.DEADMAN
        if self._control_age > _CONTROL_TICKS:
            return FaultCode.COMMUNICATION
        return FaultCode.INTERNAL if self._powerless > _LOST_POWER_TICKS else FaultCode.NONE

    def _commands(self) -> list[CanFrame]:
        asked = self._asked_nm()
        return [
            frame
            for drive, section, torque in zip(self.drives, self._sections, asked, strict=True)
            for frame in drive.command(shaft_torque(torque, section))
        ]

    def _asked_nm(self) -> tuple[float, float]:
        """Torques asked for, N m at the joints; none where the axis is not enabled."""
        now = self._set_point
        outer, inner = now.torque_outer_nm * self._units[0], now.torque_inner_nm * self._units[1]
        return outer * now.enable_outer, inner * now.enable_inner

    def _limits(self) -> LimitFlags:
        flags = LimitFlags(0)
        if self.state is _STATE.OPERATION_ENABLED and self._obedience.order is Order.FOLLOW:
            for flag, torque, section in zip(_LIMITS, self._asked_nm(), self._sections, strict=True):
                flags |= flag if abs(torque) >= section.torque_nm else LimitFlags(0)
        return flags

    def _enter(self, state: DriveState, cause: FaultCode, detail: int) -> None:
        self._told.append(DriveEvent(self.state, state, cause, int(detail), self._tick % 4096))
        self.state, self._enabling = state, False

    def _motor_status(self, samples: Sequence[AxisSample]) -> list[AnyMessage]:
        """Only of a drive that gives all three: a number that nobody measured is not told."""
        told: list[AnyMessage] = []
        builds: tuple[type[MotorStatusOuter | MotorStatusInner], ...] = (MotorStatusOuter, MotorStatusInner)
        for build, sample, unit in zip(builds, samples, self._units, strict=True):
            torque, temperature, supply = sample.torque_nm, sample.temperature_degc, sample.supply_v
            if torque is not None and temperature is not None and supply is not None:
                told.append(build(torque / unit, temperature, supply, BrakeState.ABSENT, False))
        return told

    def _who(self) -> list[AnyMessage]:
        exponents = [torque_exponent(section.torque_nm) for section in self._sections]
        return [
            Identity(PROTOCOL_VERSION, name_code(self._name), False, False),
            IdentityUnit(0, exponents[0], exponents[1]),
        ]

    def _fresh(self, can_id: int, payload: bytes) -> AnyMessage | None:
        """A message with a good CRC and a counter that is not that of the last one; `hear` takes the host's of them."""
        message = unpack(can_id, payload)
        if isinstance(message, Rejection):
            return None
        counter = alive_counter(payload)
        if self._heard.get(can_id) == counter:
            return None
        self._heard[can_id] = counter
        return message

    def _record(self, message: AnyMessage) -> bytes:
        definition = schema_of(message)
        counter = self._counters[definition.name] = (self._counters.get(definition.name, -1) + 1) & 15
        return record(definition.can_id, pack(message, counter))


def _rate(sample: AxisSample) -> float:
    return sample.gyro_rad_s if sample.gyro_rad_s is not None else sample.rate_rad_s or 0.0
