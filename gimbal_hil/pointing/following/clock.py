"""When the ticks of a daemon are, by the time of day of this machine: a satellite is somewhere else a second later."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

#: looks at the daemon's tick, and between them
_LOOKS, _LOOK_S = 40, 0.007


@dataclass(frozen=True)
class TickClock:
    """When the ticks of a daemon are, by the clock of this machine: UTC (s) of tick 0, and how far apart the looks at
    it were.
    """

    zero_s: float
    period_s: float
    spread_s: float

    def tick_at(self, utc_s: float) -> int:
        """The tick of a time."""
        return round((utc_s - self.zero_s) / self.period_s)

    def time_of(self, tick: int) -> datetime:
        """When a tick is."""
        return datetime.fromtimestamp(self.zero_s + tick * self.period_s, UTC)

    def tick_after(self, seconds: float) -> int:
        """The tick so many seconds from now."""
        return self.tick_at(time.time() + seconds)


def tick_clock(tick: Callable[[], int], period_s: float) -> TickClock:
    """A daemon tells the last tick that it has recorded, which is late by milliseconds; the least late of many looks
    counts.
    """
    zeros = []
    for _ in range(_LOOKS):
        last = tick()
        zeros.append(time.time() - last * period_s)
        time.sleep(_LOOK_S)
    zeros.sort()
    return TickClock(zeros[0], period_s, zeros[len(zeros) // 4] - zeros[0])
