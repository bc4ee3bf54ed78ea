"""Can this machine hold the rate? Measures its clock, its permissions, its stalls, and the tick loop beside the same
loop in C.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from gimbal_hil.loop.timing.clock import Duration, MonotonicClock
from gimbal_hil.loop.timing.histogram import Histogram
from gimbal_hil.loop.timing.miss_causes import MissCause, ThreadUsage
from gimbal_hil.loop.timing.reference_loop import LoopLatency, ReferenceLoop, compiler
from gimbal_hil.loop.timing.scheduling import (
    Granted,
    control_and_witness_cores,
    real_time,
    reserved_for_normal_tasks,
    timer_slack,
)
from gimbal_hil.loop.timing.tick_engine import Tick, TickEngine, TickStatistics
from gimbal_hil.loop.timing.witness import WitnessProcess

#: slices of the two loops alternate, so that both see the same machine
SLICES = 4
#: a wake-up may be this share of a period late at p99 before the loop has no time left for its work
LATE_SHARE = 0.25
#: target of the Python loop beside the C loop (docs/measurements/bench-results.md), reported when exceeded; not part of
#: the verdict: it is a ratio of two good things
C_RATIO = 1.5


@dataclass(slots=True)
class MachineReport:
    """What was measured; `reasons` against holding the rate (empty means that it can), `remarks` that do not decide."""

    period: Duration
    clock_resolution_ns: int
    clock_step_ns: int
    default_slack_ns: int | None
    granted: Granted
    statistics: TickStatistics
    stalls: int
    longest_stall_ns: int
    reference: LoopLatency | None
    reasons: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    @property
    def holds(self) -> bool:
        """Whether nothing speaks against it."""
        return not self.reasons

    @property
    def p99_ratio(self) -> float | None:
        """Wake-up latency p99 of the Python loop over that of the C loop; None without a C loop."""
        if self.reference is None:
            return None
        return self.statistics.latency.quantile_ns(0.99) / max(1, self.reference.latency.quantile_ns(0.99))

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        reference = self.reference
        return {
            "holds": self.holds,
            "reasons": self.reasons,
            "remarks": self.remarks,
            "rate_hz": 1e9 / self.period.ns,
            "clock": {"resolution_ns": self.clock_resolution_ns, "smallest_step_ns": self.clock_step_ns},
            "default_timer_slack_ns": self.default_slack_ns,
            "granted": self.granted.as_dict(),
            "machine_stalls": {"count": self.stalls, "longest_ms": self.longest_stall_ns / 1e6},
            "tick_loop": self.statistics.as_dict(),
            "c_loop": None
            if reference is None
            else {"missed": reference.missed, "latency_us": reference.latency.summary_us()},
            "p99_ratio_to_c": self.p99_ratio,
        }


def check_machine(
    period: Duration, seconds: float, progress: Callable[[float], None] = lambda share: None
) -> MachineReport:
    """Measure for about twice `seconds` (each loop gets that much) and judge; `progress` gets the finished share
    between slices.
    """
    resolution = round(time.get_clock_info("monotonic").resolution * 1e9)
    default_slack = timer_slack()
    control_core, witness_core = control_and_witness_cores()
    ticks = max(1, round(seconds * 1e9 / period.ns / SLICES))
    with WitnessProcess(witness_core) as witness:
        witness.wait_awake()
        began_ns = time.monotonic_ns()
        with real_time(core=control_core) as granted:
            statistics, reference = _alternate(period, ticks, granted, witness, progress)
        gaps = witness.page.gaps_since(began_ns)
        stalls = witness.page.count()
    longest = max((gap.end_ns - gap.start_ns for gap in gaps), default=0)
    report = MachineReport(
        period, resolution, _clock_step_ns(), default_slack, granted, statistics, stalls, longest, reference
    )
    _judge(report)
    return report


def _alternate(
    period: Duration, ticks: int, granted: Granted, witness: WitnessProcess, progress: Callable[[float], None]
) -> tuple[TickStatistics, LoopLatency | None]:
    usage = ThreadUsage()

    def step(_tick: Tick) -> bool:
        return True

    engine = TickEngine(MonotonicClock(), period, step, usage, witness.page)
    together, missed = Histogram(), 0
    with contextlib.ExitStack() as stack:
        stack.callback(usage.close)
        loop = stack.enter_context(ReferenceLoop()) if compiler() else None
        for done in range(SLICES):
            if loop is not None:
                part = loop.run(period, ticks, granted.real_time_priority, granted.core)
                together.merge(part.latency)
                missed += part.missed
            engine.run(ticks)
            progress((done + 1) / SLICES)
    return engine.statistics, LoopLatency(together, missed) if loop else None


def _judge(report: MachineReport) -> None:
    statistics, period_us = report.statistics, report.period.ns / 1e3
    late_us = statistics.latency.quantile_ns(0.99) / 1e3
    if late_us > LATE_SHARE * period_us:
        report.reasons.append(
            f"1 % of wake-ups are more than {late_us:.0f} us late: over {LATE_SHARE:.0%} of the period of "
            f"{period_us:.0f} us"
        )
    blamed = {
        cause: count
        for cause, count in statistics.misses_by_cause.items()
        if count and cause is not MissCause.MACHINE_STALL
    }
    if blamed:
        causes = ", ".join(f"{cause.value} {count}" for cause, count in blamed.items())
        report.reasons.append(
            f"{sum(blamed.values())} of {statistics.ticks + statistics.missed} ticks missed by an empty loop: {causes}"
        )
    stalled = statistics.misses_by_cause[MissCause.MACHINE_STALL]
    if stalled:
        worst = f"(longest {statistics.longest_stall_ns / 1e6:.1f} ms): the antenna's deadman must outlast that"
        report.reasons.append(f"{stalled} ticks lost while the whole machine stood still {worst}")
    report.remarks += [f"not granted: {line}" for line in report.granted.refused]
    reserved_ms = reserved_for_normal_tasks()
    if report.granted.real_time_priority is not None and reserved_ms > report.period.ns / 1e6:
        report.remarks.append(
            f"the kernel keeps {reserved_ms:.0f} ms of every second for normal tasks: when they fill all cores, it "
            "may take a real-time"
            " thread's core for that long (sched_rt_runtime_us, fair_server)"
        )
    ratio = report.p99_ratio
    if ratio is None:
        report.remarks.append("no C compiler: the tick loop has no reference")
    elif ratio > C_RATIO:
        report.remarks.append(f"the tick loop's p99 latency is {ratio:.2f} times that of the same loop in C")


def _clock_step_ns() -> int:
    """Smallest step of the clock that two readings in a row showed."""
    least = 1 << 62
    before = time.monotonic_ns()
    for _ in range(2000):
        now = time.monotonic_ns()
        if now > before:
            least = min(least, now - before)
        before = now
    return least
