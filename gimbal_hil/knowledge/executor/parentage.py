"""No process of ours outlives the one that it works for, not even where that one is killed and can say nothing any
more.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys

#: prctl: the signal that the kernel sends when the thread that started this process is gone
_PR_SET_PDEATHSIG = 1


def end_with_parent(parent: int, number: int = signal.SIGTERM) -> None:
    """Have this process sent signal `number` when process `parent`, which started it, ends in whatever way; at once if
    it has ended.

    The kernel goes by the thread that started this process, so that thread has to live as long as `parent`. Does
    nothing where the kernel has no such call (it is Linux's).
    """
    if not sys.platform.startswith("linux"):
        return
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, ctypes.c_ulong(number), 0, 0, 0)
    if os.getppid() != parent:
        os.kill(os.getpid(), number)
