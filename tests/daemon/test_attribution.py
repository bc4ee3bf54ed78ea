"""Misses of the daemon's own making, made on purpose in real time, must not be blamed on the machine."""

from __future__ import annotations

import gc
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator

import pytest

from gimbal_hil.loop.timing.clock import Duration, MonotonicClock
from gimbal_hil.loop.timing.miss_causes import MissCause, ThreadUsage
from gimbal_hil.loop.timing.scheduling import control_and_witness_cores, real_time
from gimbal_hil.loop.timing.tick_engine import Tick, TickEngine
from gimbal_hil.loop.timing.witness import WitnessProcess

pytestmark = pytest.mark.realtime

LENGTH_NS = 6_000_000
MADE = 12
#: at 40 ms each: 12 s, then the machine is too busy to ask
TRIES = 300
#: a fault that took this much longer than what it did was lengthened by the machine; its cause is then two causes
UNDISTURBED_NS = 1_000_000


def compute(usage: ThreadUsage) -> None:
    end = time.thread_time_ns() + LENGTH_NS
    while time.thread_time_ns() < end:
        pass


def collect(usage: ThreadUsage) -> None:
    rubbish = [[i] for i in range(20_000)]
    end = time.thread_time_ns() + LENGTH_NS
    while time.thread_time_ns() < end:
        gc.collect()
    del rubbish


@pytest.fixture(autouse=True)
def only_its_own_rubbish() -> Iterator[None]:
    """What earlier tests left in this process takes a second to look through, in which the core is nobody else's."""
    gc.freeze()
    yield
    gc.unfreeze()


def wait_for_the_bus(usage: ThreadUsage) -> None:
    began = time.monotonic_ns()
    time.sleep(LENGTH_NS / 1e9)
    usage.add_bus_wait(time.monotonic_ns() - began)


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="a witness needs a core of its own")
@pytest.mark.parametrize(
    ("fault", "cause"),
    [
        (compute, MissCause.OWN_COMPUTING),
        (collect, MissCause.GARBAGE_COLLECTION),
        (wait_for_the_bus, MissCause.BUS_WAIT),
    ],
)
def test_a_miss_made_on_purpose_is_given_its_own_cause(fault: Callable[[ThreadUsage], None], cause: MissCause) -> None:
    """Only misses count whose fault took as long as it was made to take, by a clock that attribution does not read: a
    stall of the machine in the middle of one is a cause of its own.
    """
    control, watcher = control_and_witness_cores()
    given: Counter[MissCause] = Counter()
    undisturbed: set[int] = set()
    tried = 0
    usage = ThreadUsage()

    def step(tick: Tick) -> bool:
        nonlocal tried
        if tick.number // 40 > tried:
            tried += 1
            began, busy = time.perf_counter_ns(), time.thread_time_ns()
            fault(usage)
            meant = max(LENGTH_NS, time.thread_time_ns() - busy)
            if time.perf_counter_ns() - began < meant + UNDISTURBED_NS:
                undisturbed.add(tick.number)
        return len(undisturbed) < MADE and tried < TRIES

    with WitnessProcess(watcher) as witness:
        assert witness.wait_awake()
        with real_time(core=control):
            # a miss is told with the tick whose deadline passed, the one after the step that took too long
            engine = TickEngine(
                MonotonicClock(),
                Duration(1_000_000),
                step,
                usage,
                witness.page,
                lambda missed, why: given.update([why] if missed.tick - 1 in undisturbed else []),
            )
            engine.run()
    usage.close()
    if len(undisturbed) < MADE:
        pytest.skip(f"the machine lengthened {tried - len(undisturbed)} of {tried} faults of {LENGTH_NS / 1e6:g} ms")
    assert given[cause] >= 0.7 * sum(given.values()) and given[cause] >= MADE // 2, given
