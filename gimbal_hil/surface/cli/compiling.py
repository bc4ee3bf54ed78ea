"""What is compiled is said: a bar in a terminal, a line elsewhere, whichever command asks first and whichever kernel.

Numba reports every function that it compiles (and none that it finds on disk); only this module listens to it.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from numba.core import event as numba_event
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from firmware_protocol.kernel_cache import cache_directory
from gimbal_hil.surface.cli.progress import error_console

#: kernel -> what it is, functions that it inlines as counted from a cold start; the bar's length, nothing depends on it
_KERNELS: dict[str, tuple[str, int]] = {
    "device_frame_tick": ("the virtual antenna", 150),
    "pass_tick": ("the virtual antenna around the C device", 150),
    "host_frame_tick": ("the host", 124),
    "run_ticks": ("host and antenna in one loop", 300),
    "run_flight": ("host and antenna with errors of navigation in one loop", 300),
    "run_law": ("another law and antenna in one loop", 300),
    "run_blocks": ("host and antenna with every frame in one loop", 320),
    "run_open_loop": ("the plant alone", 60),
    "decide": ("host and antenna with predictive control, before its decision", 208),
    "answer": ("host and antenna with predictive control, after it", 5),
    "observe": ("the model beside the antenna", 110),
    "run_steps": ("the plant alone, for the bench", 60),
    "balance": ("the search's balance of torques", 60),
    "_respond": ("one axis with friction", 5),
    "law_along": ("laws of a model file along a log", 15),
    "_along": ("a rigid body along a log", 10),
    "_run": ("the thesis' control loops", 60),
    "_accelerations": ("the thesis' slips", 10),
    "sum_of_sines": ("a yardstick", 2),
}
#: share of a kernel's time that comes after its last inner function
_LAST_PASS = 0.1


@contextmanager
def compiling_shown() -> Iterator[None]:
    """Show what is compiled meanwhile in this process (not in those forked from it)."""
    listener = _Listener()
    numba_event.register("numba:compile", listener)  # type: ignore[no-untyped-call]
    try:
        yield
    finally:
        numba_event.unregister("numba:compile", listener)  # type: ignore[no-untyped-call]
        listener.close()


@dataclass
class _Work:
    """The kernel that is being compiled."""

    text: str
    began_s: float
    depth: int = 1


class _Listener(numba_event.Listener):  # type: ignore[misc]
    def __init__(self) -> None:
        self._process = os.getpid()
        self._work: _Work | None = None
        self._bar: Progress | None = None
        self._task: TaskID | None = None

    def on_start(self, event: Any) -> None:
        if os.getpid() != self._process:
            return
        if self._work is not None:
            self._work.depth += 1
            return
        name = event.data["dispatcher"].py_func.__name__
        if name in _KERNELS:
            text, functions = _KERNELS[name]
            self._work = _Work(text, time.monotonic())
            self._show(text, functions / (1.0 - _LAST_PASS))

    def on_end(self, event: object) -> None:
        if self._work is None or os.getpid() != self._process:
            return
        self._work.depth -= 1
        if self._bar is not None and self._task is not None:
            self._bar.advance(self._task)
        if self._work.depth == 0:
            took_s = time.monotonic() - self._work.began_s
            self._work = None
            if self._bar is None:
                print(f"compiled in {took_s:.0f} s", file=sys.stderr, flush=True)
            self.close()

    def close(self) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _show(self, text: str, functions: float) -> None:
        once = f"compiling {text} for this machine (once; kept in {cache_directory()})"
        console = error_console()
        if not console.is_terminal:
            print(once, file=sys.stderr, flush=True)
            return
        self._bar = Progress(
            TextColumn("compiling {task.description} (once on this machine)"),
            BarColumn(bar_width=28),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            console=console,
            transient=True,
        )
        self._task = self._bar.add_task(text, total=functions)
        self._bar.start()
