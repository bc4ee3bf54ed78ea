"""The same periodic wake-up in C: what this machine can do at best, as the measure for the Python tick loop."""

from __future__ import annotations

import os
import shutil
import struct
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from gimbal_hil.daemon.clock import Duration
from gimbal_hil.daemon.histogram import Histogram

#: absolute deadlines on CLOCK_MONOTONIC, whole periods skipped, as in `tick_engine`; writes each wake-up's lateness as int64 nanoseconds
_SOURCE = r"""
#define _GNU_SOURCE
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>

static int64_t now_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

int main(int argc, char **argv) {
    if (argc != 5) return 2;
    int64_t period = atoll(argv[1]);
    long ticks = atol(argv[2]);
    int priority = atoi(argv[3]), core = atoi(argv[4]);
    prctl(PR_SET_TIMERSLACK, 1UL, 0, 0, 0);
    if (priority > 0) {
        struct sched_param parameter = {.sched_priority = priority};
        if (sched_setscheduler(0, SCHED_FIFO, &parameter)) return 3;
    }
    if (core >= 0) {
        cpu_set_t set;
        CPU_ZERO(&set);
        CPU_SET(core, &set);
        if (sched_setaffinity(0, sizeof set, &set)) return 4;
    }
    mlockall(MCL_CURRENT | MCL_FUTURE);
    int64_t *late = calloc(ticks, sizeof *late);
    int64_t deadline = now_ns() + period;
    long count = 0;
    for (long n = 0; n < ticks; n++) {
        struct timespec until = {deadline / 1000000000LL, deadline % 1000000000LL};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL)) {}
        int64_t lateness = now_ns() - deadline;
        late[count++] = lateness;
        int64_t skipped = lateness / period;
        n += skipped;
        deadline += (1 + skipped) * period;
    }
    return fwrite(late, sizeof *late, count, stdout) == (size_t)count ? 0 : 5;
}
"""


@dataclass(frozen=True, slots=True)
class LoopLatency:
    """Wake-up latencies of a loop without any work in it."""

    latency: Histogram
    missed: int


class ReferenceLoop:
    """The compiled loop; a context manager, because it lives in a temporary folder. `available()` says whether it can be made."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="gimbal-hil-")
        source = Path(self._folder.name) / "loop.c"
        self._program = source.with_suffix("")
        source.write_text(_SOURCE)
        subprocess.run([compiler() or "cc", "-O2", "-o", str(self._program), str(source)], check=True, capture_output=True)

    def run(self, period: Duration, ticks: int, priority: int | None, core: int | None) -> LoopLatency:
        """Run it under the same policy and on the same core as the loop that it is compared with."""
        words = [str(self._program), str(period.ns), str(ticks), str(priority or 0), str(-1 if core is None else core)]
        output = subprocess.run(words, check=True, capture_output=True).stdout
        histogram = Histogram()
        missed = 0
        for (late,) in struct.iter_unpack("=q", output):
            histogram.add(late)
            missed += late // period.ns
        return LoopLatency(histogram, missed)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._folder.cleanup()


def compiler() -> str | None:
    """The C compiler to use, None when there is none or the loop is not written for this system."""
    if not sys.platform.startswith("linux"):
        return None
    return shutil.which(os.environ.get("CC", "cc")) or shutil.which("gcc")
