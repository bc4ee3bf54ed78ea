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

from gimbal_hil.loop.timing.clock import Duration
from gimbal_hil.loop.timing.histogram import Histogram

#: absolute deadlines on CLOCK_MONOTONIC, whole periods skipped, as in `tick_engine`; for each wake-up it writes its
#: lateness and how long the work after it took, int64 nanoseconds. Work is a fixed number of additions, measured at the
#: start to last as asked when undisturbed.
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

static volatile uint64_t sum;

static void work(int64_t rounds) {
    for (int64_t i = 0; i < rounds; i++) sum += (uint64_t)i;
}

static int64_t rounds_lasting(int64_t wanted) {
    int64_t least = INT64_MAX;
    if (wanted <= 0) return 0;
    for (int n = 0; n < 2000; n++) {
        int64_t began = now_ns();
        work(10000);
        int64_t took = now_ns() - began;
        if (took < least) least = took;
    }
    return wanted * 10000 / (least > 0 ? least : 1);
}

int main(int argc, char **argv) {
    if (argc != 6) return 2;
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
    int64_t rounds = rounds_lasting(atoll(argv[5]));
    int64_t (*seen)[2] = calloc(ticks, sizeof *seen);
    int64_t deadline = now_ns() + period;
    long count = 0;
    for (long n = 0; n < ticks; n++) {
        struct timespec until = {deadline / 1000000000LL, deadline % 1000000000LL};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL)) {}
        int64_t woke = now_ns(), lateness = woke - deadline;
        work(rounds);
        seen[count][0] = lateness;
        seen[count++][1] = rounds ? now_ns() - woke : 0;
        int64_t skipped = lateness / period;
        n += skipped;
        deadline += (1 + skipped) * period;
    }
    return fwrite(seen, sizeof *seen, count, stdout) == (size_t)count ? 0 : 5;
}
"""


@dataclass(frozen=True, slots=True)
class LoopLatency:
    """Wake-up latencies of a loop without any work in it, or with work that is the same in every tick.

    `stretched` are ticks missed because that work was not done a whole period after the next one was due: what it took
    beyond its time, the machine took.
    """

    latency: Histogram
    missed: int
    stretched: int = 0


class ReferenceLoop:
    """The compiled loop; a context manager, because it lives in a temporary folder. `available()` says whether it can
    be made.
    """

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="gimbal-hil-")
        source = Path(self._folder.name) / "loop.c"
        self._program = source.with_suffix("")
        source.write_text(_SOURCE)
        subprocess.run(
            [compiler() or "cc", "-O2", "-o", str(self._program), str(source)], check=True, capture_output=True
        )

    def run(
        self, period: Duration, ticks: int, priority: int | None, core: int | None, work: Duration | None = None
    ) -> LoopLatency:
        """Run it under the same policy and on the same core as the loop that it is compared with; `work` is done after
        each wake-up.
        """
        words = [period.ns, ticks, priority or 0, -1 if core is None else core, work.ns if work else 0]
        output = subprocess.run([str(self._program), *map(str, words)], check=True, capture_output=True).stdout
        histogram = Histogram()
        missed = stretched = 0
        for late, worked in struct.iter_unpack("=qq", output):
            histogram.add(late)
            missed += late // period.ns
            # as in `tick_engine`: a deadline that passes during the work is met late, and only a whole period more is a
            # tick lost
            stretched += max(0, (late % period.ns + worked) // period.ns - 1)
        return LoopLatency(histogram, missed, stretched)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._folder.cleanup()


def compiler() -> str | None:
    """The C compiler to use, None when there is none or the loop is not written for this system."""
    if not sys.platform.startswith("linux"):
        return None
    return shutil.which(os.environ.get("CC", "cc")) or shutil.which("gcc")
