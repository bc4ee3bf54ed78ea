"""The system call membarrier, which interrupts the cores that run registered processes and waits until they have taken
note.
"""

from __future__ import annotations

import ctypes
import platform
import sys
from collections.abc import Callable

#: number of the system call, by machine
_NUMBER = {"x86_64": 324, "aarch64": 283}
#: interrupt the cores of registered processes; register this process (from then on the witness can ask the core that
#: runs it)
GLOBAL_EXPEDITED, REGISTER_GLOBAL_EXPEDITED = 1 << 1, 1 << 2


def membarrier(command: int) -> Callable[[], object]:
    """A function that asks the kernel for `command`; does nothing where there is no such call."""
    number = _NUMBER.get(platform.machine()) if sys.platform.startswith("linux") else None
    if number is None:
        return lambda: None
    call = ctypes.CDLL(None).syscall
    return lambda: call(number, command, 0, 0)
