"""An antenna that does what a test says: no dynamics, every step takes its time and leaves rows; it fails where it is
told to.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.runs import FRAME_ROW, tick_rows
from gimbal_hil.knowledge.experiments.antenna import Followed
from gimbal_hil.knowledge.experiments.experiment import Experiment, Row, Signals, Step, move_to, step_of

RATE_HZ = 1000.0


class ScriptedAntenna:
    """Remembers the steps it was asked to follow; `failures` raises at a step's name."""

    rate_hz = RATE_HZ
    axes = ("outer", "inner")

    def __init__(self, failures: dict[str, BaseException] | None = None, position: float = 0.0) -> None:
        self.tick = 0
        self.followed: list[str] = []
        self._failures = failures or {}
        self._position = position

    def position_rad(self, axis: str) -> float:
        return self._position

    def connect(self) -> Followed:
        return self._ticks(5)

    def follow(self, step: Step, progress: Callable[[int], None]) -> Followed:
        self.followed.append(step.name)
        if step.name in self._failures:
            raise self._failures[step.name]
        progress(step.segment.duration_ticks)
        return self._ticks(step.segment.duration_ticks)

    def keep(self) -> dict[str, NDArray[np.generic]]:
        return {"tick": np.array(self.tick)}

    def put_back(self, state: dict[str, NDArray[np.generic]]) -> None:
        self.tick = int(state["tick"])

    def close(self) -> None:
        """Nothing to give back."""

    def _ticks(self, count: int) -> Followed:
        rows = tick_rows(count)
        rows["tick"] = np.arange(self.tick, self.tick + count)
        first, self.tick = self.tick, self.tick + count
        return Followed({"time_s": rows["tick"] / RATE_HZ}, rows, np.zeros(0, FRAME_ROW), (), first, count)


def waiting_experiment(names: tuple[str, ...] = ("one", "two", "three")) -> Experiment:
    """Steps that hold still for 50 ms and are measured by their first instant."""
    still = (move_to(0.0, 0.05), move_to(0.0, 0.05))
    steps = tuple(step_of(name, RATE_HZ, 0.05, still, {"name": name}, measured=True) for name in names)
    return Experiment("waiting", "Waiting", steps, _first_instant, lambda rows, drawn: [])


def _first_instant(step: Step, signals: Signals) -> Row:
    return {"first_s": float(signals["time_s"][0])}
