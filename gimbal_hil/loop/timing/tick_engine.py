"""The tick engine: absolute deadlines, phase kept, whole periods skipped, every miss with a cause; the same code on any
clock.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from gimbal_hil.loop.timing.clock import Clock, Duration, Instant
from gimbal_hil.loop.timing.histogram import Histogram
from gimbal_hil.loop.timing.miss_causes import NOTHING_USED, Miss, MissCause, ThreadUsage, Witness, cause_of

#: the witness reports a stall when it wakes from it, as we do; after this long it must have, or it sees none
_WITNESS_PATIENCE_NS = 20_000_000


@dataclass(slots=True)
class TickStatistics:
    """What the engine did. Latency: from deadline to wake-up. Computing: from wake-up to the end of the step, link
    calls included.
    """

    period_ns: int
    ticks: int = 0
    missed: int = 0
    misses_by_cause: dict[MissCause, int] = field(default_factory=lambda: dict.fromkeys(MissCause, 0))
    latency: Histogram = field(default_factory=Histogram)
    computing: Histogram = field(default_factory=Histogram)
    longest_stall_ns: int = 0

    def as_dict(self) -> dict[str, object]:
        """For JSON: counts, quantiles in microseconds, missed periods by cause."""
        return {
            "period_us": self.period_ns / 1e3,
            "ticks": self.ticks,
            "missed": self.missed,
            "missed_by_cause": {cause.value: count for cause, count in self.misses_by_cause.items()},
            "latency_us": self.latency.summary_us(),
            "computing_us": self.computing.summary_us(),
            "longest_stall_us": self.longest_stall_ns / 1e3,
        }


@dataclass(slots=True)
class Tick:
    """One call of the control: its number counts periods since the start, so it jumps by the skipped ones.

    `deadline_ns` and `woke_ns` are instants of the engine's clock.
    """

    number: int
    skipped: int
    deadline_ns: int
    woke_ns: int


class TickEngine:
    """Calls `step` once a period, at `start + number * period`, until it answers False.

    A tick that comes a whole period late or more gives up the periods that passed and keeps the phase: never a burst of
    catch-up ticks. `usage` and `witness` supply the evidence for why; without them misses are counted and go to the
    timer.
    """

    def __init__(
        self,
        clock: Clock,
        period: Duration,
        step: Callable[[Tick], bool],
        usage: ThreadUsage | None = None,
        witness: Witness | None = None,
        on_miss: Callable[[Miss, MissCause], None] | None = None,
    ) -> None:
        self._clock = clock
        self._period_ns = period.ns
        self._step = step
        self._usage = usage
        self._witness = witness
        self._on_miss = on_miss
        self._unexplained: deque[Miss] = deque()
        self.statistics = TickStatistics(period.ns)

    def run(self, ticks: int | None = None) -> TickStatistics:
        """Run for `ticks` periods (for ever when None) or until the step answers False."""
        clock, period, statistics, usage = self._clock, self._period_ns, self.statistics, self._usage
        start = clock.now_ns() + period
        number = 0
        before_ns = ended_ns = start - period
        if usage:
            usage.mark()
        while ticks is None or number < ticks:
            deadline = start + number * period
            clock.wait_until(Instant(deadline))
            woke = clock.now_ns()
            late = woke - deadline
            skipped = late // period
            if skipped:
                self._count_miss(number, skipped, (before_ns, ended_ns), deadline, woke)
                number += skipped
                deadline = start + number * period
            if usage:
                usage.mark()
            statistics.ticks += 1
            statistics.latency.add(late)
            go_on = self._step(Tick(number, skipped, deadline, woke))
            if self._unexplained:
                self._explain(woke)
            ended_ns = clock.now_ns()
            statistics.computing.add(ended_ns - woke)
            if not go_on:
                break
            before_ns = woke
            number += 1
        self._explain(None)
        return statistics

    def _count_miss(self, number: int, skipped: int, step_ns: tuple[int, int], deadline_ns: int, woke_ns: int) -> None:
        """`step_ns`: when the step before began and when it ended."""
        statistics = self.statistics
        statistics.missed += skipped
        statistics.longest_stall_ns = max(statistics.longest_stall_ns, woke_ns - deadline_ns)
        used = self._usage.since_mark() if self._usage else NOTHING_USED
        self._unexplained.append(Miss(number, skipped, *step_ns, deadline_ns, woke_ns, used))

    def _explain(self, now_ns: int | None) -> None:
        """Name the causes of misses on which the witness has had its say; of all of them when `now_ns` is None."""
        while self._unexplained:
            miss = self._unexplained[0]
            heard = self._witness is None or self._witness.seen_until_ns() >= miss.woke_ns
            if not heard and now_ns is not None and now_ns - miss.woke_ns < _WITNESS_PATIENCE_NS:
                return
            self._unexplained.popleft()
            seen = self._witness
            cause = (
                cause_of(miss, seen.gaps_since(miss.began_ns), seen.core_gaps_since(miss.began_ns))
                if seen
                else cause_of(miss, [])
            )
            self.statistics.misses_by_cause[cause] += miss.periods
            if self._on_miss:
                self._on_miss(miss, cause)
