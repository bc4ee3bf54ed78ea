"""The antenna under test, as the runner sees it: it follows one step after the other and answers what was measured.

`LockstepAntenna` is the virtual antenna in this process, advanced in lockstep: on the compiled path, or, where other
firmware answers, on that of frames. Its whole state can be kept and put back, so an experiment that was stopped goes on
with the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import SafetyStopError
from gimbal_hil.data.runs import AXES, TICK_ROW, Event
from gimbal_hil.knowledge.experiments.experiment import Signals, Step
from gimbal_hil.loop.host import HostEvent, HostState, Program, word_of
from gimbal_hil.loop.settings import DaemonSettings, EmbeddedAntenna
from gimbal_hil.realtime.lockstep import CompiledPath, FramePath, Recorded
from sim_backend.firmware import close_firmware, run_firmware
from sim_backend.firmware_run import FirmwareRun
from sim_backend.model import AntennaModel

#: how much is advanced between two looks at the clock and the keyboard
_STRETCH_TICKS = 5_000


@dataclass(frozen=True)
class Followed:
    """What a step left: signals (one row in as many ticks as the step says), rows and frames for the log, events, the
    ticks it took. `logged` are events that another log already holds, commands among them.
    """

    signals: Signals
    rows: NDArray[np.void]
    frames: NDArray[np.void]
    events: tuple[HostEvent, ...]
    first_tick: int
    ticks: int
    program: Program | None = None
    logged: tuple[Event, ...] = ()


class Columns(Mapping[str, NDArray[np.float64]]):
    """Columns of a log, each copied out of its rows when it is asked for: most steps are measured by a few of them."""

    def __init__(self, views: Mapping[str, NDArray[np.float64]]) -> None:
        self._views = views
        self._copies: dict[str, NDArray[np.float64]] = {}

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self._copies:
            self._copies[name] = self._views[name].copy()
        return self._copies[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._views)

    def __len__(self) -> int:
        return len(self._views)


class AntennaUnderTest(Protocol):
    """What the runner needs of an antenna."""

    rate_hz: float

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes, the carrying one first."""

    @property
    def tick(self) -> int:
        """The next tick."""

    def position_rad(self, axis: str) -> float:
        """Where the joint stands, as the encoder says."""

    def connect(self) -> Followed:
        """Wait until the host is ready; LinkError when it does not come."""

    def follow(self, step: Step, progress: Callable[[int], None]) -> Followed:
        """Follow one step to its end; SafetyStopError when a guard or the antenna ended it. `progress` gets the ticks
        done.
        """

    def keep(self) -> dict[str, NDArray[np.generic]] | None:
        """The whole state for a checkpoint; None where it cannot be kept (a real antenna)."""

    def put_back(self, state: dict[str, NDArray[np.generic]]) -> None:
        """Go on from a kept state."""

    def close(self) -> None:
        """Give back what it runs on."""


class LockstepAntenna:
    """The virtual antenna in this process, in lockstep; of its log one row in `log_every` ticks, with frames where that
    is every tick. Without `firmware` that of the settings is used.
    """

    def __init__(
        self,
        settings: DaemonSettings,
        model: AntennaModel,
        seed: int = 0,
        log_every: int = 1,
        firmware: FirmwareRun | None = None,
    ) -> None:
        self.rate_hz = settings.rate_hz
        self._log_every, keep_frames = log_every, log_every == 1
        if firmware is None:
            link = settings.link
            firmware = link.embedded.firmware if isinstance(link, EmbeddedAntenna) else FirmwareRun.VIRTUAL
        if firmware is FirmwareRun.VIRTUAL:
            self.engine: CompiledPath | FramePath = CompiledPath(settings, model, seed=seed, keep_frames=keep_frames)
        else:
            device = run_firmware(firmware, model, settings.rate_hz, seed)
            self.engine = FramePath(settings, model, seed, device=device, keep_frames=keep_frames)

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes, the carrying one first."""
        return self.engine.host.axes

    @property
    def tick(self) -> int:
        """The next tick."""
        return self.engine.tick

    def position_rad(self, axis: str) -> float:
        """Where the joint stands, as the encoder says."""
        return float(self.engine.host.status()["axes"][axis]["position_rad"])

    def connect(self) -> Followed:
        """Bring host and drive to IDLE."""
        return _joined([_part_of(self.engine.connect(), 1, self._log_every)], self.tick)

    def follow(self, step: Step, progress: Callable[[int], None]) -> Followed:
        """Follow one step; the state of the host afterwards decides whether that was safe."""
        first = self.tick
        self.engine.host.command(step.program)
        stretch = max(1, _STRETCH_TICKS // step.every) * step.every
        parts: list[Followed] = []
        while True:
            recorded = self.engine.advance(stretch, until_done=True)
            parts.append(_part_of(recorded, step.every, self._log_every))
            progress(recorded.ticks)
            if not self.engine.host.following:
                break
        followed = _joined(parts, first, step.program)
        if self.engine.host.state is not HostState.ACTIVE and not step.segment.switch_off_afterwards:
            raise SafetyStopError(
                f"stopped in step {step.name!r} by {word_of(self.engine.host.cause).replace('_', ' ')}"
            )
        return followed

    def keep(self) -> dict[str, NDArray[np.generic]]:
        """Everything that decides what comes next, of host, device and plant."""
        return {name: array.copy() for name, array in self._arrays().items()} | {
            "tick": np.array(self.engine.tick),
            "plan": self.engine.host.plan.copy(),
            "answer": np.frombuffer(self.engine.answer if isinstance(self.engine, FramePath) else b"", np.uint8),
        }

    def put_back(self, state: dict[str, NDArray[np.generic]]) -> None:
        """Go on from a kept state."""
        for name, array in self._arrays().items():
            array[...] = state[name]
        self.engine.tick = int(state["tick"])
        self.engine.host.plan = np.ascontiguousarray(state["plan"], dtype=np.float64)
        self.engine.host.events()
        if isinstance(self.engine, FramePath):
            self.engine.answer = state["answer"].tobytes()

    def close(self) -> None:
        """Give back what the firmware runs on."""
        close_firmware(self.engine.device)

    def _arrays(self) -> dict[str, NDArray[np.generic]]:
        host, engine = self.engine.host, self.engine
        arrays = {"host_integers": host.memory.integers, "host_floats": host.memory.floats, **engine.device.arrays}
        return arrays if isinstance(engine, FramePath) else arrays | {"counters": engine.alive_counters}


def _part_of(recorded: Recorded, every: int, log_every: int) -> Followed:
    """A stretch as signals and log rows, each thinned in its own way; a last block that is not whole gives no row of
    signals.
    """
    signals = Columns(recorded.columns()) if every == 1 else _in_blocks(recorded, every)
    logged = recorded if log_every == 1 else _rows_of(recorded, recorded.log[:, 0] % log_every == 0)
    return Followed(signals, logged.rows, recorded.frame_rows, recorded.events, 0, recorded.ticks)


def _in_blocks(recorded: Recorded, every: int) -> Signals:
    """Signals of the first tick of each block; torque, which is held, as its mean over the block: that is what acts
    until the next row.
    """
    blocks = len(recorded.log) // every
    signals = _rows_of(recorded, slice(0, blocks * every, every)).signals()
    words = recorded.log[: blocks * every].view(np.float64)
    for own, axis in zip(AXES, recorded.axes, strict=True):
        held = np.ascontiguousarray(words[:, _word_of(f"torque_{own}")])
        signals[f"{axis}.torque"] = held.reshape(blocks, every).mean(axis=1)
    return signals


def _word_of(column: str) -> int:
    """Place of a 64-bit column of a tick row."""
    return sum(TICK_ROW[name].itemsize for name in (TICK_ROW.names or ())[: (TICK_ROW.names or ()).index(column)]) // 8


def _rows_of(recorded: Recorded, rows: slice | NDArray[np.bool_]) -> Recorded:
    return replace(recorded, log=np.ascontiguousarray(recorded.log[rows]))


def _joined(parts: Sequence[Followed], first_tick: int, program: Program | None = None) -> Followed:
    if len(parts) == 1:
        return replace(parts[0], first_tick=first_tick, program=program)
    return Followed(
        {name: np.concatenate([part.signals[name] for part in parts]) for name in parts[0].signals},
        np.concatenate([part.rows for part in parts]),
        np.concatenate([part.frames for part in parts]),
        tuple(event for part in parts for event in part.events),
        first_tick,
        sum(part.ticks for part in parts),
        program,
    )
