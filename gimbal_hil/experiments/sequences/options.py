"""What a person may choose of a sequence on the command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


def thesis_breakaway_nm() -> dict[str, float]:
    """Break-away torque of the thesis' antenna, N m, by axis: what presliding is scaled by where nothing better is known."""
    from gimbal_hil.experiments.printed_in_thesis import FRICTION

    return {axis: numbers[0] for axis, numbers in FRICTION.items()}


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
    breakaway_nm: Mapping[str, float] = field(default_factory=thesis_breakaway_nm)
    #: how the base moves where the antenna is virtual: `table/case` of the thesis (3.1/1 to 3.2/4), or a CSV file with a recorded motion
    base: str | None = None
