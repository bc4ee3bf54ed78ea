"""Finds the part of a constant-speed segment in which the joint really moves at a constant speed, by stated tests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimbal_hil.knowledge.identification.averaging import Vector

#: two-sided 1 % point of the normal distribution, for the reverse-arrangement count
_TREND_LIMIT = 2.576
#: 1 % point of the largest excursion of a Brownian bridge, for the cumulative sum
_CUSUM_LIMIT = 1.628
#: robust deviations at which the first or last block still belongs to a transient
_OUTLYING = 3.5
_MIN_BLOCKS = 12


@dataclass(frozen=True)
class SteadyRule:
    """Limits of the search: how the segment is cut and what counts as steady.

    `tolerance` is the speed change, relative to the speed, that friction does not notice whatever the statistics say;
    `ripple` the scatter of block speeds, relative to the speed, above which the motion is stick-slip rather than
    sliding.
    """

    blocks: int = 40
    shortest_share: float = 0.3
    tolerance: float = 0.005
    ripple: float = 0.25


@dataclass(frozen=True)
class SteadyWindow:
    """Rows `start` (first) to `stop` (one past the last), the mean speed between them, and what the tests said."""

    start: int
    stop: int
    rate: float
    rate_error: float
    trend_score: float
    cusum_score: float
    ripple: float


def reverse_arrangement_score(values: Vector) -> float:
    """Standardised count of pairs in falling order; beyond +-2.58 a trend at 1 % (Bendat and Piersol, Random Data,
    section 4.5.2).
    """
    n = len(values)
    falling = int(np.sum(np.triu(values[:, None] > values[None, :], 1)))
    mean = n * (n - 1) / 4.0
    variance = n * (2 * n + 5) * (n - 1) / 72.0
    return float((falling - mean) / np.sqrt(variance))


def cusum_score(values: Vector) -> float:
    """Largest cumulative departure from the mean in units of `s sqrt(n)`; beyond 1.63 a change of level at 1 %."""
    centred = values - np.mean(values)
    # differences of neighbours estimate the scatter without being inflated by the very change that is looked for
    spread = float(np.sqrt(0.5 * np.mean(np.diff(values) ** 2)))
    return float(np.max(np.abs(np.cumsum(centred))) / (spread * np.sqrt(len(values)))) if spread > 0.0 else 0.0


def find_steady_window(time_s: Vector, position: Vector, rule: SteadyRule | None = None) -> SteadyWindow | None:
    """Longest stretch of a segment in which the joint speed is constant, or None when there is none.

    The segment (`time_s`, `position`, shape (n,), encoder position) is cut into equal blocks; a block's speed is the
    encoder travel over its time, so the encoder step enters once per block. From the longest down, a stretch of blocks
    is accepted when it moves one way, scatters less than `ripple`, and either passes both the reverse-arrangement and
    the cumulative-sum test at 1 %, or drifts by less than `tolerance` of the speed in total.
    """
    limits = rule or SteadyRule()
    n = len(time_s)
    blocks = min(limits.blocks, (n - 1) // 2)
    if blocks < _MIN_BLOCKS:
        return None
    edges = np.linspace(0, n - 1, blocks + 1).astype(np.int64)
    speeds = np.diff(position[edges]) / np.diff(time_s[edges])
    shortest = max(_MIN_BLOCKS, int(np.ceil(limits.shortest_share * blocks)))
    for length in range(blocks, shortest - 1, -1):
        # later stretches first: a start-up transient is more common than a late disturbance
        for first in range(blocks - length, -1, -1):
            found = _accept(speeds[first : first + length], limits)
            if found is not None:
                start, stop = int(edges[first]), int(edges[first + length]) + 1
                rate = mean_rate(time_s, position, start, stop)
                error = float(np.std(speeds[first : first + length], ddof=1) / np.sqrt(length))
                return SteadyWindow(start, stop, rate, error, *found)
    return None


def mean_rate(time_s: Vector, position: Vector, start: int, stop: int) -> float:
    """Mean speed over rows `start` (first) to `stop` (one past the last)."""
    return float((position[stop - 1] - position[start]) / (time_s[stop - 1] - time_s[start]))


def settled_start(values: Vector, rule: SteadyRule | None = None) -> tuple[int, float]:
    """First row from which a noisy series, shape (n,), has settled, and the drift (last minus first of its trend) that
    is left.

    The bristles settle over a travel, not a time: at the slowest speeds long after the speed itself is steady. Leading
    blocks are dropped until the block means pass the reverse-arrangement and cumulative-sum tests at 1 %. A loop that
    sways slowly never passes: then the start is where the squared error of the mean of the rest is smallest (the MSER
    rule, White, Simulation 69, 1997), and a trend that is still significant there is the drift.
    """
    limits = rule or SteadyRule()
    blocks = min(limits.blocks, len(values) // 4)
    if blocks < _MIN_BLOCKS:
        return 0, 0.0
    edges = np.linspace(0, len(values), blocks + 1).astype(np.int64)
    means = np.add.reduceat(values, edges[:-1]) / np.diff(edges)
    last = blocks - max(_MIN_BLOCKS, int(np.ceil(limits.shortest_share * blocks)))
    for first in range(last + 1):
        kept = means[first:]
        begins_inside = abs(kept[0] - np.median(kept)) <= _OUTLYING * _robust_scatter(kept)
        if begins_inside and abs(reverse_arrangement_score(kept)) < _TREND_LIMIT and cusum_score(kept) < _CUSUM_LIMIT:
            return int(edges[first]), 0.0
    best = min(range(last + 1), key=lambda first: float(np.var(means[first:])) / (blocks - first))
    kept = means[best:]
    if abs(reverse_arrangement_score(kept)) < _TREND_LIMIT:
        return int(edges[best]), 0.0
    index = np.arange(len(kept)) - (len(kept) - 1) / 2.0
    return int(edges[best]), float(np.dot(index, kept) / np.dot(index, index)) * len(kept)


def _robust_scatter(values: Vector) -> float:
    """Standard deviation from the median absolute deviation, which a few outlying blocks do not move."""
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def _accept(speeds: Vector, limits: SteadyRule) -> tuple[float, float, float] | None:
    mean = float(np.mean(speeds))
    if mean == 0.0 or np.any(speeds * mean < 0.0):
        return None
    ripple = float(np.std(speeds, ddof=1) / abs(mean))
    centre = float(np.median(speeds))
    allowed = max(_OUTLYING * _robust_scatter(speeds), 5.0 * limits.tolerance * abs(mean))
    if ripple > limits.ripple or max(abs(speeds[0] - centre), abs(speeds[-1] - centre)) > allowed:
        return None
    index = np.arange(len(speeds)) - (len(speeds) - 1) / 2.0
    drift = abs(float(np.dot(index, speeds) / np.dot(index, index))) * len(speeds)
    trend, cusum = reverse_arrangement_score(speeds), cusum_score(speeds)
    unnoticed = drift < limits.tolerance * abs(mean) and float(
        np.max(np.abs(speeds - mean))
    ) < 5.0 * limits.tolerance * abs(mean)
    if unnoticed or (abs(trend) < _TREND_LIMIT and cusum < _CUSUM_LIMIT):
        return trend, cusum, ripple
    return None
