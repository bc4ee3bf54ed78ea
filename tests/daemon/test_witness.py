from __future__ import annotations

import os
import signal
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gimbal_hil.loop.timing.mailbox import anonymous_memory
from gimbal_hil.loop.timing.miss_causes import Stall
from gimbal_hil.loop.timing.watching import gap_between
from gimbal_hil.loop.timing.witness import WitnessPage, WitnessProcess

pytestmark = pytest.mark.realtime


def new_page() -> WitnessPage:
    return WitnessPage(anonymous_memory(16384))


@settings(deadline=None)
@given(st.lists(st.integers(1, 10**9), max_size=300), st.integers(0, 10**11))
def test_the_page_gives_back_the_newest_gaps_in_order(lengths: list[int], since: int) -> None:
    page = new_page()
    now, gaps = 0, []
    for length in lengths:
        gaps.append(Stall(now, now + length))
        now += length + 1_000
        page.publish(now, gaps[-1])
    assert page.count() == len(gaps)
    assert page.seen_until_ns() == now
    assert page.gaps_since(since) == [gap for gap in gaps[-255:] if gap.end_ns > since]
    page.close()


def test_gaps_of_the_watched_core_are_kept_apart_from_the_witness_own() -> None:
    page = new_page()
    page.publish(10, Stall(1, 4), Stall(5, 9))
    page.publish(20, None, Stall(11, 19))
    assert page.gaps_since(0) == [Stall(1, 4)]
    assert page.core_gaps_since(0) == [Stall(5, 9), Stall(11, 19)]
    page.close()


def test_time_spent_queued_behind_others_is_not_a_stall_of_the_machine() -> None:
    assert gap_between(1_000_000, 6_000_000, 0) == Stall(1_000_000, 6_000_000)
    assert gap_between(1_000_000, 6_000_000, 4_950_000) is None
    assert gap_between(1_000_000, 1_100_000, 0) is None


def test_a_witness_that_was_stopped_reports_the_time_as_a_gap() -> None:
    with WitnessProcess(None) as witness:
        assert witness.wait_awake()
        began = time.monotonic_ns()
        os.kill(witness._process.pid, signal.SIGSTOP)
        time.sleep(0.05)
        stopped = time.monotonic_ns()
        os.kill(witness._process.pid, signal.SIGCONT)
        while witness.page.seen_until_ns() < stopped:
            time.sleep(0.001)
        # between its wake-up and the other cores' answer it counts for the core
        gaps = [*witness.page.gaps_since(began), *witness.page.core_gaps_since(began)]
        covered = sum(min(gap.end_ns, stopped) - max(gap.start_ns, began) for gap in gaps)
        assert covered > (stopped - began) / 2


def test_the_witness_ends_with_its_parent() -> None:
    witness = WitnessProcess(None)
    assert witness.wait_awake()
    pid = witness._process.pid
    witness.close()
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return
    raise AssertionError("the witness outlived its parent")
