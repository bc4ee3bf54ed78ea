from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

from hypothesis import given, settings
from hypothesis import strategies as st

from gimbal_hil.loop.timing.clock import Duration, Instant, LockstepClock, MonotonicClock
from gimbal_hil.loop.timing.miss_causes import Miss, MissCause, Stall
from gimbal_hil.loop.timing.tick_engine import Tick, TickEngine

PERIOD = Duration(1_000_000)


class ScriptedClock:
    """Wakes late by what the script says for each wait; a step may let time pass."""

    def __init__(self, lateness_ns: list[int]) -> None:
        self._script = iter(lateness_ns)
        self.ns = 12_345

    def now(self) -> Instant:
        return Instant(self.ns)

    def now_ns(self) -> int:
        return self.ns

    def wait_until(self, deadline: Instant) -> None:
        self.ns = max(self.ns, deadline.ns + next(self._script, 0))


class SilentWitness:
    def __init__(self, gaps: list[Stall]) -> None:
        self.gaps = gaps
        self.awake_ns = 0

    def seen_until_ns(self) -> int:
        return self.awake_ns

    def gaps_since(self, instant_ns: int) -> list[Stall]:
        return [gap for gap in self.gaps if gap.end_ns > instant_ns]

    def core_gaps_since(self, instant_ns: int) -> list[Stall]:
        return []


def recorded(ticks: list[Tick], then: Callable[[Tick], None] = lambda tick: None) -> Callable[[Tick], bool]:
    def step(tick: Tick) -> bool:
        ticks.append(tick)
        then(tick)
        return True

    return step


def test_on_a_lockstep_clock_every_tick_runs_once_on_its_deadline() -> None:
    ticks: list[Tick] = []
    statistics = TickEngine(LockstepClock(), PERIOD, recorded(ticks)).run(1000)
    assert [tick.number for tick in ticks] == list(range(1000))
    assert {later.deadline_ns - earlier.deadline_ns for earlier, later in pairwise(ticks)} == {PERIOD.ns}
    assert statistics.ticks == 1000 and statistics.missed == 0 and statistics.latency.largest_ns == 0


@settings(deadline=None)
@given(st.lists(st.integers(0, 250_000_000), max_size=60))
def test_stalls_skip_whole_periods_keep_the_phase_and_never_make_a_burst(lateness: list[int]) -> None:
    ticks: list[Tick] = []
    clock = ScriptedClock(lateness)
    woken: list[int] = []
    engine = TickEngine(clock, PERIOD, recorded(ticks, lambda _: woken.append(clock.ns)))
    statistics = engine.run(2000)
    phase = ticks[0].deadline_ns % PERIOD.ns
    numbers = [tick.number for tick in ticks]
    assert all(tick.deadline_ns % PERIOD.ns == phase for tick in ticks)
    assert all(0 <= woke - tick.deadline_ns < PERIOD.ns for tick, woke in zip(ticks, woken, strict=True))
    assert len(set(numbers)) == len(numbers) and numbers == sorted(numbers)
    assert numbers[0] == ticks[0].skipped
    assert all(later.number - earlier.number == 1 + later.skipped for earlier, later in pairwise(ticks))
    assert statistics.missed == sum(tick.skipped for tick in ticks) == sum(statistics.misses_by_cause.values())


def test_a_step_that_computes_too_long_costs_the_periods_it_overran() -> None:
    ticks: list[Tick] = []
    clock = ScriptedClock([])

    def compute(tick: Tick) -> None:
        clock.ns += 3_400_000 if tick.number == 10 else 100_000

    statistics = TickEngine(clock, PERIOD, recorded(ticks, compute)).run(20)
    assert [tick.number for tick in ticks] == [*range(11), *range(13, 20)]
    assert ticks[11].skipped == 2
    assert statistics.computing.largest_ns == 3_400_000


def test_the_engine_ends_when_the_step_says_so() -> None:
    seen: list[int] = []

    def step(tick: Tick) -> bool:
        seen.append(tick.number)
        return tick.number < 4

    assert TickEngine(LockstepClock(), PERIOD, step).run().ticks == 5
    assert seen == [0, 1, 2, 3, 4]


def test_a_cause_is_named_only_after_the_witness_has_spoken() -> None:
    told: list[tuple[Miss, MissCause]] = []
    clock = ScriptedClock([0] * 5 + [20_000_000])
    witness = SilentWitness([])
    seen_at: list[int] = []

    def step(tick: Tick) -> bool:
        if tick.skipped:
            witness.gaps = [Stall(clock.ns - 20_000_000, clock.ns)]
        if tick.number == 30:
            assert not told
            witness.awake_ns = clock.ns + PERIOD.ns
        if told and not seen_at:
            seen_at.append(tick.number)
        return True

    TickEngine(clock, PERIOD, step, witness=witness, on_miss=lambda miss, cause: told.append((miss, cause))).run(60)
    assert [(miss.tick, miss.periods, cause) for miss, cause in told] == [(5, 20, MissCause.MACHINE_STALL)]
    assert seen_at == [31]


def test_a_dead_witness_does_not_keep_causes_waiting_for_ever() -> None:
    told: list[MissCause] = []
    clock = ScriptedClock([0, 0, 5_000_000])
    engine = TickEngine(
        clock, PERIOD, lambda tick: True, witness=SilentWitness([]), on_miss=lambda _, cause: told.append(cause)
    )
    engine.run(100)
    assert told == [MissCause.LATE_TIMER]


def test_in_real_time_no_tick_comes_before_its_deadline_and_none_twice() -> None:
    clock = MonotonicClock()
    early: list[Tick] = []
    ticks: list[Tick] = []

    def step(tick: Tick) -> bool:
        ticks.append(tick)
        if clock.now_ns() < tick.deadline_ns:
            early.append(tick)
        return True

    statistics = TickEngine(clock, PERIOD, step).run(300)
    assert not early
    assert statistics.ticks + statistics.missed >= 300
    assert len({tick.number for tick in ticks}) == len(ticks)
