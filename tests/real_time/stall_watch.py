"""Whether the machine stood still: on each core a process does nothing but wake up, and notes when it could not.

Unlike the daemon's own witness it counts every stall, also one behind another process: both upset a test in real time.
"""

from __future__ import annotations

import atexit
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

#: the shortest stall that a test in real time may be upset by; a wake-up is late by less than 1 ms otherwise
STALL_S = 0.02
PERIOD_S = 0.005
_AWAKE = "awake"


class StallWatch:
    """Watchers for this process, one a core, from the first time it is asked until the process ends."""

    def __init__(self) -> None:
        descriptor, name = tempfile.mkstemp(prefix="stalls-")
        self._notes = Path(name)
        cores = sorted(os.sched_getaffinity(0))
        self.watchers = [
            subprocess.Popen(
                [sys.executable, "-S", "-E", __file__, str(core)], stdout=descriptor, stdin=subprocess.DEVNULL
            )
            for core in cores
        ]
        os.close(descriptor)
        while self._notes.read_text().count(_AWAKE) < len(cores):
            time.sleep(PERIOD_S)
        atexit.register(self.close)

    def longest_since(self, instant_s: float) -> float:
        """The longest stall that ended after `instant_s` (CLOCK_MONOTONIC), in s; zero where there was none."""
        time.sleep(2 * PERIOD_S)
        gaps = [line.split() for line in self._notes.read_text().splitlines() if line.count(" ") == 1]
        return max((float(end) - float(start) for start, end in gaps if float(end) > instant_s), default=0.0)

    def close(self) -> None:
        """End the watchers and remove their notes."""
        for watcher in self.watchers:
            watcher.kill()
            watcher.wait()
        self._notes.unlink(missing_ok=True)


def watch(core: int, parent: int) -> None:
    """Sleep on one core and write each stall down as `start end`, until the parent process is gone."""
    os.sched_setaffinity(0, {core})
    os.write(1, f"{_AWAKE}\n".encode())
    before = time.monotonic()
    while os.getppid() == parent:
        time.sleep(PERIOD_S)
        now = time.monotonic()
        if now - before - PERIOD_S > STALL_S:
            os.write(1, f"{before} {now}\n".encode())
        before = now


if __name__ == "__main__":
    watch(int(sys.argv[1]), os.getppid())
