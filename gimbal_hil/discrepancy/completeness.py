"""When causes explain a gap: channel by channel on both halves of the data, and over time where the model carries no bristle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.discrepancy.smoothing import Bands, Floats, block_means

#: a channel is explained below this many floors ...
COMPLETE_FLOORS = 1.5
#: ... or when this share of its gap is closed
_COMPLETE_SHARE = 0.97
#: a small gap that is only half closed is a field that a name happens to resemble: near the floor, this share must be closed too,
#: unless what is left is hardly above the floor
_CLOSED_WHEN_NEAR, _AT_FLOOR = 0.85, 1.25
#: a share of a gap says something only of one that is above this many floors
_A_GAP = 2.0
#: a gap that changes by less than this share is not touched by the causes; it stands aside below this share of the largest one
_UNTOUCHED, _ASIDE = 0.02, 0.4
#: a search ends once it is complete and no channel is above this; under it, what a cause leaves alone does not speak against it
CALM_FLOORS = 2.0
#: and what was there does not grow by more than this factor
_NO_LARGER = 1.02
#: a gap of hundreds of floors is not explained while this many are left, whatever the share
_STILL_FAR = 5.0
#: nothing is named where no gap is larger than this many floors; up to the next, names must close this share of all of them together
_LEAST_GAP, HARDLY_A_GAP, _CLOSED_OF_LITTLE = 1.7, 3.0, 0.75
#: a model without bristles is never followed to the noise: there the causes together must close this share of the gap of some channel
#: of a half, or this share of little
_COARSE_SHARE, _COARSE_OF_LITTLE = 0.12, 0.4
#: blocks (s) and standard errors of their mean by which a gain is there all along; or the share of them that gain, and how far from half
_BLOCK_S, _SURE, _MOST_BLOCKS, _SURE_SIGN = 1.0, 3.0, 0.8, 2.0


@dataclass(frozen=True)
class Half:
    """One half of the data, fitted or held out: the gap that was there and what is left of it, in floors (rows, channels)."""

    gap: Floats
    left: Floats
    #: rms per channel, in floors, by which the twin does not repeat itself; asked for only where something is left
    unsteadiness: Callable[[], Floats]

    @cached_property
    def before(self) -> Floats:
        """Rms of the gap per channel."""
        return rms(self.gap)

    @cached_property
    def after(self) -> Floats:
        """Rms of what is left per channel."""
        return rms(self.left)

    @cached_property
    def closed(self) -> Floats:
        """Share of the squared gap that is closed, per channel."""
        return np.asarray(1.0 - (self.after**2 - 1.0) / np.maximum(self.before**2 - 1.0, 1e-9))

    def explained(self, closed_in_all: Floats) -> NDArray[np.bool_]:
        """Channels that end near their floor, or of whose gap nearly all is closed."""
        # what a twin does not repeat is noise of its own
        unsteady = self.unsteadiness() if np.any(self.after > COMPLETE_FLOORS) else np.zeros(len(self.after))
        near = self.after <= COMPLETE_FLOORS * np.hypot(1.0, unsteady)
        near &= (self.closed >= _CLOSED_WHEN_NEAR) | (closed_in_all >= _COMPLETE_SHARE) | (self.after <= _AT_FLOOR)
        far = self.after > np.hypot(_STILL_FAR, COMPLETE_FLOORS * unsteady)
        return np.asarray(near | ((self.closed >= _COMPLETE_SHARE) & (self.before > _A_GAP) & ~far))

    def aside(self, largest: float) -> NDArray[np.bool_]:
        """Channels that causes do not touch and whose gap is not the largest: a remainder of their own, which does not speak against."""
        return np.asarray((np.abs(self.after - self.before) <= _UNTOUCHED * self.before) & (self.before < _ASIDE * largest))

    def quiet(self, calm: float) -> NDArray[np.bool_]:
        """Channels that had no more than so many floors, which is the floor's own uncertainty, and do not grow."""
        return np.asarray((self.before <= calm) & (self.after <= np.maximum(_NO_LARGER * self.before, _AT_FLOOR)))


def explains(halves: Sequence[Half], caused: bool, exact: bool, bands: Bands) -> bool:
    """Whether every channel of both halves is explained, set aside or quiet.

    Causes must have closed a gap: what had none before they came cannot prove them. Without `exact` (bristles in the model) what they
    take must be taken all along instead.
    """
    if caused and not exact and not throughout([(half.gap, half.left) for half in halves], bands):
        return False
    largest = max(float(np.max(half.before)) for half in halves)
    in_all, closing = _closed_in_all(halves), not exact
    for half in halves:
        if not exact and float(np.max(half.closed)) >= _COARSE_SHARE:
            continue
        explained = half.explained(in_all)
        if not np.all(explained | half.quiet(CALM_FLOORS if caused else COMPLETE_FLOORS) | (caused & half.aside(largest))):
            return False
        closing |= bool(np.any(explained & (half.before > COMPLETE_FLOORS)))
    return (closing and not _too_little(halves, largest, exact)) if caused else True


def throughout(logs: Sequence[tuple[Floats, Floats]], bands: Bands) -> bool:
    """Whether what causes take of (gap, left) is taken all along, not in the few rows in which a model without a bristle sets off."""
    blocks = np.concatenate([block_means(np.sum(gap**2 - left**2, axis=1), bands, _BLOCK_S) for gap, left in logs])
    n = len(blocks)
    if n < 3:
        return False
    # either nearly every block gains, however unlike they are, or on average they surely do
    taken = int(np.sum(blocks > 0.0))
    everywhere = taken >= _MOST_BLOCKS * n and taken - 0.5 * n > _SURE_SIGN * 0.5 * np.sqrt(n)
    return bool(everywhere or float(blocks.mean()) > _SURE * float(blocks.std(ddof=1)) / np.sqrt(n))


def rms(residual: Floats) -> Floats:
    """Root mean square per channel of (rows, channels)."""
    return np.asarray(np.sqrt(np.mean(residual**2, axis=0)))


def _closed_in_all(halves: Sequence[Half]) -> Floats:
    """Share of the squared gap that is closed on all halves together, per channel; zero where none is above its floor."""
    before = np.sum([half.before**2 - 1.0 for half in halves], axis=0)
    after = np.sum([half.after**2 - 1.0 for half in halves], axis=0)
    return np.where(before > 0.0, 1.0 - after / np.maximum(before, 1e-9), 0.0)


def _too_little(halves: Sequence[Half], largest: float, exact: bool) -> bool:
    """Whether the gaps are too small to name a cause for, or small and not closed by enough."""
    if largest < _LEAST_GAP:
        return True
    if largest >= HARDLY_A_GAP:
        return False
    before = np.concatenate([half.before**2 - 1.0 for half in halves])
    after = np.concatenate([half.after**2 - 1.0 for half in halves])
    there = before > COMPLETE_FLOORS**2 - 1.0
    closed = 1.0 - float(np.sum(np.maximum(after[there], 0.0))) / max(float(np.sum(before[there])), 1e-9)
    return closed < (_CLOSED_OF_LITTLE if exact else _COARSE_OF_LITTLE)
