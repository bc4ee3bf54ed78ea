from __future__ import annotations

import signal
import threading
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gimbal_hil.loop.timing.clock import Duration, Instant, LockstepClock, MonotonicClock

pytestmark = pytest.mark.realtime


@settings(deadline=None)
@given(st.integers(-(10**18), 10**18), st.integers(-(10**12), 10**12))
def test_instants_and_durations_add_up_exactly(start: int, length: int) -> None:
    later = Instant(start) + Duration(length)
    assert later.since(Instant(start)) == Duration(length)


def test_a_duration_in_seconds_is_the_nearest_nanosecond() -> None:
    assert Duration.of_seconds(0.001) == Duration(1_000_000)
    assert Duration.of_seconds(1e-9 * 0.6) == Duration(1)
    assert Duration(1_500_000_000).seconds == 1.5


def test_monotonic_clock_never_returns_before_the_deadline() -> None:
    for spin in (Duration(0), Duration(200_000)):
        clock = MonotonicClock(spin)
        for _ in range(20):
            deadline = clock.now() + Duration(300_000)
            clock.wait_until(deadline)
            assert clock.now() >= deadline


def test_a_deadline_that_has_passed_is_not_waited_for() -> None:
    clock = MonotonicClock()
    clock.wait_until(Instant(0))


@pytest.mark.realtime
def test_a_signal_is_handled_in_the_wait_and_does_not_shorten_it() -> None:
    handled: list[int] = []
    before = signal.signal(signal.SIGUSR1, lambda number, _: handled.append(number))
    sender = threading.Timer(0.01, signal.raise_signal, (signal.SIGUSR1,))
    try:
        clock = MonotonicClock()
        deadline = clock.now() + Duration(50_000_000)
        sender.start()
        clock.wait_until(deadline)
        time.sleep(0)
        assert handled == [signal.SIGUSR1]
        assert clock.now() >= deadline
    finally:
        # a signal that comes later than its handler goes would end this process
        sender.join()
        signal.signal(signal.SIGUSR1, before)


def test_lockstep_clock_moves_only_when_somebody_waits_and_never_back() -> None:
    clock = LockstepClock()
    assert clock.now() == Instant(0)
    clock.wait_until(Instant(5))
    assert clock.now() == Instant(5)
    clock.wait_until(Instant(3))
    assert clock.now() == Instant(5)
