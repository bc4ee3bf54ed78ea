"""Is what is written still there, and is there room for more? Looked at while recording, so that nothing is lost
without a message.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from firmware_protocol.errors import BadInputError

MB = 1 << 20


@dataclass(frozen=True, slots=True)
class Retention:
    """When a new segment begins, how much of the log is kept (None: all), and from how much free space on a run warns
    and ends; MiB.
    """

    segment_mb: float = 512.0
    keep_mb: float | None = None
    warn_below_mb: float = 2000.0
    stop_below_mb: float = 100.0


def free_mb(folder: Path) -> float | None:
    """Free space of the disk that a folder is on, MiB; None where that cannot be found out."""
    try:
        status = os.statvfs(folder)
    except OSError:
        return None
    return status.f_bavail * status.f_frsize / MB


def require_free(folder: Path, retention: Retention) -> None:
    """BadInputError where the disk that a folder is, or will be, on is so full that a run would have to end at once."""
    there = next((path for path in (folder, *folder.absolute().parents) if path.exists()), folder)
    free = free_mb(there)
    if free is not None and free < retention.stop_below_mb:
        least = f"more than recording.stop_below_mb ({retention.stop_below_mb:g})"
        raise BadInputError(str(folder), f"{free:.0f} MiB are left on its disk", least)


def vanished(folder: Path, files: Iterable[tuple[str, int]]) -> str | None:
    """Why what is written to these open files (name, descriptor) no longer reaches `folder`; None where it does."""
    for name, descriptor in files:
        try:
            kept = os.fstat(descriptor)
            there = os.stat(folder / name)
        except FileNotFoundError:
            return f"{folder / name} has been removed while it was recorded"
        except OSError as error:
            return f"{folder / name}: {error.strerror or error}"
        if (kept.st_ino, kept.st_dev) != (there.st_ino, there.st_dev):
            return f"{folder / name} has been replaced by another file while it was recorded"
    return None
