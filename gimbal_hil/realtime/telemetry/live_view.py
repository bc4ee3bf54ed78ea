"""What an onlooker sees of a running daemon: last row, a thinned trace, tick statistics; all from the records that pass
by.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from firmware_protocol import schema
from firmware_protocol.enumerations import DriveState, FaultCode
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import AXES, TICK_ROW
from gimbal_hil.loop.control import Mode
from gimbal_hil.loop.host import GUARD_CAUSES, HostState, LinkStatus, PointingState, word_of
from gimbal_hil.loop.timing import MISS_CODE, Histogram, MissCause
from gimbal_hil.realtime.telemetry.records import Exchange
from gimbal_hil.realtime.telemetry.trouble import DRIVE_TOLD, told_state, trouble_of
from gimbal_hil.realtime.telemetry.wire_watch import Wire, WireWatch
from sim_backend.boresight import Boresight

#: rows per second and seconds that the trace keeps
TRACE_RATE_HZ, TRACE_S = 50, 60
#: attitude of the base in the trace, rad; NaN where none is heard
BASE = ("base_roll", "base_pitch", "base_yaw")
_POINTING_OFF = word_of(PointingState.OFF)
#: host states in which a guard has stopped the axes, or does
_STOPS = (word_of(HostState.FAULT), word_of(HostState.STOPPING))
#: identifiers of what navigation sends, as they stand in a block: seldom, so that every block is looked at for them
_BASE_IDS = tuple(
    message.can_id.to_bytes(2, "little")
    for message in schema.BY_CAN_ID.values()
    if message.name in ("base_attitude", "base_heading")
)
#: navigation that was not heard for so long is silent
_BASE_SILENCE_NS = 1_000_000_000
_CAUSES = {code: cause for cause, code in MISS_CODE.items()}


@dataclass(slots=True)
class LiveView:
    """Fed by the service with every exchange and every explained miss."""

    period_ns: int
    #: names of the axes, the carrying one first
    axes: tuple[str, ...] = AXES
    #: what carries the frames
    wire: Wire = field(default_factory=Wire)
    ticks: int = 0
    missed: int = 0
    rejected_frames: int = 0
    misses_by_cause: dict[MissCause, int] = field(default_factory=lambda: dict.fromkeys(MissCause, 0))
    latency: Histogram = field(default_factory=Histogram)
    computing: Histogram = field(default_factory=Histogram)
    row: np.void | None = None
    drive_state: DriveState | None = None
    drive_fault: FaultCode | None = None
    #: what the drives last said is wrong with them, in their makers' words
    complaint: str = ""
    #: how the daemon's own test before the first motion stands, as its last event told; None where it makes none
    first_test: str | None = None
    #: why the host last changed its state
    cause: str = "none"
    #: the guard that holds the host in fault, or makes it brake, now; empty where none does
    guard: str = ""
    #: when the host came to stand, or began to brake, for that cause: seconds of the run's clock
    stopped_s: float = 0.0
    #: how often each guard has tripped
    trips: dict[str, int] = field(default_factory=lambda: {word_of(cause): 0 for cause in GUARD_CAUSES})
    #: how recording stands, as `Recorder.state` tells it
    recording: Callable[[], Json] = dict
    #: gains and limits that may be changed, as `AdjustableNumber.as_dict` tells them
    adjustable: Callable[[], list[Json]] = list
    #: axis -> `position_low_rad`, `position_high_rad`, `cable_wrap_turns` (None without one) and `torque_nm` in force
    limits: Callable[[], Json] = dict
    #: along which axis of its inner body the antenna looks
    boresight: Boresight = Boresight.AHEAD
    #: what the model beside the antenna tells, as `LiveObserver.status` does
    observed: Callable[[], Json] = dict
    #: how a direction in space is held, as the last POINTING event told
    pointing: Json = field(default_factory=lambda: {"state": _POINTING_OFF, "muted": True})
    _stopped: bool = False
    #: axes on which a guard has tripped since the host last moved freely, by its cause
    _tripped: dict[str, list[str]] = field(default_factory=dict)
    _measured: dict[str, float] = field(default_factory=dict)
    #: when navigation was last heard
    _base_heard_ns: int | None = None
    _trace: deque[list[float]] = field(default_factory=lambda: deque(maxlen=TRACE_RATE_HZ * TRACE_S))
    _next_trace_ns: int = 0
    _wire_watch: WireWatch = field(init=False)

    def __post_init__(self) -> None:
        self._wire_watch = WireWatch(self.period_ns, self.wire)

    def take(self, exchanges: list[Exchange], missing_nm: Sequence[tuple[float, float]] = ()) -> None:
        """Take in ticks in their order, with the torque that the model lacks after each where that is known."""
        if not exchanges:
            return
        rows = np.frombuffer(b"".join(exchange.row for exchange in exchanges), TICK_ROW)
        names = ("time_ns", "wake_latency_ns", "computing_ns", "rejected_frames")
        columns = zip(*(rows[name].tolist() for name in names), strict=True)
        for index, (time_ns, late_ns, computing_ns, rejected) in enumerate(columns):
            self._wire_watch.take(exchanges[index], rejected)
            if any(number in exchanges[index].received for number in _BASE_IDS):
                self._listen(exchanges[index].received, time_ns)
            self.latency.add(late_ns)
            self.computing.add(computing_ns)
            if time_ns >= self._next_trace_ns:
                self._next_trace_ns = time_ns + 1_000_000_000 // TRACE_RATE_HZ
                self._listen(exchanges[index].received, time_ns)
                self._trace.append(self._point(rows[index], missing_nm[index] if missing_nm else (math.nan, math.nan)))
        self.ticks += len(exchanges)
        self.missed += int(rows["skipped_ticks"].sum())
        self.rejected_frames += int(rows["rejected_frames"].sum())
        self.row = rows[-1]
        self._listen(exchanges[-1].received, int(rows["time_ns"][-1]))

    def state_changed(self, to: str, cause: str) -> None:
        """The host has changed its state: a guard trips, or lets go."""
        stops = to in _STOPS
        if stops and (cause != self.cause or not self._stopped):
            self.stopped_s = 0.0 if self.row is None else int(self.row["time_ns"]) / 1e9
        self.cause, self._stopped = cause, stops
        if not stops:
            self._tripped.clear()
        self.guard = cause if stops and cause in self.trips else self.guard if stops else ""
        if stops and cause in self.trips:
            self.trips[cause] += 1

    def tripped(self, cause: str, axis: str) -> None:
        """A guard has tripped on this axis; the stop that comes of it is told next."""
        axes = self._tripped.setdefault(cause, [])
        if axis not in axes:
            axes.append(axis)

    def pointing_changed(self, data: Json) -> None:
        """A direction is acquired, held, muted or let go."""
        self.pointing = {"state": data["state"], "muted": data["muted"]}

    def miss(self, periods: int, code: int) -> None:
        """A miss has been explained."""
        self.misses_by_cause[_CAUSES[code]] += periods

    def status(self) -> Json:
        """Where the daemon stands, in words and SI units."""
        row = self.row if self.row is not None else np.zeros(1, TICK_ROW)[0]
        state, fault = word_of(HostState(int(row["host_state"]))), self.drive_fault
        told_fault = None if fault is None else word_of(fault)
        axes, link = self._tripped.get(self.cause, ()), LinkStatus(int(row["link_status"]))
        heard = self.drive_state if link is not LinkStatus.LOST else None
        trouble = trouble_of(state, self.cause, told_fault, self.complaint, self.stopped_s, axes, heard)
        return {
            "tick": int(row["tick"]),
            "time_ns": int(row["time_ns"]),
            "host_state": state,
            "host_told": told_state(state, self.cause),
            "trouble": None if trouble is None else trouble.as_dict(),
            "first_test": self.first_test,
            "cause": self.cause,
            "guard": self.guard,
            "guard_trips": {guard: count for guard, count in self.trips.items() if count},
            "link": word_of(link),
            "drive_state": word_of(self.drive_state) if self.drive_state is not None else None,
            "drive_told": DRIVE_TOLD[self.drive_state] if self.drive_state is not None else None,
            "drive_fault": told_fault,
            "drive_complaint": self.complaint,
            "segment": int(row["segment"]),
            "pointing": self.pointing,
            "mode": {axis: word_of(Mode(int(row[f"mode_{own}"]))) for own, axis in self._named()},
            "position_rad": {axis: self._measured.get(f"position_{own}") for own, axis in self._named()},
            "position_ref_rad": {axis: _finite(float(row[f"position_ref_{own}"])) for own, axis in self._named()},
            "rate_rad_s": {axis: self._measured.get(f"rate_{own}") for own, axis in self._named()},
            "torque_nm": {axis: float(row[f"torque_{own}"]) for own, axis in self._named()},
            "limits": self.limits(),
            "boresight": self.boresight.value,
            "base_attitude_rad": self._base_attitude(int(row["time_ns"])),
            "rejected_frames": self.rejected_frames,
            "adjusted": [
                f"{one['axis']} {one['key']} {one['value']:g} (configured {one['configured']:g})"
                for one in self.adjustable()
                if one["value"] != one["configured"]
            ],
            "observer": self.observed(),
            "wire": self._wire_watch.state(),
            "statistics": self.statistics(),
        }

    def statistics(self) -> Json:
        """Tick statistics as the tick engine gives them."""
        return {
            "period_us": self.period_ns / 1e3,
            "ticks": self.ticks,
            "missed": self.missed,
            "missed_by_cause": {cause.value: count for cause, count in self.misses_by_cause.items()},
            "latency_us": self.latency.summary_us(),
            "computing_us": self.computing.summary_us(),
        }

    def trace(self, since_s: float) -> Json:
        """Columns of the thinned trace after `since_s` (seconds of the run's clock)."""
        names = [
            "time_s",
            "muted",
            *BASE,
            *(
                f"{signal}_{axis}"
                for axis in self.axes
                for signal in ("position", "position_ref", "rate", "rate_ref", "torque", "missing_torque")
            ),
        ]
        points = [point for point in list(self._trace) if point[0] > since_s]
        return {name: [point[index] for point in points] for index, name in enumerate(names)}

    def _base_attitude(self, now_ns: int) -> Json | None:
        """Roll, pitch and yaw of the base (R_eb = Rz(yaw) Ry(pitch) Rx(roll)); None while navigation is silent."""
        if self._base_heard_ns is None or now_ns - self._base_heard_ns > _BASE_SILENCE_NS:
            return None
        return {name.removeprefix("base_"): self._measured[name] for name in BASE}

    def _named(self) -> zip[tuple[str, str]]:
        """(name in columns and messages, name of the axis)."""
        return zip(AXES, self.axes, strict=True)

    def _point(self, row: np.void, missing_nm: tuple[float, float]) -> list[float]:
        # NaN: no direction is held, so there is nothing to mute
        muted = math.nan if self.pointing["state"] == _POINTING_OFF else float(self.pointing["muted"])
        point = [int(row["time_ns"]) / 1e9, muted, *(self._measured.get(name, math.nan) for name in BASE)]
        for axis, missing in zip(AXES, missing_nm, strict=True):
            measured = self._measured.get
            point += [measured(f"position_{axis}", 0.0), float(row[f"position_ref_{axis}"])]
            point += [
                measured(f"rate_{axis}", 0.0),
                float(row[f"rate_ref_{axis}"]),
                float(row[f"torque_{axis}"]),
                missing,
            ]
        return point

    def _listen(self, block: bytes, time_ns: int) -> None:
        """Take measured values out of a received block; the host has checked the frames, an onlooker need not."""
        for at in range(0, len(block), schema.RECORD_SIZE):
            message = schema.BY_CAN_ID.get(int.from_bytes(block[at : at + 2], "little"))
            if message is None:
                continue
            word = int.from_bytes(block[at + 2 : at + 10], "little")
            if message.name.startswith("feedback_"):
                axis = message.name.removeprefix("feedback_")
                self._measured[f"position_{axis}"] = _value(word, message, "position")
                self._measured[f"rate_{axis}"] = _value(word, message, "rate")
            elif message.name == "base_attitude":
                for name in BASE[:2]:
                    self._measured[name] = _value(word, message, name.removeprefix("base_"))
            elif message.name == "base_heading":
                self._measured[BASE[2]] = _value(word, message, "yaw")
                self._base_heard_ns = time_ns if BASE[0] in self._measured else None
            elif message.name == "drive_status":
                state, fault = int(_value(word, message, "state")), int(_value(word, message, "fault"))
                if state in DriveState._value2member_map_ and fault in FaultCode._value2member_map_:
                    self.drive_state, self.drive_fault = DriveState(state), FaultCode(fault)


def _finite(value: float) -> float | None:
    """JSON knows no NaN: an axis without a reference has none."""
    return value if math.isfinite(value) else None


def _value(word: int, message: schema.Message, name: str) -> float:
    field = next(field for field in message.fields if field.name == name)
    raw = (word >> message.start(name)) & ((1 << field.bits) - 1)
    if field.signed and raw >> (field.bits - 1):
        raw -= 1 << field.bits
    return raw * field.step
