"""Simulated drives in real time: their plant ticks between the host's frames, at whatever phase the host began."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.adapters import CanFrame, UnixCanBus
from sim_backend.drives import DriveServer
from tests.adapters.rig import PERIOD_NS, RATE_HZ

pytestmark = [pytest.mark.realtime]


class Clock:
    """A clock and a bus of a test: at each look time goes on, and frames of the host come at theirs."""

    def __init__(self, asked_ns: list[int], step_ns: int) -> None:
        self.now_ns, self._asked, self._step_ns = 0, list(asked_ns), step_ns

    def fileno(self) -> int:
        return -1

    def due(self) -> list[int]:
        due = [at for at in self._asked if at <= self.now_ns]
        self._asked = self._asked[len(due) :]
        return due

    def receive(self) -> list[CanFrame]:
        return [CanFrame(1, b"")] * len(self.due())

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


class Timed(UnixCanBus):
    """The socket of a test, which tells when each frame was sent."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock

    def fileno(self) -> int:
        return -1

    def send(self, frame: CanFrame) -> bool:
        return True

    def arrivals(self) -> list[tuple[int, CanFrame]]:
        return [(at, CanFrame(1, b"")) for at in self._clock.due()]


def test_a_late_server_answers_with_the_motion_of_when_it_was_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    # it looks every 2.3 periods
    clock, gimbal = Clock([round((k + 0.3) * PERIOD_NS) for k in range(400)], round(2.3 * PERIOD_NS)), Counting()
    monkeypatch.setattr("sim_backend.drives.serving.time", clock)
    monkeypatch.setattr("sim_backend.drives.serving.select.poll", NoPoll)
    DriveServer(gimbal, Timed(clock), RATE_HZ).serve(400 * PERIOD_NS)  # type: ignore[arg-type]
    settled = np.diff(gimbal.asked_at[100:])
    assert len(settled) > 280 and (settled == 1).all()


def test_the_socket_tells_when_each_frame_was_sent(tmp_path: Path) -> None:
    near = UnixCanBus(tmp_path / "bus", listen=True)
    far = UnixCanBus(tmp_path / "bus")
    try:
        assert near.arrivals() == []  # the peer has come
        before = time.monotonic_ns()
        far.send(CanFrame(1, b"a"))
        between = time.monotonic_ns()
        time.sleep(0.05)
        ((sent_ns, frame),) = near.arrivals()
        slack_ns = 5_000_000  # between the two clocks that are read one after the other
        assert frame.data == b"a" and before - slack_ns <= sent_ns <= between + slack_ns
    finally:
        far.close()
        near.close()
