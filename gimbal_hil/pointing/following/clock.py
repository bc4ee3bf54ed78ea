"""When the ticks of a daemon are, by the time of day of this machine: a satellite is somewhere else a second later."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

#: looks at the daemon's tick, and between them
_LOOKS, _LOOK_S = 40, 0.007
#: what a clock is set by at once, and not steered (s): a low satellite moves by 0.4 mrad meanwhile
STEP_S = 0.03


@dataclass(frozen=True)
class TickClock:
    """When the ticks of a daemon are, by the clock of this machine: UTC (s) of tick 0, and how far apart the looks at
    it were.
    """

    zero_s: float
    period_s: float
    spread_s: float
    #: time of day less the time that nobody sets (s)
    ahead_s: float = math.nan

    def tick_at(self, utc_s: float) -> int:
        """The tick of a time."""
        return round((utc_s - self.zero_s) / self.period_s)

    def time_of(self, tick: int) -> datetime:
        """When a tick is."""
        return datetime.fromtimestamp(self.zero_s + tick * self.period_s, UTC)

    def stepped_s(self) -> float:
        """By how much somebody has set the time of day since the ticks were placed in it; 0 for what is steered."""
        step_s = _ahead_s() - self.ahead_s
        return step_s if abs(step_s) > STEP_S else 0.0

    def tick_after(self, seconds: float) -> int:
        """The tick so many seconds from now."""
        return self.tick_at(time.time() + seconds)


def tick_clock(tick: Callable[[], int], period_s: float) -> TickClock:
    """A daemon tells the last tick that it has recorded, which is late by milliseconds; the least late of many looks
    counts.
    """
    ahead_s, zeros = _ahead_s(), []
    for _ in range(_LOOKS):
        last = tick()
        zeros.append(time.time() - last * period_s)
        time.sleep(_LOOK_S)
    zeros.sort()
    return TickClock(zeros[0], period_s, zeros[len(zeros) // 4] - zeros[0], ahead_s)


def _ahead_s() -> float:
    return time.time() - time.monotonic()
