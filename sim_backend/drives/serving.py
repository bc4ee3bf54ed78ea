"""Simulated drives in real time on a bus: frames are answered as they come, the plant ticks at absolute deadlines."""

from __future__ import annotations

import select
import time
from dataclasses import dataclass

from firmware_protocol.adapters import Bus, CanFrame, UnixCanBus
from sim_backend.drives.gimbal import DrivenGimbal

#: periods that nobody was awake for are passed over beyond so many
_MOST_CAUGHT_UP = 50
#: share of its distance by which a tick moves towards its place before the frames of the host, and that place
_FOLLOWED, _AHEAD = 1 / 16, 1 / 4
#: share of a period by which one frame moves a tick at most
_MOST_MOVED = 1 / 256


@dataclass
class ServedDrives:
    """What was served."""

    ticks: int = 0
    frames_received: int = 0
    frames_sent: int = 0
    frames_dropped: int = 0
    skipped: int = 0


class DriveServer:
    """Serves until `stop`, or for a time.

    A tick falls a quarter of a period before the host's frames: whoever asks up to three quarters late, which is what
    happens on a machine with other work, or a quarter early finds the motion of his own tick. A plant that ticked as
    often, but at any phase, would show him the same tick twice and then none.
    """

    def __init__(self, gimbal: DrivenGimbal, bus: Bus, rate_hz: float) -> None:
        self._gimbal, self._bus, self._period_ns = gimbal, bus, round(1e9 / rate_hz)
        self._stopped = False
        self._deadline = 0
        self.statistics = ServedDrives()

    def stop(self) -> None:
        """End the serving with the next frame or tick."""
        self._stopped = True

    def serve(self, duration_ns: int | None = None) -> None:
        """Answer frames and tick; a bus that is gone ends it with OSError."""
        poll = select.poll()
        registered = -1
        begun = self._deadline = time.monotonic_ns()
        while not self._stopped and (duration_ns is None or time.monotonic_ns() - begun < duration_ns):
            descriptor = self._bus.fileno()
            if descriptor != registered:
                poll = select.poll()
                if descriptor >= 0:
                    poll.register(descriptor, select.POLLIN)
                registered = descriptor
            left_ns = self._deadline + self._period_ns - time.monotonic_ns()
            if left_ns > 0:
                poll.poll(left_ns / 1e6)
            now = time.monotonic_ns()
            # each frame finds the motion of when it was sent, however late this process is
            for sent_ns, frame in self._arrivals(now):
                self._catch_up(sent_ns)
                self.statistics.frames_received += 1
                self._send(self._gimbal.hear([frame]))
                self._follow(sent_ns)
            self._catch_up(now)

    def _follow(self, sent_ns: int) -> None:
        """Move the ticks towards their place before a frame; where many are late, their usual place, not their mean."""
        behind = _FOLLOWED * (sent_ns - self._deadline - _AHEAD * self._period_ns)
        most = _MOST_MOVED * self._period_ns
        self._deadline += round(min(max(behind, -most), most))

    def _arrivals(self, now: int) -> list[tuple[int, CanFrame]]:
        """Frames that came, with the time at which they were sent; a real bus tells none, and its look is taken."""
        if isinstance(self._bus, UnixCanBus):
            return self._bus.arrivals()
        return [(now, frame) for frame in self._bus.receive()]

    def _catch_up(self, now: int) -> None:
        due = (now - self._deadline) // self._period_ns
        if due > _MOST_CAUGHT_UP:
            self.statistics.skipped += due - _MOST_CAUGHT_UP
            self._deadline += (due - _MOST_CAUGHT_UP) * self._period_ns
            due = _MOST_CAUGHT_UP
        for _ in range(due):
            self._deadline += self._period_ns
            self.statistics.ticks += 1
            self._send(self._gimbal.tick())

    def _send(self, frames: list[CanFrame]) -> None:
        for frame in frames:
            if self._bus.send(frame):
                self.statistics.frames_sent += 1
            else:
                self.statistics.frames_dropped += 1
