"""What a test says of a signal: `signal.settles_at(0.2, within(0.01).for_s(1).after(step, 2))`.

An answer is true or false as a whole and tells in words what was seen, so that a failed `assert` explains itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from firmware_protocol.errors import BadInputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class MadeStep:
    """A step of an axis' position reference: when (s, in the signals' time), from where, to where."""

    axis: str
    time_s: float
    start_rad: float
    target_rad: float


@dataclass(frozen=True)
class Judgement:
    """An answer with its reason."""

    holds: bool
    text: str

    def __bool__(self) -> bool:
        return self.holds

    def __repr__(self) -> str:
        return self.text


@dataclass(frozen=True)
class Band:
    """How near, for how long, from when on. See `within`."""

    tolerance: float
    duration_s: float = 0.0
    from_s: float = 0.0
    within_s: float = 0.0

    def for_s(self, duration_s: float) -> Band:
        """For so long without a break."""
        return replace(self, duration_s=duration_s)

    def after(self, moment: MadeStep | float, within_s: float = 0.0) -> Band:
        """From a step (or time, s) on; `within_s` is how long it may take until the time in the band begins."""
        return replace(self, from_s=moment.time_s if isinstance(moment, MadeStep) else moment, within_s=within_s)


def within(tolerance: float) -> Band:
    """A band of this half width about a value, in the signal's unit."""
    if not tolerance >= 0.0:
        raise BadInputError("within", f"{tolerance:g} is no tolerance", "0 or more")
    return Band(tolerance)


@dataclass(frozen=True, eq=False)
class Signal:
    """A signal of a run as far as it is recorded: `time_s` and `values`, both (n,), from the first feedback on."""

    name: str
    time_s: Floats
    values: Floats

    def between(self, start_s: float, end_s: float) -> Signal:
        """The part from one time to another, s."""
        part = (self.time_s >= start_s) & (self.time_s <= end_s)
        return Signal(self.name, self.time_s[part], self.values[part])

    def overshoot(self, step: MadeStep) -> float:
        """How far beyond the target of a step the signal goes, as a share of the step; 0 where it does not."""
        size = step.target_rad - step.start_rad
        after = self._values_after(step)
        return max(0.0, float(((after - step.target_rad) / size).max()))

    def largest(self, after: MadeStep | float = 0.0) -> float:
        """Largest size after a step or time."""
        return float(abs(self._values_after(after)).max())

    def stays_at(self, target: float, band: Band) -> Judgement:
        """Whether it is in the band from the time on that `after` says, for the whole time."""
        return self._settles(target, replace(band, within_s=0.0), "stays")

    def settles_at(self, target: float, band: Band) -> Judgement:
        """Whether it comes into the band in time and stays there for its duration."""
        return self._settles(target, band, "settles")

    def _settles(self, target: float, band: Band, verb: str) -> Judgement:
        wanted = f"{self.name} {verb} within {band.tolerance:g} of {target:g} for {band.duration_s:g} s"
        if band.within_s:
            wanted += f", at the latest {band.within_s:g} s after {band.from_s:.3f} s"
        else:
            wanted += f" from {band.from_s:.3f} s on"
        part = self.between(band.from_s, math.inf)
        # a sample short of the whole duration is the end of it; a gap, which a late machine leaves, is as its two ends
        enough_s = band.duration_s - 1.5 * self._period_s
        if self._end_s < band.from_s + enough_s or not len(part.time_s):
            return Judgement(False, f"{wanted}: the signal ends at {self._end_s:.3f} s")
        began: float | None = None
        for time_s, error in zip(part.time_s.tolist(), abs(part.values - target).tolist(), strict=True):
            if error <= band.tolerance:
                began = time_s if began is None else began
                if time_s - began >= enough_s:
                    return Judgement(True, f"{wanted}: from {began:.3f} s on")
            elif verb == "stays":
                return Judgement(False, f"{wanted}: off by {error:.4g} at {time_s:.3f} s")
            else:
                began = None
            if began is None and time_s > band.from_s + band.within_s:
                break
        if began is not None:
            return Judgement(False, f"{wanted}: the signal ends at {self._end_s:.3f} s")
        part = self.between(band.from_s, band.from_s + band.within_s + band.duration_s)
        worst = float(abs(part.values - target)[len(part.values) // 2 :].max())
        return Judgement(False, f"{wanted}: still off by up to {worst:.4g} in the second half of that time")

    def _values_after(self, moment: MadeStep | float) -> Floats:
        start = moment.time_s if isinstance(moment, MadeStep) else moment
        found = self.values[self.time_s >= start]
        if not len(found):
            raise BadInputError(self.name, f"has no value after {start:.3f} s", f"a time before {self._end_s:.3f} s")
        return found

    @property
    def _end_s(self) -> float:
        return float(self.time_s[-1]) if len(self.time_s) else 0.0

    @property
    def _period_s(self) -> float:
        """The step that is most common in time: sets that came late stand in one tick, and leave a gap before it."""
        steps = sorted((self.time_s[1:] - self.time_s[:-1]).tolist())
        return float(steps[len(steps) // 2]) if steps else 0.0
