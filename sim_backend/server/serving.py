"""The virtual antenna on a link in real time: one thread, one loop, never a wait for a peer."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from firmware_protocol.links import Link, LinkState
from firmware_protocol.schema import BY_NAME, RECORD_SIZE
from sim_backend.device import Device
from sim_backend.server.schedule import TickCause, TickSchedule

_SET_POINT = BY_NAME["set_point"].can_id.to_bytes(2, "little")
#: between attempts to open a lost port again
_REOPEN_NS = 100_000_000
#: the antenna is carried over at most this many missed periods: its deadman has stopped it long before
_MOST_PASSED_OVER = 2000


@dataclass(slots=True)
class ServingStatistics:
    """What the server did; ticks are either the host's or the antenna's own."""

    period_ns: int
    ticks_by_set_point: int = 0
    ticks_by_own_clock: int = 0
    #: periods that passed while this process could not run, and how many of them the antenna was carried over
    skipped: int = 0
    passed_over: int = 0
    #: set-points that came together with a later one and so did not get a tick of their own
    merged: int = 0
    link: str = ""
    frames_received: int = 0
    frames_sent: int = 0
    frames_dropped: int = 0
    malformed: int = 0
    bad_frames: int = 0
    repeated_frames: int = 0
    refused_set_points: int = 0
    losses: int = 0
    state: str = ""
    fault: str = ""

    @property
    def ticks(self) -> int:
        """All ticks."""
        return self.ticks_by_set_point + self.ticks_by_own_clock + self.passed_over

    def complete(self, device: Device, link: Link) -> None:
        """Put in what link and device have counted."""
        counts = link.statistics
        self.frames_received, self.frames_sent = counts.frames_received, counts.frames_sent
        self.frames_dropped, self.malformed, self.losses = counts.frames_dropped, counts.malformed, counts.losses
        self.bad_frames, self.repeated_frames = device.bad_frames, device.repeated_frames
        self.refused_set_points = device.set_points[1]
        self.state = device.state.name.lower()
        self.fault = device.fault.name.lower()

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        counts = {name: getattr(self, name) for name in self.__slots__ if name != "period_ns"}
        return {"period_us": self.period_ns / 1e3, "ticks": self.ticks, **counts}


class DeviceServer:
    """Serves a device on a link until told to stop. Peers may come, go and come back; the antenna goes on."""

    def __init__(self, device: Device, link: Link, now_ns: Callable[[], int] = time.monotonic_ns) -> None:
        self.device, self.link = device, link
        self._now_ns = now_ns
        self._stopping = False
        self._pending: list[bytes] = []
        self._waiting = 0
        self._reopen_at_ns = 0
        self.statistics = ServingStatistics(round(1e9 / device.rate_hz), link=link.name)

    def stop(self) -> None:
        """End `serve` at its next tick; may be called from a signal handler."""
        self._stopping = True

    def serve(self, duration_ns: int | None = None) -> ServingStatistics:
        """Tick in real time for `duration_ns` (for ever when None) or until `stop`; answers the statistics."""
        statistics, now_ns = self.statistics, self._now_ns
        start = now_ns()
        end = None if duration_ns is None else start + duration_ns
        schedule = TickSchedule(statistics.period_ns, start)
        while not self._stopping:
            self._listen()
            now = now_ns()
            if end is not None and now >= end:
                break
            before = schedule.skipped
            cause = schedule.due(now, self._waiting > 0)
            if cause is None:
                self._sleep_until(schedule.next_ns(self._waiting > 0))
            else:
                self._tick(cause, schedule.skipped - before)
        statistics.skipped = schedule.skipped
        statistics.complete(self.device, self.link)
        return statistics

    def _listen(self) -> None:
        if self.link.state is LinkState.LOST and self._now_ns() >= self._reopen_at_ns:
            self.link.reopen()
            self._reopen_at_ns = self._now_ns() + _REOPEN_NS
        block = self.link.receive()
        if block:
            self._pending.append(block)
            self._waiting += _set_points(block)

    def _tick(self, cause: TickCause, missed: int) -> None:
        """One tick, after those of the periods that were missed: an antenna's time does not stand still while this
        process does. Set-points that came meanwhile each get a tick, as they would have.
        """
        passed_over = min(missed, _MOST_PASSED_OVER)
        for block in _dealt(b"".join(self._pending), passed_over + 1):
            self.link.send(self.device.tick(block))
        if cause is TickCause.SET_POINT:
            self.statistics.ticks_by_set_point += 1
        else:
            self.statistics.ticks_by_own_clock += 1
        self.statistics.passed_over += passed_over
        self.statistics.merged += max(0, self._waiting - 1 - passed_over)
        self._pending.clear()
        self._waiting = 0

    def _sleep_until(self, instant_ns: int) -> None:
        left = instant_ns - self._now_ns()
        if left > 0 and not self.link.wait(left):
            # a lost link has nothing to wait on and says so at once
            left = instant_ns - self._now_ns()
            if left > 0:
                time.sleep(left * 1e-9)


def _set_points(block: bytes) -> int:
    """How many frames of a block claim to be set-points; whether they are good is the device's business."""
    return sum(block.startswith(_SET_POINT, at) for at in range(0, len(block), RECORD_SIZE))


def _dealt(block: bytes, ticks: int) -> list[bytes]:
    """A block in as many pieces as there are ticks: the newest set-point, with what came since the one before it, is
    the last tick's, and so on backwards; what is older than that many set-points is the first one's.
    """
    pieces: list[bytes] = []
    ends = [at + RECORD_SIZE for at in range(0, len(block), RECORD_SIZE) if block.startswith(_SET_POINT, at)]
    end = len(block)
    for before in reversed(ends[:-1][1 - ticks :] if ticks > 1 else []):
        pieces.append(block[before:end])
        end = before
    pieces.append(block[:end])
    return [b""] * (ticks - len(pieces)) + pieces[::-1]
