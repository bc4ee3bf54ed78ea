"""Whether what the model lacks on an axis is still what it usually lacks: told from seconds in which the axis moved.

An axis that stands still says nothing: friction holds any torque up to break-away.
"""

from __future__ import annotations

import math
import statistics
from enum import StrEnum

#: seconds of motion that make what is usual, and how far beyond it counts as changed
LEARNING_WINDOWS, FACTOR = 10, 3.0
#: of a window in which the axis moved less than this nothing is learned, rad
LEAST_TRAVEL_RAD = 2e-3
#: how far below the threshold it is as usual again
_BACK = 0.7


class ObserverState(StrEnum):
    """What the model beside the antenna does."""

    #: none was asked for
    OFF = "off"
    #: its code is compiled and its model read
    LOADING = "loading"
    #: the model cannot be used; `problem` says why
    FAILED = "failed"
    #: no axis is under torque and free to move
    WAITING = "waiting"
    WATCHING = "watching"


class WatchState(StrEnum):
    """What is known of an axis."""

    LEARNING = "learning"
    USUAL = "as usual"
    CHANGED = "changed"


class AxisWatch:
    """One axis: fed tick by tick while it is free to move, judged once a window."""

    def __init__(self, window_ticks: int, least_nm: float) -> None:
        self._window_ticks, self._least_nm = window_ticks, least_nm
        self.state = WatchState.LEARNING
        self.usual_nm: float | None = None
        #: of the last whole window in which the axis moved
        self.rms_nm: float | None = None
        self._learned: list[float] = []
        self._squares, self._count, self._low, self._high = 0.0, 0, math.inf, -math.inf
        self._settling = True

    def settle(self) -> None:
        """The observer has begun anew: its first window counts for nothing."""
        self._begin()
        self._settling = True

    def learn_anew(self) -> None:
        """What comes from now on is usual."""
        self.state, self.usual_nm, self._learned = WatchState.LEARNING, None, []

    def take(self, missing_nm: float, position_rad: float) -> bool:
        """One tick; answers whether the state has just changed between usual and changed."""
        self._squares += missing_nm * missing_nm
        self._low, self._high = min(self._low, position_rad), max(self._high, position_rad)
        self._count += 1
        if self._count < self._window_ticks:
            return False
        rms, travel, settling = math.sqrt(self._squares / self._count), self._high - self._low, self._settling
        self._begin()
        self._settling = False
        return not settling and travel >= LEAST_TRAVEL_RAD and self._judge(rms)

    def _judge(self, rms_nm: float) -> bool:
        self.rms_nm = rms_nm
        if self.state is WatchState.LEARNING:
            self._learned.append(rms_nm)
            if len(self._learned) >= LEARNING_WINDOWS:
                self.usual_nm, self.state = statistics.median(self._learned), WatchState.USUAL
            return False
        assert self.usual_nm is not None
        threshold = max(FACTOR * self.usual_nm, self._least_nm)
        before = self.state
        if rms_nm > threshold:
            self.state = WatchState.CHANGED
        elif rms_nm < _BACK * threshold:
            self.state = WatchState.USUAL
        return self.state is not before

    def _begin(self) -> None:
        self._squares, self._count, self._low, self._high = 0.0, 0, math.inf, -math.inf
