"""A process on another core that does nothing but wake up: when it cannot either, the machine stood still.

It sleeps a millisecond at a time and publishes every gap in shared memory, less the time in which it was merely queued behind
somebody else on its own core. `/proc/stat` steal does not show such stalls; a second observer does.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import subprocess
import sys
import time
from types import TracebackType

from gimbal_hil.daemon.mailbox import anonymous_memory
from gimbal_hil.daemon.miss_causes import Gap
from gimbal_hil.daemon.real_time import available_cores, set_timer_slack

PERIOD_NS = 1_000_000
#: a wake-up this much later than asked is a gap
THRESHOLD_NS = 300_000
_SLOTS = 256
_SEEN, _COUNT, _FIRST = 0, 1, 2
_SIZE = 8 * (_FIRST + 2 * _SLOTS)


class WitnessPage:
    """The shared page: word 0 the last wake-up, word 1 the number of gaps, then a ring of (start, end) in ns of CLOCK_MONOTONIC."""

    def __init__(self, descriptor: int) -> None:
        self._memory = mmap.mmap(descriptor, os.fstat(descriptor).st_size)
        self._words = memoryview(self._memory).cast("q")

    def seen_until_ns(self) -> int:
        """The last instant at which the witness was awake."""
        return self._words[_SEEN]

    def gaps_since(self, instant_ns: int) -> list[Gap]:
        """The witness's gaps that end after `instant_ns`, newest last; the page keeps the last 256."""
        count = self._words[_COUNT]
        gaps: list[Gap] = []
        for number in range(count - 1, max(-1, count - _SLOTS), -1):
            word = _FIRST + 2 * (number % _SLOTS)
            gap = Gap(self._words[word], self._words[word + 1])
            if gap.end_ns <= instant_ns:
                break
            gaps.append(gap)
        return gaps[::-1]

    def count(self) -> int:
        """How many gaps the witness has seen since it started."""
        return self._words[_COUNT]

    def publish(self, now_ns: int, gap: Gap | None) -> None:
        """Called by the witness alone: the gap first, then its number, then the heartbeat."""
        if gap is not None:
            word = _FIRST + 2 * (self._words[_COUNT] % _SLOTS)
            self._words[word], self._words[word + 1] = gap.start_ns, gap.end_ns
            self._words[_COUNT] += 1
        self._words[_SEEN] = now_ns

    def close(self) -> None:
        """Unmap the page."""
        self._words.release()
        self._memory.close()


class WitnessProcess:
    """Starts the witness and reads its page; a context manager that ends it."""

    def __init__(self, core: int | None) -> None:
        descriptor = anonymous_memory(_SIZE)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "gimbal_hil.daemon.witness", str(descriptor), str(-1 if core is None else core), str(os.getpid())],
                pass_fds=(descriptor,),
                stdin=subprocess.DEVNULL,
            )
            self.page = WitnessPage(descriptor)
        finally:
            os.close(descriptor)

    def wait_awake(self, timeout_s: float = 5.0) -> bool:
        """Wait for the first heartbeat."""
        end = time.monotonic() + timeout_s
        while not self.page.seen_until_ns():
            if time.monotonic() > end or self._process.poll() is not None:
                return False
            time.sleep(0.005)
        return True

    def close(self) -> None:
        """End the witness."""
        self._process.kill()
        self._process.wait()
        self.page.close()

    def __enter__(self) -> WitnessProcess:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def gap_between(asked_ns: int, woke_ns: int, queued_ns: int) -> Gap | None:
    """What a wake-up at `woke_ns` for `asked_ns` says of the machine, when `queued_ns` of it went to others on this core."""
    if woke_ns - asked_ns - queued_ns < THRESHOLD_NS:
        return None
    return Gap(asked_ns, woke_ns)


def watch(page: WitnessPage, parent: int) -> None:
    """Sleep and publish until the parent process is gone."""
    schedstat = _open_schedstat()
    queued_before = _queued_ns(schedstat)
    while os.getppid() == parent:
        asked = time.monotonic_ns() + PERIOD_NS
        time.sleep(PERIOD_NS / 1e9)
        woke = time.monotonic_ns()
        queued = _queued_ns(schedstat)
        page.publish(woke, gap_between(asked, woke, queued - queued_before))
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
