"""What a person may choose of a sequence on the command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

#: break-away torque of the thesis' antenna (table 4.1, 4.2), N m: what presliding ramps are scaled by where nothing better is known
THESIS_BREAKAWAY_NM = {"outer": 0.2585, "inner": 0.1451}


@dataclass(frozen=True)
class SequenceOptions:
    """Choices that all sequences understand; each takes what concerns it."""

    rate_hz: float
    axes: tuple[str, ...] = ("outer", "inner")
    #: a short variant for CI and demonstrations instead of the whole sequence
    short: bool = False
    #: keep one tick in so many in the log; None leaves it to the sequence
    every: int | None = None
    #: break-away torque as far as known, N m, by axis
    breakaway_nm: Mapping[str, float] = field(default_factory=lambda: dict(THESIS_BREAKAWAY_NM))
    #: how the base moves where the antenna is virtual: `table/case` of the thesis (3.1/1 to 3.2/4), or a CSV file with a recorded motion
    base: str | None = None
