"""Kernels compiled in two processes at once: a kernel is work for one core, and they do not need each other.

A second process asks for some of them and leaves them on disk; what it could not do is compiled when it is needed.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager

from gimbal_hil.warming.kernels import KERNELS, Kernel

#: (kernel, seconds that asking for it took)
Told = Callable[[Kernel, float], None]
#: as long as a slow machine takes for all kernels, and more
_MOST_S = 1800.0


def ask(kernels: Iterable[Kernel], told: Told) -> None:
    """Ask for one kernel after the other in this process."""
    for kernel in kernels:
        began = time.monotonic()
        kernel.ask()
        told(kernel, time.monotonic() - began)


def ask_on_two_cores(here: Sequence[str], beside: Sequence[str], told: Told) -> None:
    """Ask for the kernels named `here` in this process and for those named `beside` in a second one; back when both
    are done. With one core, or where one side is on disk already, they come one after the other in this process.
    """
    first = [kernel for kernel in kernels_named(here) if not kernel.on_disk]
    second = [kernel for kernel in kernels_named(beside) if not kernel.on_disk]
    if not first or not second or len(os.sched_getaffinity(0)) < 2:
        ask((*first, *second), told)
        return
    with _second_process(second) as process:
        ask(first, told)
        for kernel, line in zip(second, process.stdout or (), strict=False):
            told(kernel, float(line))


def kernels_named(names: Sequence[str]) -> tuple[Kernel, ...]:
    """Kernels by their short names, in that order."""
    by_name = {kernel.name: kernel for kernel in KERNELS}
    return tuple(by_name[name] for name in names)


@contextmanager
def _second_process(kernels: Sequence[Kernel]) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "gimbal_hil.warming", *(kernel.name for kernel in kernels)]
    process = subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    try:
        yield process
        process.wait(_MOST_S)
    finally:
        # an interrupt here must not leave it at work
        process.kill()
        process.communicate()
