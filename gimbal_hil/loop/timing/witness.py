"""A process on another core that does nothing but wake up: when it cannot either, the machine stood still.

It sleeps half a millisecond at a time and publishes every gap in shared memory, less the time in which it was merely
queued behind somebody else on its own core. `/proc/stat` steal does not show such stalls; a second observer does.

A host can also take one virtual core away and leave the other. So at every wake-up the witness asks the core that runs
the control process for an answer (membarrier, which interrupts the cores that run a registered process and waits until
they have taken note). A core that computes answers within microseconds, whatever it computes; one that is gone answers
when it is back. Nobody is asked while control sleeps, so an answer costs the control process an interrupt in one tick
of ten.
"""

from __future__ import annotations

import mmap
import os
import subprocess
import sys
import time
from types import TracebackType

from firmware_protocol.interpreter import apart_from_the_users_folder
from gimbal_hil.loop.timing.mailbox import anonymous_memory
from gimbal_hil.loop.timing.membarrier import REGISTER_GLOBAL_EXPEDITED, membarrier
from gimbal_hil.loop.timing.miss_causes import Stall

PERIOD_NS = 500_000
#: a wake-up this much later than asked is a gap, and so is a core that does not answer for that long
THRESHOLD_NS = 300_000
_SLOTS = 256
#: word 0 the last wake-up; then for each of the two rings the number of gaps and the gaps as (start, end)
_SEEN, _OWN, _CORE = 0, 1, 2 + 2 * _SLOTS
_SIZE = 8 * (_CORE + 1 + 2 * _SLOTS)


class WitnessPage:
    """The shared page: the last wake-up, and the last gaps of the witness and of the core it watches; ns of
    CLOCK_MONOTONIC.
    """

    def __init__(self, descriptor: int) -> None:
        self._memory = mmap.mmap(descriptor, os.fstat(descriptor).st_size)
        self._words = memoryview(self._memory).cast("q")

    def seen_until_ns(self) -> int:
        """The last instant at which the witness was awake."""
        return self._words[_SEEN]

    def gaps_since(self, instant_ns: int) -> list[Stall]:
        """The witness's gaps that end after `instant_ns`, newest last; the page keeps the last 256."""
        return self._since(_OWN, instant_ns)

    def core_gaps_since(self, instant_ns: int) -> list[Stall]:
        """Stretches in which the control process ran on a core that did not answer."""
        return self._since(_CORE, instant_ns)

    def _since(self, ring: int, instant_ns: int) -> list[Stall]:
        count = self._words[ring]
        gaps: list[Stall] = []
        for number in range(count - 1, max(-1, count - _SLOTS), -1):
            word = ring + 1 + 2 * (number % _SLOTS)
            gap = Stall(self._words[word], self._words[word + 1])
            if gap.end_ns <= instant_ns:
                break
            gaps.append(gap)
        return gaps[::-1]

    def count(self) -> int:
        """How many gaps the witness has seen since it started."""
        return self._words[_OWN]

    def publish(self, now_ns: int, gap: Stall | None, core_gap: Stall | None = None) -> None:
        """Called by the witness alone: the gaps first, then their numbers, then the heartbeat."""
        for ring, found in ((_OWN, gap), (_CORE, core_gap)):
            if found is not None:
                word = ring + 1 + 2 * (self._words[ring] % _SLOTS)
                self._words[word], self._words[word + 1] = found.start_ns, found.end_ns
                self._words[ring] += 1
        self._words[_SEEN] = now_ns

    def close(self) -> None:
        """Unmap the page."""
        self._words.release()
        self._memory.close()


class WitnessProcess:
    """Starts the witness of this process and reads its page; a context manager that ends it."""

    def __init__(self, core: int | None) -> None:
        membarrier(REGISTER_GLOBAL_EXPEDITED)()
        descriptor = anonymous_memory(_SIZE)
        try:
            with apart_from_the_users_folder():
                self._process = subprocess.Popen(
                    [
                        sys.executable,
                        "-m",
                        "gimbal_hil.loop.timing.watching",
                        str(descriptor),
                        str(-1 if core is None else core),
                        str(os.getpid()),
                    ],
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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
