"""What loops are tuned for; nothing heavy is loaded here, because the command line's help needs it."""

from __future__ import annotations

from enum import StrEnum


class Aim(StrEnum):
    """Which disturbances count."""

    #: a direction held on an aircraft: gusts first
    POINTING = "pointing"
    #: joints that follow: friction first
    TRACKING = "tracking"
    BOTH = "both"
