"""Whoever interrupts an experiment through a daemon is heard in every phase of a step: the connection ends at once."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from gimbal_hil.knowledge.experiments import daemon_antenna
from tests.experiments.scripted_antenna import waiting_experiment

#: what the antenna waits for in a step, in order
PHASES = ("handing it over", "its end", "its log")


class Daemon:
    """Client and log of a daemon at which one phase is interrupted."""

    axes = ("outer", "inner")

    def __init__(self, interrupted: str) -> None:
        self._interrupted, self.closed, self.moves = interrupted, False, False
        self.record = SimpleNamespace(header=SimpleNamespace(axes=self.axes, period_ns=1_000_000))
        self._events: list[dict[str, Any]] = []

    def request(self, command: str) -> dict[str, Any]:
        return {"status": {"tick": 7, "host_state": "idle", "position_rad": dict.fromkeys(self.axes, 0.0)}}

    def start(self, program: Any, with_image: bool) -> int:
        self._reaches("handing it over")
        self.moves = True
        for code, tick in (("segment_started", 8), ("segment_ended", 58)):
            for number in (1, 2, 3, 4):
                self._events.append({"tick": tick, "data": {"code": code, "segment": number, "cause": "duration"}})
        return 8

    def next_event(self, within_s: float) -> dict[str, Any] | None:
        self._reaches("its end")
        return self._events.pop(0) if self._events else None

    def look(self, first: int) -> Any:
        self._reaches("its log")
        raise AssertionError("one phase is interrupted")

    def close(self) -> None:
        self.closed = True

    def _reaches(self, phase: str) -> None:
        if phase == self._interrupted:
            raise KeyboardInterrupt


@pytest.mark.parametrize("phase", PHASES)
def test_a_connection_ends_with_the_interruption(phase: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    daemon = Daemon(phase)
    monkeypatch.setattr(daemon_antenna, "GrowingLog", lambda run: daemon)
    monkeypatch.setattr(daemon_antenna, "OperatorClient", lambda run, timeout_s: daemon)
    steps = waiting_experiment().steps
    antenna = daemon_antenna.DaemonAntenna(tmp_path, steps)
    with pytest.raises(KeyboardInterrupt):
        antenna.follow(steps[0], lambda ticks: None)
    assert daemon.closed and daemon.moves == (phase != PHASES[0])
