"""The controller service: control, daemon, runs, experiments, identification, discrepancy.

In a script: `from gimbal_hil import Run, Antenna, identify, find_discrepancy` (docs/reference/library.md).
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any

from firmware_protocol.version import __version__
from gimbal_hil.moved import MovedFolders

if TYPE_CHECKING:
    from gimbal_hil.surface.library import (
        Antenna,
        Changes,
        Finding,
        Friction,
        Run,
        find_changes,
        find_discrepancy,
        identify,
    )

# The last bits of a matrix product depend on how many threads share it, and on small matrices threads only wait for one
# another: one thread everywhere gives the same answers on every executor. It has to be said before numpy is loaded; the
# user's word stands.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

sys.meta_path.append(MovedFolders)

__all__ = [
    "Antenna",
    "Changes",
    "Finding",
    "Friction",
    "Run",
    "__version__",
    "find_changes",
    "find_discrepancy",
    "identify",
]


def __getattr__(name: str) -> Any:
    """The library's names; nothing is loaded before one of them is asked for."""
    if name in __all__:
        import importlib

        return getattr(importlib.import_module("gimbal_hil.surface.library"), name)
    raise AttributeError(f"module 'gimbal_hil' has no attribute {name!r}")
