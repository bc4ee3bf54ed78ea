"""What the kernel grants a control process: exact timers, a real-time priority, locked memory, a core, and no
collector.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import resource
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

_PR_SET_TIMERSLACK, _PR_GET_TIMERSLACK = 29, 30
_MCL_CURRENT, _MCL_FUTURE = 1, 2


@dataclass(frozen=True, slots=True)
class Granted:
    """What was asked for and what came of it; `refused` has one line for each wish that was not granted, and why."""

    timer_slack_ns: int | None
    real_time_priority: int | None
    memory_locked: bool
    core: int | None
    refused: tuple[str, ...]

    def as_dict(self) -> dict[str, object]:
        """For JSON and run.yaml."""
        return {
            "timer_slack_ns": self.timer_slack_ns,
            "real_time_priority": self.real_time_priority,
            "memory_locked": self.memory_locked,
            "core": self.core,
            "refused": list(self.refused),
        }


def claim_real_time(priority: int = 60, core: int | None = None) -> Granted:
    """Ask for all of it for the calling thread; whatever is refused is reported and done without.

    The policy is set with "reset on fork": processes started later do not inherit it.
    """
    refused: list[str] = []
    slack = set_timer_slack(1)
    if slack is None:
        refused.append("timer slack: not a Linux kernel")
    granted_priority: int | None = None
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
        granted_priority = priority
    except (OSError, AttributeError) as error:
        refused.append(f"SCHED_FIFO: {_reason(error)} (needs CAP_SYS_NICE or an rtprio limit)")
    locked = _lock_memory()
    if locked is not None:
        refused.append(f"mlockall: {locked} (needs CAP_IPC_LOCK or a memlock limit)")
    pinned: int | None = None
    if core is not None:
        try:
            os.sched_setaffinity(0, {core})
            pinned = core
        except (OSError, AttributeError) as error:
            refused.append(f"core {core}: {_reason(error)}")
    return Granted(slack, granted_priority, locked is None, pinned, tuple(refused))


@contextlib.contextmanager
def real_time(priority: int = 60, core: int | None = None) -> Iterator[Granted]:
    """For the length of a block: all that `claim_real_time` gets, and the collector frozen and off; then as before."""
    cores, slack = available_cores(), timer_slack()
    collecting = gc.isenabled()
    granted = claim_real_time(priority, core)
    freeze_garbage()
    try:
        yield granted
    finally:
        gc.unfreeze()
        if collecting:
            gc.enable()
        with contextlib.suppress(OSError, AttributeError):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
            os.sched_setaffinity(0, cores)
            ctypes.CDLL(None).munlockall()
        if slack is not None:
            set_timer_slack(slack)


def set_timer_slack(ns: int) -> int | None:
    """Let timers of the calling thread be late by at most `ns` (default 50 us); answers what holds now, None if there
    is no such call.
    """
    if not sys.platform.startswith("linux"):
        return None
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(ns), 0, 0, 0)
    return timer_slack()


def timer_slack() -> int | None:
    """Timer slack of the calling thread in nanoseconds, None where the kernel has none."""
    if not sys.platform.startswith("linux"):
        return None
    answer = ctypes.CDLL(None).prctl(_PR_GET_TIMERSLACK, 0, 0, 0, 0)
    return answer if answer >= 0 else None


def reserved_for_normal_tasks() -> float:
    """Milliseconds of every second that the kernel keeps for tasks without real-time priority, and may take in one
    piece; 0 if none.
    """
    try:
        runtime, period = (
            int(Path(f"/proc/sys/kernel/sched_rt_{name}_us").read_text()) for name in ("runtime", "period")
        )
    except (OSError, ValueError):
        return 0.0
    return 0.0 if runtime < 0 else 1e3 * (period - runtime) / period


def freeze_garbage() -> None:
    """Collect once, keep what lives out of every later collection, and switch the collector off."""
    gc.collect()
    gc.freeze()
    gc.disable()


def available_cores() -> list[int]:
    """Cores that this process may use, in order."""
    with contextlib.suppress(AttributeError, OSError):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))


def control_and_witness_cores() -> tuple[int | None, int | None]:
    """The last core for control and another one for the witness; (None, None) where there is only one."""
    cores = available_cores()
    return (cores[-1], cores[-2]) if len(cores) > 1 else (None, None)


def _lock_memory() -> str | None:
    try:
        libc = ctypes.CDLL(None, use_errno=True)
        # with a finite limit, locking the future would make a later allocation fail instead of fault
        unlimited = os.geteuid() == 0 or resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] == resource.RLIM_INFINITY
        if libc.mlockall(_MCL_CURRENT | (_MCL_FUTURE if unlimited else 0)) == 0:
            return None
        return os.strerror(ctypes.get_errno())
    except (OSError, AttributeError) as error:
        return _reason(error)


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
