"""When the antenna's next tick is due: at the host's set-point, or by its own clock when none comes. Whole nanoseconds,
no clock.
"""

from __future__ import annotations

from enum import Enum


class TickCause(Enum):
    """What made a tick due."""

    SET_POINT = "set_point"
    OWN_CLOCK = "own_clock"


class TickSchedule:
    """Decides when to tick; the caller tells the time and whether a set-point waits.

    A set-point is the clock edge: its tick is due at once. Half a period is left for its jitter, then the antenna ticks
    by itself, at absolute deadlines one period apart. Edges closer than half a period belong to one tick, so that the
    antenna's time keeps to the wall's when a host is late once. Periods that nobody was awake for are counted; the
    phase is kept.
    """

    def __init__(self, period_ns: int, start_ns: int) -> None:
        self.period_ns = period_ns
        self.skipped = 0
        self._last_ns = start_ns
        self._own_ns = start_ns + period_ns

    def next_ns(self, set_point_waits: bool) -> int:
        """The instant up to which there is nothing to do unless something is received."""
        return min(self._edge_ns(), self._own_ns) if set_point_waits else self._own_ns

    def due(self, now_ns: int, set_point_waits: bool) -> TickCause | None:
        """Whether a tick is due at this instant, and why; it is taken as done."""
        period = self.period_ns
        if set_point_waits and now_ns >= self._edge_ns():
            self.skipped += max(0, (now_ns - self._last_ns + period // 2) // period - 1)
            self._last_ns, self._own_ns = now_ns, now_ns + period + period // 2
            return TickCause.SET_POINT
        if now_ns >= self._own_ns:
            late = (now_ns - self._own_ns) // period
            self.skipped += late
            self._last_ns = self._own_ns + late * period
            self._own_ns = self._last_ns + period
            return TickCause.OWN_CLOCK
        return None

    def _edge_ns(self) -> int:
        return self._last_ns + self.period_ns // 2
