"""What runs in the witness process: `python -m gimbal_hil.loop.timing.watching DESCRIPTOR CORE PARENT`."""

from __future__ import annotations

import contextlib
import os
import sys
import time

from gimbal_hil.loop.timing.membarrier import GLOBAL_EXPEDITED, membarrier
from gimbal_hil.loop.timing.miss_causes import Stall
from gimbal_hil.loop.timing.scheduling import available_cores, set_timer_slack
from gimbal_hil.loop.timing.witness import PERIOD_NS, THRESHOLD_NS, WitnessPage


def gap_between(asked_ns: int, woke_ns: int, queued_ns: int) -> Stall | None:
    """What a wake-up at `woke_ns` for `asked_ns` says of the machine, when `queued_ns` of it went to others on this
    core.
    """
    if woke_ns - asked_ns - queued_ns < THRESHOLD_NS:
        return None
    return Stall(asked_ns, woke_ns)


def watch(page: WitnessPage, parent: int) -> None:
    """Sleep and publish until the parent process is gone."""
    schedstat, ask_cores = _open_schedstat(), membarrier(GLOBAL_EXPEDITED)
    queued_before, answered = _queued_ns(schedstat), time.monotonic_ns()
    while os.getppid() == parent:
        # from the last look on: time that is lost before it sleeps is a gap as well
        asked = answered + PERIOD_NS
        time.sleep(PERIOD_NS / 1e9)
        woke = time.monotonic_ns()
        ask_cores()
        answered = time.monotonic_ns()
        queued = _queued_ns(schedstat)
        page.publish(
            answered,
            gap_between(asked, woke, queued - queued_before),
            gap_between(woke, answered, queued - queued_before),
        )
        queued_before = queued


def main(arguments: list[str]) -> None:
    """Entry point of the witness process: descriptor, core (-1 for any) and the parent's process id."""
    descriptor, core, parent = map(int, arguments)
    if core in available_cores():
        os.sched_setaffinity(0, {core})
    set_timer_slack(1)
    with contextlib.suppress(OSError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(50))
    with contextlib.suppress(KeyboardInterrupt):
        watch(WitnessPage(descriptor), parent)


def _open_schedstat() -> int:
    try:
        return os.open("/proc/thread-self/schedstat", os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return -1


def _queued_ns(schedstat: int) -> int:
    return int(os.pread(schedstat, 80, 0).split()[1]) if schedstat >= 0 else 0


if __name__ == "__main__":
    main(sys.argv[1:])
