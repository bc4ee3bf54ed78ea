"""What a container holds, whatever wrote it: named columns with units, in groups that share their sample times."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from traceback import clear_frames

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SampledGroup:
    """Columns that were sampled together: `time_s` (n,) and `columns` (n,) by name, as the file has them; NaN where a
    row has no number.

    `time_s` counts from the first sample of the file; None where the file states no times. `units` are the file's own
    words, by column; absent where it states none. `timed_by` is the column that the times were read from, empty where
    they are the container's own.
    """

    name: str
    time_s: Floats | None
    columns: Mapping[str, Floats]
    units: Mapping[str, str] = field(default_factory=dict)
    timed_by: str = ""

    @property
    def rate_hz(self) -> float | None:
        """Rows a second, from the median step; None without times or with one row."""
        if self.time_s is None or len(self.time_s) < 2:
            return None
        step = float(np.median(np.diff(self.time_s)))
        return 1.0 / step if step > 0.0 else None


@dataclass(frozen=True)
class Contents:
    """Everything that could be read as numbers in one file; `notes` say what a reader of results should know."""

    path: Path
    kind: str
    groups: tuple[SampledGroup, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Container:
    """A kind of file: what it is called, how it is recognised by its path and first bytes, and what reads it.

    `extra` is the extra of this package that brings the library that owns the format; empty where none is needed.
    """

    name: str
    extra: str
    recognised: Callable[[Path, bytes], bool]
    read: Callable[[Path], Contents]


def missing(path: Path, kind: str, package: str, extra: str) -> BadInputError:
    """The one line for a library that is not installed."""
    return BadInputError(
        str(path), f"is {kind}, which needs the package {package}", f"pip install 'gimbal-hil[{extra}]'"
    )


def broken(path: Path, kind: str, error: BaseException) -> BadInputError:
    """The one line for a file that its own library does not read."""
    said = " ".join(str(error).split()) or type(error).__name__
    return BadInputError(str(path), f"is no complete {kind}: {said[:200]}", "the file as it was written")


def let_go(error: BaseException) -> None:
    """Drop what a library held half open when it failed on a file: its destructors fail too, and Python would print
    that on stderr beside the one line that a person reads.
    """
    kept, sys.unraisablehook = sys.unraisablehook, lambda unraisable: None
    try:
        one: BaseException | None = error
        while one is not None:
            clear_frames(one.__traceback__)
            one = one.__context__
        # what its parts refer to in a circle
        gc.collect()
    finally:
        sys.unraisablehook = kept


def from_first(times: Mapping[str, Floats], scale: float = 1.0) -> dict[str, Floats]:
    """Stamps of several groups in seconds from the first stamp of all, (n,) each."""
    first = min((float(stamps[0]) for stamps in times.values() if len(stamps)), default=0.0)
    return {name: (stamps - first) * scale for name, stamps in times.items()}
