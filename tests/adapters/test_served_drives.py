"""Simulated drives in real time: their plant ticks between the host's frames, at whatever phase the host began."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_protocol.adapters import CanFrame
from sim_backend.drives import DriveServer
from tests.adapters.rig import PERIOD_NS, RATE_HZ


class Clock:
    """A clock and a bus of a test: at each look time goes on, and frames of the host come at theirs."""

    def __init__(self, asked_ns: list[int], step_ns: int) -> None:
        self.now_ns, self._asked, self._step_ns = 0, list(asked_ns), step_ns

    def fileno(self) -> int:
        return -1

    def receive(self) -> list[CanFrame]:
        due = [at for at in self._asked if at <= self.now_ns]
        self._asked = self._asked[len(due) :]
        return [CanFrame(1, b"")] * len(due)

    def send(self, frame: CanFrame) -> bool:
        return True

    def monotonic_ns(self) -> int:
        self.now_ns += self._step_ns
        return self.now_ns


class NoPoll:
    """Waits for nothing: the clock goes on by itself."""

    def poll(self, _timeout_ms: float) -> list[tuple[int, int]]:
        return []


class Counting:
    """A gimbal that notes at which of its ticks it was asked."""

    def __init__(self) -> None:
        self.ticks, self.asked_at = 0, list[int]()

    def hear(self, frames: list[CanFrame]) -> list[CanFrame]:
        self.asked_at += [self.ticks] * len(frames)
        return []

    def tick(self) -> list[CanFrame]:
        self.ticks += 1
        return []


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.49, 0.5, 0.97])
def test_whoever_asks_once_a_period_finds_each_tick_once_however_he_is_late(
    monkeypatch: pytest.MonkeyPatch, phase: float
) -> None:
    random = np.random.default_rng(5)
    late = np.where(random.random(400) < 0.02, random.uniform(0.4, 0.6, 400), random.uniform(0.0, 0.2, 400))
    asked = [round((number + phase + late[number]) * PERIOD_NS) for number in range(400)]
    clock, gimbal = Clock(asked, 20_000), Counting()
    monkeypatch.setattr("sim_backend.drives.serving.time", clock)
    monkeypatch.setattr("sim_backend.drives.serving.select.poll", NoPoll)
    DriveServer(gimbal, clock, RATE_HZ).serve(400 * PERIOD_NS)  # type: ignore[arg-type]
    settled = np.diff(gimbal.asked_at[100:])
    assert (settled == 1).all() and abs(gimbal.ticks - 400) <= 2
