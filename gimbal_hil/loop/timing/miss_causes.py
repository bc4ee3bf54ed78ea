"""Why a tick was missed: what the kernel, the collector, the link and a witness say about the time that was lost."""

from __future__ import annotations

import gc
import os
import resource
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

#: where the kernel counts per process only, the control thread is nearly all of it
_OF_THREAD = getattr(resource, "RUSAGE_THREAD", resource.RUSAGE_SELF)


class MissCause(Enum):
    """Who took the time of a missed tick."""

    OWN_COMPUTING = "own_computing"
    GARBAGE_COLLECTION = "garbage_collection"
    BUS_WAIT = "bus_wait"
    PREEMPTION = "preemption"
    PAGE_FAULT = "page_fault"
    MACHINE_STALL = "machine_stall"
    LATE_TIMER = (
        "late_timer"  # nobody used the core and it still woke late: interrupt work or one virtual core held by its host
    )
    CORE_TAKEN = "core_taken"  # charged with computing while its core did not even answer another one: its host took it


#: code of each cause in the `miss_cause` column of a log; 0 is no miss
MISS_CODE: dict[MissCause, int] = {cause: code for code, cause in enumerate(MissCause, 1)}


@dataclass(frozen=True, slots=True)
class Usage:
    """What the control thread did in a stretch of time; faults and switches count from the last miss on, not from the
    last wake-up.
    """

    computing_ns: int  # time on a core
    queued_ns: int  # time able to run while somebody else had the core
    collecting_ns: int
    bus_wait_ns: int
    minor_faults: int
    major_faults: int
    yields: int  # voluntary context switches
    preemptions: int  # involuntary context switches
    #: how often the thread was put back on a core beyond once a wake-up: it had waited for something, or been preempted
    waits: int = 1


NOTHING_USED = Usage(*[0] * 8)
#: the queue is read from the kernel's books at every so many wake-ups only: a read costs as much as a tenth of a tick
_READ_EVERY = 8


@dataclass(frozen=True, slots=True)
class Stall:
    """A stretch in which a process that had nothing to do could not wake."""

    start_ns: int
    end_ns: int


@dataclass(frozen=True, slots=True)
class Miss:
    """Ticks lost together: the deadline that passed, when the engine came to it, and what happened since the wake-up
    before.

    `ended_ns` is when the step that began at that wake-up was done: after it there is only waiting.
    """

    tick: int
    periods: int
    began_ns: int  # the wake-up before
    ended_ns: int
    deadline_ns: int
    woke_ns: int
    usage: Usage


class Witness(Protocol):
    """An observer on another core that publishes when it could not run either."""

    def seen_until_ns(self) -> int:
        """Up to which instant of CLOCK_MONOTONIC the observer has reported."""

    def gaps_since(self, instant_ns: int) -> list[Stall]:
        """The observer's gaps that end after `instant_ns`."""

    def core_gaps_since(self, instant_ns: int) -> list[Stall]:
        """Stretches, ending after `instant_ns`, in which the core of the observed process did not answer the
        observer's.
        """


def cause_of(miss: Miss, gaps: list[Stall], core_gaps: Sequence[Stall] = ()) -> MissCause:
    """Name what explains most of the lost time.

    A gap that an idle process on another core saw too comes first: during it nothing else that was measured means
    anything (a stopped virtual core goes on charging CPU time to whom it ran). A step that was done before the
    deadline, or next to it, is not the cause: the time was lost in the wait. Otherwise the largest of collection, link,
    queue, computing outside the link, and computing during which the core did not answer; when these explain less than
    a quarter, a page fault if there was one, else the timer.
    """
    lost = miss.woke_ns - miss.deadline_ns
    if 2 * _overlap_ns(miss, gaps) >= lost:
        return MissCause.MACHINE_STALL
    usage = miss.usage
    if 4 * (miss.ended_ns - miss.deadline_ns) < lost:
        # the step was done in time: whatever is charged to the wait, a spin at most, is not work
        waiting_ns = usage.computing_ns - (miss.ended_ns - miss.began_ns)
        known = {MissCause.PREEMPTION: usage.queued_ns, MissCause.CORE_TAKEN: waiting_ns}
        return _largest(known, lost, MissCause.LATE_TIMER)
    in_link_ns = usage.bus_wait_ns
    gone_ns = min(_overlap_ns(miss, core_gaps), usage.computing_ns)
    if usage.waits <= 0:
        # never off its core and yet not charged with the time: a kernel that knows of stolen time leaves it out
        gone_ns = max(gone_ns, miss.ended_ns - miss.began_ns - usage.computing_ns)
    known = {
        MissCause.GARBAGE_COLLECTION: usage.collecting_ns,
        # a driver that computes in a link call is the link's as well; what the call spends queued for a core is not
        MissCause.BUS_WAIT: in_link_ns - usage.queued_ns,
        MissCause.PREEMPTION: usage.queued_ns,
        MissCause.OWN_COMPUTING: usage.computing_ns - usage.collecting_ns - max(gone_ns, in_link_ns),
        MissCause.CORE_TAKEN: gone_ns,
    }
    return _largest(known, lost, MissCause.PAGE_FAULT if usage.major_faults else MissCause.LATE_TIMER)


def _largest(known_ns: dict[MissCause, int], lost_ns: int, otherwise: MissCause) -> MissCause:
    """What took most, when that is a quarter of the lost time."""
    cause, most = max(known_ns.items(), key=lambda item: item[1])
    return cause if 4 * most >= lost_ns else otherwise


def _overlap_ns(miss: Miss, gaps: Iterable[Stall]) -> int:
    """How much of the time between the wake-up before a miss and the one after it lies in the gaps."""
    return sum(max(0, min(gap.end_ns, miss.woke_ns) - max(gap.start_ns, miss.began_ns)) for gap in gaps)


class ThreadUsage:
    """Evidence about the calling thread; `mark`, called at every wake-up, is one cheap system call, and now and then a
    second.
    """

    def __init__(self) -> None:
        self._collecting_ns = 0
        self._bus_wait_ns = 0
        self._collection_began_ns = 0
        try:
            self._schedstat = os.open("/proc/thread-self/schedstat", os.O_RDONLY | os.O_CLOEXEC)
        except OSError:
            self._schedstat = -1
        self._switches = resource.getrusage(_OF_THREAD)
        self._until_read = 0
        self.mark()
        gc.callbacks.append(self._on_collection)

    def add_bus_wait(self, ns: int) -> None:
        """Charge `ns` of waiting to the link."""
        self._bus_wait_ns += ns

    def mark(self) -> None:
        """Start of a new stretch."""
        self._until_read -= 1
        if self._until_read <= 0:
            self._until_read = _READ_EVERY
            self._marked_queued_ns, self._marked_runs = self._scheduled()
            self._wakes = 0
        else:
            self._wakes += 1
        self._marked_computing_ns = time.thread_time_ns()
        self._marked_collecting_ns = self._collecting_ns
        self._marked_bus_wait_ns = self._bus_wait_ns

    def since_mark(self) -> Usage:
        """What was used since the last mark; of the queue, since a few marks before it: in those next to nothing was
        queued.
        """
        computing_ns = time.thread_time_ns() - self._marked_computing_ns
        queued_ns, runs = self._scheduled()
        queued_ns -= self._marked_queued_ns
        before, now = self._switches, resource.getrusage(_OF_THREAD)
        self._switches = now
        return Usage(
            computing_ns=computing_ns,
            queued_ns=queued_ns,
            collecting_ns=self._collecting_ns - self._marked_collecting_ns,
            bus_wait_ns=self._bus_wait_ns - self._marked_bus_wait_ns,
            minor_faults=now.ru_minflt - before.ru_minflt,
            major_faults=now.ru_majflt - before.ru_majflt,
            yields=now.ru_nvcsw - before.ru_nvcsw,
            preemptions=now.ru_nivcsw - before.ru_nivcsw,
            waits=runs - self._marked_runs - self._wakes if runs else 1,
        )

    def close(self) -> None:
        """Stop listening to the collector."""
        gc.callbacks.remove(self._on_collection)
        if self._schedstat >= 0:
            os.close(self._schedstat)

    def _scheduled(self) -> tuple[int, int]:
        """Time able to run without a core (ns), and how often the thread was put on one, as the kernel keeps them; 0
        where it does not.
        """
        if self._schedstat < 0:
            return 0, 0
        words = os.pread(self._schedstat, 80, 0).split()
        return int(words[1]), int(words[2])

    def _on_collection(self, phase: str, _info: dict[str, int]) -> None:
        now = time.monotonic_ns()
        if phase == "start":
            self._collection_began_ns = now
        else:
            self._collecting_ns += now - self._collection_began_ns
