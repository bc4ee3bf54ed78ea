"""The antenna under test, as the runner sees it: it follows one step after the other and answers what was measured.

`EmbeddedAntenna` is the virtual antenna in this process, advanced in lockstep on the compiled path; its whole state can be kept and
put back, so an experiment that was stopped goes on with the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import SafetyStopError
from gimbal_hil.experiments.experiment import Signals, Step
from gimbal_hil.host import HostEvent, HostState, Program, program_of
from gimbal_hil.host.lockstep import CompiledPath, Recorded, joined
from gimbal_hil.settings import DaemonSettings
from sim_backend.model import AntennaModel

#: how much is advanced between two looks at the clock and the keyboard
_STRETCH_TICKS = 20_000


@dataclass(frozen=True)
class Followed:
    """What a step left: signals at the full rate, rows and frames for the log, events, the ticks it took."""

    signals: Signals
    rows: NDArray[np.void]
    frames: NDArray[np.void]
    events: tuple[HostEvent, ...]
    first_tick: int
    ticks: int
    program: Program | None = None


class Antenna(Protocol):
    """What the runner needs of an antenna."""

    rate_hz: float

    @property
    def tick(self) -> int:
        """The next tick."""

    def position_rad(self, axis: str) -> float:
        """Where the joint stands, as the encoder says."""

    def connect(self) -> Followed:
        """Wait until the host is ready; LinkError when it does not come."""

    def follow(self, step: Step, progress: Callable[[int], None]) -> Followed:
        """Follow one step to its end; SafetyStopError when a guard or the antenna ended it. `progress` is told of ticks done."""

    def keep(self) -> dict[str, NDArray[np.generic]] | None:
        """The whole state for a checkpoint; None where it cannot be kept (a real antenna)."""

    def put_back(self, state: dict[str, NDArray[np.generic]]) -> None:
        """Go on from a kept state."""


class EmbeddedAntenna:
    """The virtual antenna in this process, in lockstep."""

    def __init__(self, settings: DaemonSettings, model: AntennaModel, seed: int = 0, keep_frames: bool = True) -> None:
        self.rate_hz = settings.rate_hz
        self.engine = CompiledPath(settings, model, seed=seed, keep_frames=keep_frames)

    @property
    def tick(self) -> int:
        """The next tick."""
        return self.engine.tick

    def position_rad(self, axis: str) -> float:
        """Where the joint stands, as the encoder says."""
        return float(self.engine.host.status()["axes"][axis]["position_rad"])

    def connect(self) -> Followed:
        """Bring host and drive to IDLE."""
        first = self.tick
        return _followed(self.engine.connect(), first)

    def follow(self, step: Step, progress: Callable[[int], None]) -> Followed:
        """Follow one step; the state of the host afterwards decides whether that was safe."""
        first = self.tick
        program = program_of([step.segment])
        self.engine.host.command(program)
        parts: list[Recorded] = []
        while True:
            part = self.engine.advance(_STRETCH_TICKS, until_done=True)
            parts.append(part)
            progress(part.ticks)
            if not self.engine.host.following:
                break
        followed = _followed(joined(parts), first, program)
        if self.engine.host.state is not HostState.ACTIVE and not step.segment.switch_off_afterwards:
            raise SafetyStopError(
                f"step {step.name!r}: host is {self.engine.host.state.name.lower()}, {self.engine.host.cause.name.lower()}"
            )
        return followed

    def keep(self) -> dict[str, NDArray[np.generic]]:
        """Everything that decides what comes next, of host, device and plant."""
        return {name: array.copy() for name, array in self._arrays().items()} | {
            "tick": np.array(self.engine.tick),
            "plan": self.engine.host.plan.copy(),
        }

    def put_back(self, state: dict[str, NDArray[np.generic]]) -> None:
        """Go on from a kept state."""
        for name, array in self._arrays().items():
            array[...] = state[name]
        self.engine.tick = int(state["tick"])
        self.engine.host.plan = np.ascontiguousarray(state["plan"], dtype=np.float64)
        self.engine.host.events()

    def _arrays(self) -> dict[str, NDArray[np.generic]]:
        host, device = self.engine.host, self.engine.device
        return {
            "host_integers": host.memory.integers,
            "host_floats": host.memory.floats,
            "X": device.X,
            "J": device.J,
            "device_mail": device.mail,
            "counters": self.engine.alive_counters,
        }


def _followed(recorded: Recorded, first_tick: int, program: Program | None = None) -> Followed:
    return Followed(recorded.signals(), recorded.rows, recorded.frame_rows, recorded.events, first_tick, recorded.ticks, program)
