"""Smoothing without delay, as people do it to a log before they save it: how it looks, and how it is taken back.

A column that was filtered forwards and backwards, or by a mean about each row, is not late: no shift and no lag tells.
But its fast parts are too small, and what is fast (inertia, the steps of Coulomb friction) is then too small beside
what is slow.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: of what less than this share is left there is nothing to take back: it would be rounding, made large
_LEAST_SHARE = 0.05


class SmoothingShape(Enum):
    """The share of a frequency f that is left, by its ratio to the one at which half is."""

    ONE_POLE = "a filter of first order, forwards and backwards"
    TWO_POLES = "a filter of second order, forwards and backwards"
    FOUR_POLES = "a filter of fourth order, forwards and backwards"
    MEAN = "a mean over rows to both sides"


_POLES = {SmoothingShape.ONE_POLE: 1, SmoothingShape.TWO_POLES: 2, SmoothingShape.FOUR_POLES: 4}
#: sin(pi x) / (pi x) is a half there
_HALF_OF_MEAN = 0.6034


@dataclass(frozen=True)
class Smoothing:
    """A smoothing of one shape that leaves half of the size of `half_hz`."""

    shape: SmoothingShape
    half_hz: float

    @classmethod
    def mean_over(cls, seconds: float) -> Smoothing:
        """The mean over a stretch of time."""
        return cls(SmoothingShape.MEAN, _HALF_OF_MEAN / seconds)

    def share(self, frequency_hz: Floats) -> Floats:
        """What is left of a frequency, (n,), -1 to 1."""
        ratio = frequency_hz / self.half_hz
        if self.shape is SmoothingShape.MEAN:
            return np.asarray(np.sinc(_HALF_OF_MEAN * ratio))
        return np.asarray(1.0 / (1.0 + ratio ** (2 * _POLES[self.shape])))

    def of(self, values: Floats, step_s: float) -> Floats:
        """Values (n,) or (n, k) after it."""
        return _filtered(values, self.share(_frequencies(len(values), step_s)))

    def undone(self, values: Floats, step_s: float) -> Floats:
        """Values (n,) before it, as far as anything is left of them."""
        share = self.share(_frequencies(len(values), step_s))
        return _filtered(values, share * (1.0 + _LEAST_SHARE**2) / (share**2 + _LEAST_SHARE**2))


def _frequencies(rows: int, step_s: float) -> Floats:
    return np.asarray(np.fft.rfftfreq(3 * rows - 2, step_s))


def _filtered(values: Floats, share: Floats) -> Floats:
    """Values times a share of each frequency, turned about their ends so that they go on with their slope there."""
    rows = len(values)
    before, after = 2.0 * values[:1] - values[:0:-1], 2.0 * values[-1:] - values[-2::-1]
    longer = np.concatenate([before, values, after])
    # a slope from end to end is none of the frequencies, and stays as it is
    slope = np.linspace(0.0, 1.0, len(longer)).reshape(-1, *(1,) * (values.ndim - 1)) * (longer[-1:] - longer[:1])
    spectrum = np.fft.rfft(longer - slope, axis=0) * share.reshape(-1, *(1,) * (values.ndim - 1))
    return np.asarray((np.fft.irfft(spectrum, len(longer), axis=0) + slope)[rows - 1 : 2 * rows - 1])
