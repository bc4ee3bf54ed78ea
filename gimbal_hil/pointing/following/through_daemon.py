"""A target followed through a running daemon, in real time: the clock of its ticks, acquisition, re-acquisition after a
loss of attitude or link, and the way into the stow.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from firmware_protocol.errors import LinkError, SafetyStopError
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import GrowingLog, RecordedRun
from gimbal_hil.loop.host import (
    AxisCommand,
    EventCode,
    HostCause,
    HostState,
    Mode,
    Program,
    Segment,
    Shape,
    program_of,
    word_of,
)
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.pointing.following.base import BaseTruth
from gimbal_hil.pointing.following.clock import TickClock, tick_clock
from gimbal_hil.pointing.following.way import Way
from gimbal_hil.realtime.operator import OperatorClient, RequestRefusedError
from sim_backend.boresight import Boresight

#: between the request and the first row of a target's way: time for both to be made
LEAD_S = 3.0
#: attitude that was lost is asked for so often
_AGAIN_S = 2.0
_PATIENCE_S = 30.0
#: share of the prefilter's rate and acceleration that a stow takes
_STOW_SHARE = 0.5
_LABEL, _STOW_LABEL = 7001, 7002
_STATE, _ENDED = word_of(EventCode.STATE), word_of(EventCode.SEGMENT_ENDED)
_DURATION = word_of(HostCause.DURATION)
#: stops that may pass: attitude and link come back by themselves, and so does a drive whose deadman tripped
_PASSING = tuple(map(word_of, (HostCause.ATTITUDE_LOST, HostCause.FEEDBACK_LOST, HostCause.DRIVE_FAULT)))
#: a fault that has not passed in this time does not
_FAULT_S = 10.0
_STOPPING, _FAULT = word_of(HostState.STOPPING), word_of(HostState.FAULT)


@dataclass
class FollowedWay:
    """What came of following: first and last tick, and events (tick, data) on the way."""

    first_tick: int
    last_tick: int
    events: list[tuple[int, Json]] = field(default_factory=list)


class PointingDaemon:
    """The daemon that records into `run`, asked to hold directions. Raises BadInputError without one."""

    def __init__(self, run: Path) -> None:
        self.run = run
        self._log = GrowingLog(run)
        self.record = self._log.record
        self.settings = DaemonSettings.model_validate(self.record.header.configuration)
        self.client = OperatorClient(run, timeout_s=_PATIENCE_S)

    @property
    def looks(self) -> Boresight:
        """Which way is up for its antenna."""
        return self.settings.pointing.boresight or Boresight.AHEAD

    def base_now(self) -> BaseTruth:
        """Its base as last told, taken to stay so; level, its x to the north, where none tells."""
        told = self._status()["base_attitude_rad"]
        angles = [0.0, 0.0, 0.0] if told is None else [told[name] for name in ("roll", "pitch", "yaw")]
        return BaseTruth(np.zeros(1), np.array([angles]))

    def clock(self) -> TickClock:
        """When the daemon's ticks are."""
        return tick_clock(lambda: int(self._status()["tick"]), self.record.header.period_ns * 1e-9)

    def follow(
        self,
        way: Way,
        first_row_tick: int,
        duration_s: float,
        tell: Callable[[str], None],
        advance: Callable[[float], None],
        stepped_s: Callable[[], float] = lambda: 0.0,
    ) -> FollowedWay:
        """Follow a way to its end; SafetyStopError when a guard ends it, and when somebody sets the clock that the way
        was made by. Attitude that is lost for longer than gyros hold is waited for.
        """
        period_s = self.record.header.period_ns * 1e-9
        end_tick = first_row_tick + round(duration_s / period_s)
        found = FollowedWay(self._begin(way, first_row_tick, end_tick), end_tick)
        told_s = 0.0
        while True:
            if step_s := stepped_s():
                self.stop()
                raise SafetyStopError(
                    f"the time of day was set by {step_s:+.3f} s on the way: where the target is at a tick is not "
                    "known any more; stopped and muted, to be asked for again"
                )
            event = self.client.next_event(0.25)
            now = int(self._status()["tick"]) if event is None else int(event.get("tick", 0))
            done_s = min(duration_s, max(0.0, (now - first_row_tick) * period_s))
            advance(max(0.0, done_s - told_s))
            told_s = max(told_s, done_s)
            if event is not None and self._over(event, found, tell):
                return found
            stopped = event is not None and _stop_of(event) in _PASSING
            if stopped and not self._again(way, first_row_tick, end_tick, tell):
                found.last_tick = end_tick
                return found
            if now > end_tick + _PATIENCE_S / period_s:
                raise LinkError(f"{self.run}: the target's way did not end in its time")

    def stow(self, tell: Callable[[str], None]) -> None:
        """Both joints to the stow, then torque off."""
        outer, inner, duration_s = self._stow_moves()
        ticks = round(duration_s / (self.record.header.period_ns * 1e-9))
        self._start(program_of([Segment(outer, inner, ticks, label=_STOW_LABEL, switch_off_afterwards=True)]))
        tell(f"stowing, {duration_s:.1f} s")
        if self.client.wait_for_segment(_STOW_LABEL, duration_s + _PATIENCE_S) is None:
            raise LinkError(f"{self.run}: the stow was not told of")
        deadline = time.monotonic() + _PATIENCE_S
        while self._status()["host_state"] == _STOPPING and time.monotonic() < deadline:
            time.sleep(0.02)

    def stop(self) -> None:
        """Brake to rest, torque off."""
        self.client.request("stop")

    def stay(self) -> None:
        """The joints are held as they are, without this process."""
        self.client.release()

    def log(self, first: int, last: int) -> RecordedRun:
        """The daemon's log from a tick to another, once it is written."""
        deadline = time.monotonic() + _PATIENCE_S
        while True:
            run = self._log.look(first)
            if len(run.ticks) and int(run.ticks["tick"][-1]) >= last:
                return run
            if time.monotonic() > deadline:
                raise LinkError(f"{self.run}: the log does not reach tick {last}: is the recording switched off?")
            time.sleep(0.2)

    def close(self) -> None:
        """End the connection; a motion that is still under way is braked to rest."""
        self.client.close()

    def _status(self) -> Json:
        status: Json = self.client.request("status")["status"]
        return status

    def _begin(self, way: Way, first_row_tick: int, end_tick: int) -> int:
        left = max(1, end_tick - int(self._status()["tick"]))
        return self._start(program_of([way.segment(first_row_tick, left, _LABEL)]))

    def _start(self, program: Program) -> int:
        return self.client.start(program)

    def _over(self, event: Json, found: FollowedWay, tell: Callable[[str], None]) -> bool:
        """Take in an event; whether the way has come to its end."""
        data = event.get("data", {})
        found.events.append((int(event.get("tick", 0)), data))
        if data.get("code") == word_of(EventCode.POINTING):
            tell(f"{event['time_ns'] * 1e-9:9.3f} s  {event['text']}")
        if data.get("code") == _ENDED and data.get("segment") == _LABEL and data.get("cause") == _DURATION:
            found.last_tick = int(event["tick"])
            return True
        if _stop_of(event) not in ("", *_PASSING):
            raise SafetyStopError(f"the host went {event['text']}")
        return False

    def _again(self, way: Way, first_row_tick: int, end_tick: int, tell: Callable[[str], None]) -> bool:
        """Ask again until a direction is followed for longer than a moment, or its time is over."""
        tell("stopped and muted; asked for again until attitude and feedback are there")
        since = time.monotonic()
        while int((status := self._status())["tick"]) < end_tick:
            if status["host_state"] != _FAULT:
                since = time.monotonic()
            elif time.monotonic() - since > _FAULT_S:
                raise SafetyStopError(f"the host stays in fault ({status['cause']})")
            time.sleep(_AGAIN_S)
            try:
                self._begin(way, first_row_tick, end_tick)
            except RequestRefusedError:
                continue
            time.sleep(0.3)
            if self._status()["host_state"] == word_of(HostState.ACTIVE):
                return True
        return False

    def _stow_moves(self) -> tuple[AxisCommand, AxisCommand, float]:
        status = self._status()
        stands = [float(status["position_rad"][axis]) for axis in self.record.header.axes]
        return stow_moves(self.settings, stands)


def _stop_of(event: Json) -> str:
    """Why the host stops with this event, empty where it does not."""
    data = event.get("data", {})
    stops = data.get("code") == _STATE and data.get("to") in (_STOPPING, _FAULT)
    return str(data.get("cause")) if stops else ""


def stow_moves(settings: DaemonSettings, stands_rad: list[float]) -> tuple[AxisCommand, AxisCommand, float]:
    """Moves of both joints into the stow, and how long they take, s."""
    commands, longest_s = [], 0.0
    for axis, stow, stands in zip(settings.axes.values(), settings.pointing.stow_rad, stands_rad, strict=True):
        prefilter = axis.prefilter
        rate = _STOW_SHARE * ((prefilter and prefilter.rate_rad_s) or axis.position_loop.rate_limit_rad_s)
        bend = _STOW_SHARE * ((prefilter and prefilter.acceleration_rad_s2) or axis.limits.braking_rad_s2)
        commands.append(AxisCommand(Mode.POSITION, Shape.TRAPEZOID, (stow, rate, bend)))
        longest_s = max(longest_s, abs(stow - stands) / rate + rate / bend + 1.0)
    return commands[0], commands[1], longest_s
