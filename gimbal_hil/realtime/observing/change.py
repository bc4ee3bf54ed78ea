"""Whether what the model lacks on an axis is still what it usually lacks: told from seconds in which the axis slid.

An axis that stands still says nothing: friction holds any torque up to break-away. What it held shows until the joint
has slid over some lengths of its bristles, and in the observer a little longer.
"""

from __future__ import annotations

import math
import statistics
from enum import StrEnum

#: windows of sliding that make what is usual, and how far beyond it counts as changed
LEARNING_WINDOWS, FACTOR = 10, 3.0
#: an axis that moves less than this in the time of a window stands, rad
LEAST_TRAVEL_RAD = 2e-3
#: over so many times what its bristles give a joint slides until what it held is forgotten (exp(-5) is 0.7 %)
_FORGOTTEN = 5.0
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
    """One axis: fed tick by tick while it is free to move, judged whenever it has slid for a window."""

    def __init__(self, window_ticks: int, settling_ticks: int, least_nm: float) -> None:
        """`settling_ticks` are those in which the observer forgets what it was wrong about."""
        self._window_ticks, self._settling_ticks, self._least_nm = window_ticks, settling_ticks, least_nm
        #: how far the joint moves on its bristles before it slides
        self.give_rad = 0.0
        self.state = WatchState.LEARNING
        self.usual_nm: float | None = None
        #: of the last whole window in which the axis slid
        self.rms_nm: float | None = None
        self._learned: list[float] = []
        self.settle()

    def settle(self) -> None:
        """The observer has begun anew: its first window counts for nothing."""
        self._squares, self._count = 0.0, 0
        self._slid_rad, self._unsure_ticks = 0.0, self._window_ticks
        self._from_rad: float | None = None
        self._stretch_squares, self._stretch_ticks = 0.0, 0

    def learn_anew(self) -> None:
        """What comes from now on is usual."""
        self.state, self.usual_nm, self._learned = WatchState.LEARNING, None, []

    def take(self, missing_nm: float, position_rad: float) -> bool:
        """One tick; answers whether the state has just changed between usual and changed."""
        if self._from_rad is None:
            self._from_rad = position_rad
        self._stretch_squares += missing_nm * missing_nm
        self._stretch_ticks += 1
        moved_rad = abs(position_rad - self._from_rad)
        slides = moved_rad >= max(LEAST_TRAVEL_RAD, self.give_rad)
        if not slides and self._stretch_ticks < self._window_ticks:
            return False
        squares, ticks = self._stretch_squares, self._stretch_ticks
        self._from_rad, self._stretch_squares, self._stretch_ticks = position_rad, 0.0, 0
        return self._is_sure(moved_rad if slides else 0.0, ticks) and self._gather(squares, ticks)

    def _is_sure(self, moved_rad: float, ticks: int) -> bool:
        """Whether a stretch of the motion counts: as it began friction was that of sliding, and the observer had seen
        it.
        """
        held, settling = self._slid_rad < max(LEAST_TRAVEL_RAD, _FORGOTTEN * self.give_rad), self._unsure_ticks > 0
        self._slid_rad = self._slid_rad + moved_rad if moved_rad > 0.0 else 0.0
        self._unsure_ticks = max(self._unsure_ticks - ticks, self._settling_ticks if held else 0)
        return moved_rad > 0.0 and not held and not settling

    def _gather(self, squares: float, ticks: int) -> bool:
        self._squares, self._count = self._squares + squares, self._count + ticks
        if self._count < self._window_ticks:
            return False
        rms = math.sqrt(self._squares / self._count)
        self._squares, self._count = 0.0, 0
        return self._judge(rms)

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
