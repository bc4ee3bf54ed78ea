"""The antenna behind a running daemon, in real time: steps go through the operator's door, signals come from the
daemon's log.

Steps are handed over several at a time as one program, so that nothing happens between them: a torque step is caught by
the step after it at the very next tick, whatever this process is doing. A batch ends only where both axes hold a
position.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import LinkError, SafetyStopError
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import AXES, BEGINS, FRAME_ROW, TICK_ROW, Event, EventKind, GrowingLog, RecordedRun
from gimbal_hil.knowledge.experiments.antenna import Followed
from gimbal_hil.knowledge.experiments.experiment import Signals, Step, move_to
from gimbal_hil.loop.host import (
    AxisCommand,
    EventCode,
    HostCause,
    HostState,
    Mode,
    ReferenceOrigin,
    Segment,
    Shape,
    program_of,
    word_of,
)
from gimbal_hil.realtime.operator import OperatorClient

#: a batch has at least so many steps (fewer only at the end)
BATCH = 12
#: a step may take so much longer than its duration before the daemon counts as gone
PATIENCE_S = 30.0
#: ticks behind a step that are read with it: the last torque is known from the set that echoes it
_AFTER_TICKS = 3
#: further away than this a joint is led to the start of an absolute position reference, at this speed
_LEAD_IN_RAD, _LEAD_IN_RAD_S = 0.01, 0.2
_ACTIVE, _STOPPING = word_of(HostState.ACTIVE), word_of(HostState.STOPPING)
_READY = (word_of(HostState.IDLE), _ACTIVE)
_STOPPED = (_STOPPING, *map(word_of, (HostState.FAULT, HostState.WAITING, HostState.IDLE)))
_STARTED, _ENDED, _STATE = map(word_of, (EventCode.SEGMENT_STARTED, EventCode.SEGMENT_ENDED, EventCode.STATE))
#: how a step ends that was not stopped
_AS_PLANNED = (word_of(HostCause.DURATION), word_of(HostCause.END_CONDITION))


@dataclass(frozen=True)
class _Span:
    first: int
    last: int


class DaemonAntenna:
    """Whatever the daemon that records into `run` controls. `steps` are those of the experiment, for handing over in
    batches.

    Raises BadInputError without such a daemon, LinkError when it is gone.
    """

    def __init__(self, run: Path, steps: Sequence[Step], patience_s: float = PATIENCE_S) -> None:
        self.run = Path(run)
        self._log = GrowingLog(self.run)
        self.record = self._log.record
        self.rate_hz = 1e9 / self.record.header.period_ns
        self._steps = tuple(steps)
        self._patience_s = patience_s
        self._client = OperatorClient(self.run, timeout_s=patience_s)
        self._label = 0
        #: steps handed over and not yet followed, with their labels
        self._under_way: list[tuple[Step, int]] = []
        self._started: dict[int, int] = {}
        #: tick that the next rows to hand over begin with; None before the first program
        self._next: int | None = None
        self._first = -1
        #: events of the daemon's log that are not handed over yet
        self._events: list[Event] = []

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes, the carrying one first."""
        return self.record.header.axes

    @property
    def tick(self) -> int:
        """The last tick that the daemon has told of."""
        return int(self._status()["tick"])

    def position_rad(self, axis: str) -> float:
        """Where the joint stands, as the encoder says."""
        return float(self._status()["position_rad"][axis])

    def connect(self) -> Followed:
        """Wait until the host is ready."""
        end = time.monotonic() + self._patience_s
        while (state := self._status()["host_state"]) not in _READY:
            if time.monotonic() > end:
                raise LinkError(f"{self.run}: the daemon's host is {state}, not ready")
            time.sleep(0.05)
        return _nothing(self.tick)

    def follow(self, step: Step, progress: Callable[[int], None]) -> Followed:
        """Follow one step: hand it over (with those after it) unless it is already under way, and wait for its end."""
        try:
            if not self._under_way or self._under_way[0][0] is not step:
                self._hand_over(step)
            label = self._under_way.pop(0)[1]
            span = self._wait(step, label, progress)
            if step.segment.switch_off_afterwards:
                self._until_idle()
            return self._followed(step, span)
        except KeyboardInterrupt:
            # the axes brake now, those of the steps after this one too, whatever is written before this process ends
            self.close()
            raise

    def keep(self) -> None:
        """A real antenna cannot be kept."""
        return None

    def put_back(self, state: Mapping[str, NDArray[np.generic]]) -> None:
        """Nothing to put back: a resumed experiment goes on from where the antenna stands."""

    def let_go(self) -> None:
        """The experiment is over: what the antenna does now it goes on doing without this process."""
        self._client.release()

    def close(self) -> None:
        """End the connection; a motion that is still under way is braked to rest."""
        self._client.close()

    def _status(self) -> Json:
        status: Json = self._client.request("status")["status"]
        return status

    def _hand_over(self, step: Step) -> None:
        place = next((number for number, one in enumerate(self._steps) if one is step), None)
        batch = [step] if place is None else _batch(self._steps[place:])
        positions = self._status()["position_rad"]
        segments, self._under_way = [], []
        lead_in = _lead_in(step.segment, [positions[axis] for axis in self.record.header.axes], self.rate_hz)
        if lead_in is not None:
            self._label += 1
            segments.append(replace(lead_in, label=self._label))
        for one in batch:
            self._label += 1
            # the daemon records every tick, whatever a step asks of a recording in lockstep
            segments.append(replace(one.segment, label=self._label, record_every=0))
            self._under_way.append((one, self._label))
        tick = self._client.start(program_of(segments), with_image=self._next is None)
        if self._next is None:
            self._next = self._first = tick

    def _wait(self, step: Step, label: int, progress: Callable[[int], None]) -> _Span:
        """Ticks from the step's first to its last; SafetyStopError when the host left it for another reason than its
        end.
        """
        deadline = time.monotonic() + step.segment.duration_ticks / self.rate_hz + 2.0 * self._patience_s
        told = 0
        begun = time.monotonic()
        while time.monotonic() < deadline:
            event = self._client.next_event(0.25)
            ahead = min(step.segment.duration_ticks, int((time.monotonic() - begun) * self.rate_hz))
            progress(max(0, ahead - told))
            told = max(told, ahead)
            if event is None:
                continue
            data = event.get("data", {})
            code = data.get("code")
            if code == _STARTED:
                self._started[int(data["segment"])] = int(event["tick"])
            elif code == _ENDED and data["segment"] == label:
                if data["cause"] not in _AS_PLANNED:
                    self._under_way = []
                    raise SafetyStopError(f"step {step.name!r}: {data['cause']}")
                last = int(event["tick"])
                return _Span(self._started.pop(label, last - step.segment.duration_ticks + 1), last)
            elif code == _STATE and data["to"] in _STOPPED and data["from"] == _ACTIVE:
                self._under_way = []
                raise SafetyStopError(f"step {step.name!r}: host went {event['text']}")
        self._under_way = []
        raise LinkError(f"{self.run}: step {step.name!r} did not end in its time")

    def _until_idle(self) -> None:
        end = time.monotonic() + self._patience_s
        while self._status()["host_state"] == _STOPPING and time.monotonic() < end:
            time.sleep(0.02)

    def _followed(self, step: Step, span: _Span) -> Followed:
        """The daemon's log from the end of the step before to the end of this one, once it is written: no row and no
        command is left out, so that what comes together is a run.
        """
        assert self._next is not None
        end = time.monotonic() + self._patience_s
        while True:
            run = self._log.look(self._next)
            if len(run.ticks) and int(run.ticks["tick"][-1]) >= span.last + _AFTER_TICKS:
                break
            if time.monotonic() > end:
                raise LinkError(f"{self.run}: the log does not reach tick {span.last}: is the recording switched off?")
            time.sleep(0.1)
        signals = signals_between(run, span.first, span.last)
        rows = run.ticks[run.ticks["tick"] <= span.last]
        frames = run.frames[run.frames["tick"] <= span.last]
        events = self._events_until(self._next, span.last)
        self._next = span.last + 1
        return Followed(signals, rows, frames, (), span.first, span.last - span.first + 1, logged=events)

    def _events_until(self, first: int, last: int) -> tuple[Event, ...]:
        """Events that have come up to a tick; segments are told by the runner, with what they are for."""
        self._events += [
            event for event in self._log.new_events() if event.tick >= first and event.kind is not EventKind.SEGMENT
        ]
        taken = tuple(event for event in self._events if event.tick <= last)
        self._events = [event for event in self._events if event.tick > last]
        return tuple(_beginning(event) if event.tick == self._first else event for event in taken)


def signals_between(run: RecordedRun, first: int, last: int) -> Signals:
    """Signals table columns of the ticks from `first` to `last` of a run that goes on; lost frames are interpolated."""
    from gimbal_hil.data.signals import signals_of_run

    ticks, frames = run.ticks["tick"], run.frames["tick"]
    part = replace(
        run,
        ticks=run.ticks[(ticks >= first) & (ticks <= last + _AFTER_TICKS)],
        frames=run.frames[(frames >= first) & (frames <= last + _AFTER_TICKS)],
        events=(),
        notes=(),
    )
    table = signals_of_run(part, resample=True, drop_invalid=True)
    size = min(len(table), last - first + 1)
    columns = {name: values[:size] for name, values in table.columns.items()}
    nothing = np.full(size, np.nan)
    own = run.ticks[(ticks >= first) & (ticks <= last)]
    names = run.record.header.axes
    for column, axis in zip(AXES, names, strict=True):
        for signal in ("position_ref", "rate_ref"):
            if np.all(np.isnan(own[f"{signal}_{column}"])):
                columns[f"{axis}.{signal}"] = nothing
    for axis in names:
        for signal in ("position_ref", "rate_ref", "temperature", "torque_measured"):
            columns.setdefault(f"{axis}.{signal}", nothing)
    return {"time_s": first * run.record.header.period_ns * 1e-9 + table.time_s[:size], **columns}


def _batch(steps: Sequence[Step]) -> list[Step]:
    """Steps up to one after which both axes hold a position, at least `BATCH` where there are so many."""
    batch: list[Step] = []
    for step in steps:
        batch.append(step)
        if (
            len(batch) >= BATCH
            and step.segment.outer.mode is Mode.POSITION
            and step.segment.inner.mode is Mode.POSITION
        ):
            break
    return batch


def _lead_in(segment: Segment, positions: Sequence[float], rate_hz: float) -> Segment | None:
    """A move to where the first step's absolute references begin; None where the joints are there."""
    starts = [
        _start(command, position) for command, position in zip((segment.outer, segment.inner), positions, strict=True)
    ]
    distance = max(abs(start - position) for start, position in zip(starts, positions, strict=True))
    if distance <= _LEAD_IN_RAD:
        return None
    # the fastest part of a move of least jerk is 1.875 times its mean speed
    duration = max(2.0, 1.875 * distance / _LEAD_IN_RAD_S)
    outer, inner = (move_to(start, duration) for start in starts)
    return Segment(outer, inner, duration_ticks=round((duration + 1.0) * rate_hz))


def _start(command: AxisCommand, position: float) -> float:
    led = (
        command.mode is Mode.POSITION
        and command.origin is ReferenceOrigin.ABSOLUTE
        and command.shape in (Shape.HOLD, Shape.RAMP)
    )
    return command.parameters[0] if led else position


def _beginning(event: Event) -> Event:
    """The image of the host with which this experiment's log begins."""
    if event.kind is EventKind.COMMAND and event.data.get("command") == "image":
        return replace(event, data={**event.data, BEGINS: True})
    return event


def _nothing(tick: int) -> Followed:
    return Followed({}, np.zeros(0, TICK_ROW), np.zeros(0, FRAME_ROW), (), tick, 0)
