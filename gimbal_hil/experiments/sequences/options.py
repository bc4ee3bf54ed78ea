"""What a person may choose of a sequence on the command line."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SequenceOptions:
    """Choices that all sequences understand; each takes what concerns it."""

    rate_hz: float
    axes: tuple[str, ...] = ("outer", "inner")
    #: a short variant for CI and demonstrations instead of the whole sequence
    short: bool = False
    #: keep one tick in so many in the log; None leaves it to the sequence
    every: int | None = None
