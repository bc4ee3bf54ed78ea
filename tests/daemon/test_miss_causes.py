from __future__ import annotations

import dataclasses
import gc

import pytest

from gimbal_hil.loop.timing.miss_causes import NOTHING_USED, Miss, MissCause, Stall, ThreadUsage, Usage, cause_of


def miss(**used: int) -> Miss:
    """Three periods of 1 ms lost after a wake-up at 0."""
    return Miss(
        1,
        3,
        began_ns=0,
        ended_ns=4_150_000,
        deadline_ns=1_000_000,
        woke_ns=4_200_000,
        usage=dataclasses.replace(NOTHING_USED, **used),
    )


@pytest.mark.parametrize(
    ("used", "cause"),
    [
        ({"computing_ns": 4_000_000}, MissCause.OWN_COMPUTING),
        ({"computing_ns": 4_000_000, "collecting_ns": 3_500_000}, MissCause.GARBAGE_COLLECTION),
        ({"bus_wait_ns": 3_900_000, "computing_ns": 100_000}, MissCause.BUS_WAIT),
        ({"bus_wait_ns": 3_200_000, "computing_ns": 3_900_000}, MissCause.BUS_WAIT),
        ({"bus_wait_ns": 400_000, "computing_ns": 3_900_000}, MissCause.OWN_COMPUTING),
        ({"queued_ns": 3_300_000, "computing_ns": 200_000}, MissCause.PREEMPTION),
        ({"bus_wait_ns": 3_500_000, "queued_ns": 3_300_000}, MissCause.PREEMPTION),
        ({"major_faults": 2, "computing_ns": 200_000}, MissCause.PAGE_FAULT),
        ({"computing_ns": 100_000}, MissCause.LATE_TIMER),
        ({"computing_ns": 1_000_000, "waits": 0}, MissCause.CORE_TAKEN),
        ({"computing_ns": 1_000_000, "waits": 1}, MissCause.OWN_COMPUTING),
        ({"computing_ns": 100_000, "minor_faults": 3, "yields": 1}, MissCause.LATE_TIMER),
    ],
)
def test_the_largest_share_of_the_lost_time_names_the_cause(used: dict[str, int], cause: MissCause) -> None:
    assert cause_of(miss(**used), []) is cause


def test_a_gap_that_the_witness_saw_at_the_same_time_is_a_machine_stall_whatever_else_was_charged() -> None:
    stall = [Stall(900_000, 4_100_000)]
    assert cause_of(miss(computing_ns=4_000_000), stall) is MissCause.MACHINE_STALL
    assert cause_of(miss(), stall) is MissCause.MACHINE_STALL


def test_a_gap_at_another_time_or_much_shorter_is_no_excuse() -> None:
    assert cause_of(miss(computing_ns=4_000_000), [Stall(5_000_000, 9_000_000)]) is MissCause.OWN_COMPUTING
    assert cause_of(miss(computing_ns=4_000_000), [Stall(1_000_000, 1_500_000)]) is MissCause.OWN_COMPUTING


def test_computing_on_a_core_that_did_not_answer_is_a_core_that_was_taken() -> None:
    computing = miss(computing_ns=4_000_000)
    assert cause_of(computing, [], [Stall(500_000, 3_900_000)]) is MissCause.CORE_TAKEN
    assert cause_of(computing, [], [Stall(500_000, 900_000)]) is MissCause.OWN_COMPUTING
    assert (
        cause_of(miss(computing_ns=4_000_000, collecting_ns=3_000_000), [], [Stall(3_500_000, 4_200_000)])
        is MissCause.GARBAGE_COLLECTION
    )


def test_a_step_that_was_done_in_time_is_not_to_blame_for_a_late_wake_up() -> None:
    def waiting(**used: int) -> Miss:
        return dataclasses.replace(miss(**used), ended_ns=100_000)

    assert cause_of(waiting(computing_ns=100_000), []) is MissCause.LATE_TIMER
    assert cause_of(waiting(computing_ns=100_000, queued_ns=3_000_000), []) is MissCause.PREEMPTION
    assert cause_of(waiting(computing_ns=3_200_000), []) is MissCause.CORE_TAKEN
    assert cause_of(waiting(computing_ns=100_000, collecting_ns=90_000, major_faults=1), []) is MissCause.LATE_TIMER


def test_several_short_stalls_add_up() -> None:
    gaps = [Stall(100_000, 1_000_000), Stall(1_300_000, 2_000_000), Stall(2_500_000, 4_000_000)]
    assert cause_of(miss(computing_ns=3_000_000), gaps) is MissCause.MACHINE_STALL


def test_usage_grows_with_computing_collecting_and_waiting() -> None:
    usage = ThreadUsage()
    try:
        usage.mark()
        sum(range(200_000))
        gc.collect()
        usage.add_bus_wait(500)
        used = usage.since_mark()
        assert used.computing_ns > 0 and used.collecting_ns > 0 and used.bus_wait_ns == 500
        assert isinstance(used, Usage)
    finally:
        usage.close()
    assert usage._on_collection not in gc.callbacks
