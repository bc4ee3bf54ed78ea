"""What guards cost that can be switched off by a setting: `python -m tests.benchmarks.guard_prices`.

The compiled path with each of them off, beside the shipped one, in one process, in turn in random order. The shipped
one stands there twice, to see what no change looks like.
"""

from __future__ import annotations

import gc
import random
import sys
import time
from collections.abc import Callable

import numpy as np

from gimbal_hil.loop.settings import DaemonSettings, shipped_settings
from gimbal_hil.proof.bench.speed import work_program
from gimbal_hil.realtime.lockstep import CompiledPath
from sim_backend.model import shipped_model
from tests.benchmarks.compare_commits import told

TICKS, EVERY, ROUNDS = 2000, 100, 600


def _running(settings: DaemonSettings, drive_watches: bool = True) -> Callable[[], object]:
    engine = CompiledPath(settings, shipped_model(), 1)
    engine.connect()
    engine.host.command(work_program(settings))
    if not drive_watches:
        for place in range(2):
            engine.device.drive.joints[place].strange_impulse = 0
    return lambda: engine.advance(TICKS, every=EVERY)


def main() -> int:
    """Print the ratio of each to the shipped path."""
    shipped = shipped_settings()
    axes = {name: axis.model_copy(update={"expectation": None}) for name, axis in shipped.axes.items()}
    bare = shipped.model_copy(update={"axes": axes})
    works = {
        "the shipped path again": _running(shipped),
        "without the weight that the host's runaway guard expects": _running(bare),
        "without the drive's own runaway guard": _running(shipped, drive_watches=False),
        "without both": _running(bare, drive_watches=False),
    }
    base = _running(shipped)
    gc.collect()
    gc.freeze()
    all_works = [base, *works.values()]
    for work in all_works * 10:
        work()
    times = np.zeros((len(all_works), ROUNDS))
    for number in range(ROUNDS):
        for place in random.sample(range(len(all_works)), len(all_works)):
            start = time.thread_time()
            all_works[place]()
            times[place, number] = time.thread_time() - start
    rng = np.random.default_rng(1)
    for place, name in enumerate(works, 1):
        print(f"{name}: {told(times[place] / times[0], rng)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
