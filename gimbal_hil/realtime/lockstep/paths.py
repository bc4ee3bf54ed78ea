"""Host and virtual antenna in lockstep, two ways with one face and the same bits.

`FramePath` passes every tick's blocks through codec and link, and may have faults in the link. `CompiledPath` calls the
same two cores in one compiled loop. Tick n of both: the host takes the feedback sampled at t_n and sends set-point n;
the device acts on it until t_n+1.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.block_codec import new_counters
from firmware_protocol.errors import LinkError
from firmware_protocol.links import FaultsConfig, FaultyLink, memory_pair
from firmware_protocol.lockstep import Ticking
from gimbal_hil.data.runs import AXES, FRAME_ROW, TICK_ROW, FrameDirection, frames_of_blocks
from gimbal_hil.loop.host import LOG_WORDS, MEASURED, ROW_WORDS, ROWS_KEPT, Host, HostEvent, HostState, Program, layout
from gimbal_hil.loop.settings import DaemonSettings, host_configuration
from gimbal_hil.realtime.lockstep.compiled_run import FRAME_WORDS, MOST_FRAMES, run_ticks
from gimbal_hil.realtime.lockstep.frame_run import run_blocks
from sim_backend.device import Device
from sim_backend.model import AntennaModel

#: rows that one compiled call fills at most
CHUNK_ROWS = 65536
#: ticks after which events are taken out of their ring, where a tick is a call of its own
_LOOK_TICKS = 32
_BASE = ("roll", "pitch", "yaw", "p", "q", "r")
#: told of every tick on the frame path: tick, block received, block sent
Exchange = Callable[[int, bytes, bytes], None]


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """What a stretch of lockstep left: `log` int64 (n, LOG_WORDS), frame rows int64 (m, 3) where frames were kept,
    events, ticks run.
    """

    log: NDArray[np.int64]
    ticks: int
    step_s: float
    frames: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, FRAME_WORDS), dtype=np.int64))
    events: tuple[HostEvent, ...] = ()
    axes: tuple[str, ...] = AXES

    @property
    def rows(self) -> NDArray[np.void]:
        """Tick rows, `runs.TICK_ROW`."""
        return np.ascontiguousarray(self.log[:, :ROW_WORDS]).reshape(-1).view(TICK_ROW)

    @property
    def frame_rows(self) -> NDArray[np.void]:
        """Frames, `runs.FRAME_ROW`."""
        return np.ascontiguousarray(self.frames).reshape(-1).view(FRAME_ROW)

    @property
    def segment(self) -> NDArray[np.int64]:
        """Label of the segment that each row belongs to, -1 for none."""
        return self.rows["segment"].astype(np.int64)

    def signals(self) -> dict[str, NDArray[np.float64]]:
        """Columns of the signals table (docs/reference/signals-table.md), references included with NaN where a loop had
        none.
        """
        return {name: column.copy() for name, column in self.columns().items()}

    def columns(self) -> dict[str, NDArray[np.float64]]:
        """`signals` as views of the log, for who asks for few of them."""
        rows, measured = self.rows, self.log.view(np.float64)[:, MEASURED:]
        columns = {"time_s": rows["tick"] * self.step_s}
        for axis, (own, name) in enumerate(zip(AXES, self.axes, strict=True)):
            columns[f"{name}.torque"] = rows[f"torque_{own}"]
            for place, signal in enumerate(("position", "rate", "torque_measured", "temperature")):
                columns[f"{name}.{signal}"] = measured[:, 2 * place + axis]
            columns[f"{name}.position_ref"] = rows[f"position_ref_{own}"]
            columns[f"{name}.rate_ref"] = rows[f"rate_ref_{own}"]
        for place, signal in enumerate(_BASE):
            columns[f"base.{signal}"] = measured[:, 8 + place]
        return columns


class Lockstep(Protocol):
    """An antenna and its host, advanced together."""

    host: Host
    device: Device
    tick: int

    def advance(self, ticks: int, *, until_done: bool = False, every: int = 1) -> Recorded:
        """Run `ticks` ticks; with `until_done` stop after the tick that ends the program; a log row every `every`
        ticks.
        """


class _Engine(ABC):
    """What both paths share."""

    def __init__(
        self, settings: DaemonSettings, model: AntennaModel, seed: int = 0, device: Device | None = None
    ) -> None:
        self.settings = settings.for_axes(model.axes, model.where)
        self.host = Host(host_configuration(settings), self.settings.axis_names)
        self.device = device or Device(model, rate_hz=settings.rate_hz, seed=seed)
        self.step_ns = round(1e9 / settings.rate_hz)
        self.tick = 0

    @abstractmethod
    def advance(self, ticks: int, *, until_done: bool = False, every: int = 1) -> Recorded:
        """See `Lockstep`."""

    def connect(self, most_s: float = 10.0) -> Recorded:
        """Advance until the host is IDLE and measures at this tick; LinkError when that takes too long."""
        parts = []
        for _ in range(max(1, round(most_s * self.settings.rate_hz))):
            parts.append(self.advance(1))
            if self.host.state is HostState.IDLE:
                return joined(parts)
        raise LinkError(f"virtual antenna: host is {self.host.state.name.lower()} after {most_s:g} s of connecting")

    def _recorded(
        self, first: int, logs: list[NDArray[np.int64]], frames: list[NDArray[np.int64]], events: list[HostEvent]
    ) -> Recorded:
        """What the ticks from number `first` to this one left."""
        return Recorded(
            _stacked(logs, LOG_WORDS),
            self.tick - first,
            1.0 / self.settings.rate_hz,
            _stacked(frames, FRAME_WORDS),
            tuple(events),
            self.host.axes,
        )

    def run(self, program: Program, *, most_ticks: int = 1 << 40, every: int = 1) -> Recorded:
        """Follow a program to its end (or the fault that ends it) and answer what was recorded."""
        self.host.command(program)
        return self.advance(most_ticks, until_done=True, every=every)


class FramePath(_Engine):
    """Every byte through encoder, link and decoder. `exchange` is told of every tick, for a recorder; with
    `keep_frames` what is recorded holds the frames too.
    """

    def __init__(
        self,
        settings: DaemonSettings,
        model: AntennaModel,
        seed: int = 0,
        faults: FaultsConfig | None = None,
        exchange: Exchange | None = None,
        device: Device | None = None,
        keep_frames: bool = False,
    ) -> None:
        super().__init__(settings, model, seed, device)
        self._exchange = exchange
        self._keep_frames = keep_frames
        self._remote: Ticking = self.device
        near, self._far = memory_pair()
        #: without faults a link of one block: what the device answered last
        self._link = None if faults is None else FaultyLink(near, faults)
        #: that answer; it is what the host has not heard yet
        self.answer = b""

    def with_remote(self, remote: Ticking) -> Self:
        """With an antenna behind a link in place of `device`, which then only says what is known of it."""
        self._remote = remote
        return self

    def advance(self, ticks: int, *, until_done: bool = False, every: int = 1) -> Recorded:
        """See `Lockstep`."""
        host, first = self.host, self.tick
        # other firmware is a device too, with a tick of its own
        own_tick = self._remote is self.device and type(self.device).tick is Device.tick
        alone = own_tick and self._link is None and self._exchange is None
        host.take_log()
        logs, kept = [], []
        events: list[HostEvent] = []
        while self.tick < first + ticks:
            # no more than the host's log holds
            some = min(first + ticks - self.tick, ROWS_KEPT)
            kept.append(self._in_one_call(some, until_done) if alone else self._tick_by_tick(some, until_done, events))
            logs.append(self._decimated(host.take_log(), every))
            events += host.events()
            if until_done and not host.following:
                break
        return self._recorded(first, logs, kept, events)

    def _in_one_call(self, ticks: int, until_done: bool) -> NDArray[np.int64]:
        """Up to `ticks` ticks where nobody looks between; answers their frames."""
        host, device = self.host, self.device
        frames = np.empty((MOST_FRAMES * ticks if self._keep_frames else 0, FRAME_WORDS), dtype=np.int64)
        counts = np.array((len(self.answer), 0))
        octets = host.memory.octets
        octets[: len(self.answer)] = np.frombuffer(self.answer, np.uint8)
        self.tick += run_blocks(
            host.memory.words,
            host.plan,
            device.words,
            device.x_size,
            frames,
            counts,
            self.tick,
            ticks,
            self.step_ns,
            until_done,
        )
        self.answer = octets[: counts[0]].tobytes()
        # a copy: room is for many more frames than a tick has, and would be kept to the end
        return frames[: counts[1]].copy()

    def _tick_by_tick(self, ticks: int, until_done: bool, events: list[HostEvent]) -> NDArray[np.int64]:
        """Up to `ticks` ticks through a link with faults, to another antenna, or with somebody told of each; answers
        their frames, and adds to `events` before their ring is full.
        """
        host, link, far, exchange, step_ns = self.host, self._link, self._far, self._exchange, self.step_ns
        host_tick, device_tick, first = host.tick, self._remote.tick, self.tick
        blocks: list[bytes] = []
        for tick in range(first, first + ticks):
            received = self.answer if link is None else link.receive()
            sent = host_tick(tick, tick * step_ns, received)
            if link is None:
                self.answer = device_tick(sent)
            else:
                link.send(sent)
                far.send(device_tick(far.receive()))
            if exchange is not None:
                exchange(tick, received, sent)
            if self._keep_frames:
                blocks += (received, sent)
            if tick % _LOOK_TICKS == _LOOK_TICKS - 1:
                events += host.events()
            self.tick = tick + 1
            if until_done and not host.following:
                break
        return _frames_of(first, blocks)

    def _decimated(self, log: NDArray[np.int64], every: int) -> NDArray[np.int64]:
        """Rows that the decimation keeps: that of the segment where it says so."""
        plan, length = self.host.plan, int(self.host.memory.G[layout.PLAN_LENGTH])
        asking = [
            at
            for at in range(0, length * layout.SEGMENT_SIZE, layout.SEGMENT_SIZE)
            if plan[at + layout.RECORD_EVERY] > 0
        ]
        if every == 1 and not asking:
            return log
        labels, wanted = Recorded(log, len(log), 0.0).segment, np.full(len(log), every)
        for at in asking:
            wanted[labels == plan[at + layout.SEGMENT_ID]] = int(plan[at + layout.RECORD_EVERY])
        return log[log[:, 0] % wanted == 0]


class CompiledPath(_Engine):
    """One compiled loop; frames are encoded only with `keep_frames`."""

    def __init__(
        self,
        settings: DaemonSettings,
        model: AntennaModel,
        seed: int = 0,
        keep_frames: bool = False,
        device: Device | None = None,
    ) -> None:
        super().__init__(settings, model, seed, device)
        self.alive_counters = new_counters()
        self._octets = np.zeros(512, dtype=np.uint8)
        self._keep_frames = keep_frames

    def advance(self, ticks: int, *, until_done: bool = False, every: int = 1) -> Recorded:
        """See `Lockstep`."""
        host, device = self.host, self.device
        logs, kept, events = [], [], []
        counts = np.zeros(2, dtype=np.int64)
        first, end = self.tick, self.tick + ticks
        while self.tick < end:
            chunk = min(end - self.tick, CHUNK_ROWS * every)
            rows = np.empty((min(chunk, CHUNK_ROWS), LOG_WORDS), dtype=np.int64)
            frames = np.empty(
                (MOST_FRAMES * min(chunk, CHUNK_ROWS) if self._keep_frames else 0, FRAME_WORDS), dtype=np.int64
            )
            self.tick += run_ticks(
                host.memory.words,
                host.plan,
                device.P,
                device.K,
                device.X,
                device.drive_words,
                self.alive_counters,
                rows,
                frames,
                self._octets,
                counts,
                self.tick,
                chunk,
                self.step_ns,
                every,
                until_done,
            )
            # a full buffer is handed on as it is, without a copy
            logs.append(rows if counts[0] == len(rows) else rows[: counts[0]])
            kept.append(frames[: counts[1]])
            events += host.events()
            if until_done and not host.following:
                break
        return self._recorded(first, logs, kept, events)


def joined(parts: list[Recorded]) -> Recorded:
    """Stretches one after the other as one."""
    return Recorded(
        _stacked([part.log for part in parts], LOG_WORDS),
        sum(part.ticks for part in parts),
        parts[0].step_s,
        _stacked([part.frames for part in parts], FRAME_WORDS),
        tuple(event for part in parts for event in part.events),
        parts[0].axes,
    )


def _frames_of(first: int, blocks: list[bytes]) -> NDArray[np.int64]:
    """Frame rows of what was received and sent from tick `first` on."""
    count = len(blocks) // 2
    ticks = np.repeat(np.arange(first, first + count), 2)
    directions = np.tile([int(FrameDirection.DEVICE_TO_HOST), int(FrameDirection.HOST_TO_DEVICE)], count)
    return frames_of_blocks(ticks, directions, blocks).view(np.int64).reshape(-1, FRAME_WORDS)


def _stacked(arrays: list[NDArray[np.int64]], words: int) -> NDArray[np.int64]:
    # a view is copied, so that it does not keep a whole buffer alive
    if len(arrays) == 1 and arrays[0].base is None:
        return arrays[0]
    return np.concatenate(arrays) if arrays else np.zeros((0, words), dtype=np.int64)
