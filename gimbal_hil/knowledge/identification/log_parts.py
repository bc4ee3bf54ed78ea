"""Whether all parts of a log ask for the same inertia, as the parts of one joint do.

A torque column that another gain was put on in the middle, that is larger one way than the other, or that belongs to a
position that is no angle of the joint still fits one line on the whole, with an interval around a number that nothing
in the log has. Friction may differ by time, direction and place; inertia may not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.estimation import ShiftedFit, ShiftedProblem, fit_at
from gimbal_hil.knowledge.identification.averaging import Vector, autocorrelation_time
from gimbal_hil.knowledge.identification.estimate import DataWarning, Interval
from gimbal_hil.knowledge.identification.least_squares import Matrix

_REPEATS = 1000
#: a bootstrap block holds at least this many decorrelation times, and there are at least this many blocks
_TIMES_PER_BLOCK, _MIN_BLOCKS = 5.0, 8
#: a combination of columns, each of length 1, is nothing below this share of the largest
DEPENDENT = 1e-6
#: a part says something with so many rows; inertias that differ by less of themselves are one to a reader
FEWEST_ROWS, _APART = 100, 0.05
#: an inertia that makes less than this share of the torque is told by the noise of the acceleration
_HEARD = 0.2


class LogCut(Enum):
    """Where a log is cut in two, in the words for both parts."""

    TIME = ("its first half", "its second")
    ACCELERATION = ("rows that speed up one way", "rows that speed up the other way")
    DIRECTION = ("motion one way", "motion the other way")
    PLACE = ("one side of its travel", "the other")


@dataclass(frozen=True)
class LogParts:
    """Two parts of a log whose inertias exclude each other, and the regressions of both."""

    cut: LogCut
    inertias: tuple[float, float]
    problems: tuple[ShiftedProblem, ShiftedProblem]

    def finding(self, axis: str) -> DataWarning:
        """What a reader must know of it."""
        one, other = self.cut.value
        text = (
            f"{one} of this log asks for an inertia of {self.inertias[0]:.3g}, {other} for {self.inertias[1]:.3g}: "
            "torque or position is not the same column in both, or something else moves the joint; the intervals hold "
            "both"
        )
        return DataWarning("two_inertias", text, axis)


def parts_apart(problem: ShiftedProblem, fit: ShiftedFit, position: Vector, seed: int) -> LogParts | None:
    """The two parts of a log whose inertias, the first column of its regression, differ most beyond their intervals;
    None where all agree. `position` is (n,), `fit` that of all rows.
    """
    found: list[tuple[float, LogParts]] = []
    for cut, rows in _cuts(problem, position):
        problems = tuple(replace(problem, rows=part) for part in rows)
        fits = [fit_at(part, fit.shift_s, fit.lag_s) for part in problems]
        first, second = (float(part.solution[0]) for part in fits)
        apart = abs(first - second) / max(abs(first), abs(second), 1e-300)
        heard = max(abs(first), abs(second)) * np.std(problem.columns[problem.rows, 0]) > _HEARD * np.std(fit.target)
        if heard and apart > _APART and not _inertia(fits[0], seed).overlaps(_inertia(fits[1], seed)):
            found.append((apart, LogParts(cut, (first, second), (problems[0], problems[1]))))
    return max(found, key=lambda pair: pair[0])[1] if found else None


def _cuts(problem: ShiftedProblem, position: Vector) -> Iterator[tuple[LogCut, tuple[NDArray[np.int64], ...]]]:
    rows = problem.rows
    place, acceleration = position[rows], problem.columns[rows, 0]
    for cut, first in (
        (LogCut.TIME, np.arange(len(rows)) < len(rows) // 2),
        (LogCut.ACCELERATION, acceleration > 0.0),
        (LogCut.DIRECTION, problem.columns[rows, 1] > 0.0),
        (LogCut.PLACE, place < np.median(place)),
    ):
        if min(np.count_nonzero(first), np.count_nonzero(~first)) >= FEWEST_ROWS:
            yield cut, (rows[first], rows[~first])


def _inertia(fit: ShiftedFit, seed: int) -> Interval:
    numbers, _ = block_bootstrap(fit.design, fit.target, fit.residual, seed)
    low, high = np.percentile(numbers[:, 0], [2.5, 97.5])
    return Interval(float(low), float(high))


def block_bootstrap(design: Matrix, target: Vector, residual: Vector, seed: int) -> tuple[Matrix, int]:
    """Solutions of resampled blocks, shape (repeats, p); normal equations are added up per block, so a repeat costs
    nothing.
    """
    n, unknowns = design.shape
    length = int(np.ceil(_TIMES_PER_BLOCK * autocorrelation_time(residual)))
    blocks = max(_MIN_BLOCKS, n // max(1, length))
    edges = np.linspace(0, n, blocks + 1).astype(np.int64)
    normal = np.stack([design[a:b].T @ design[a:b] for a, b in pairwise(edges)])
    moment = np.stack([design[a:b].T @ target[a:b] for a, b in pairwise(edges)])
    chosen = np.random.default_rng(seed).integers(0, blocks, size=(_REPEATS, blocks))
    counts = np.stack([np.bincount(row, minlength=blocks) for row in chosen]).astype(np.float64)
    matrices = (counts @ normal.reshape(blocks, -1)).reshape(-1, unknowns, unknowns)
    # a resample without any row of one direction has no solution for it: a trace of the full data keeps it finite
    matrices += 1e-9 * np.sum(normal, axis=0)
    moments = counts @ moment + 1e-9 * np.sum(moment, axis=0)
    # columns of one size, so that what is cut off as dependent is that and not merely small; nothing is left of a
    # column of zeros
    size = np.sqrt(np.maximum(np.diag(np.sum(normal, axis=0)), 1e-300))
    inverse = np.linalg.pinv(matrices / np.outer(size, size), rcond=DEPENDENT**2, hermitian=True)
    return np.einsum("rij,rj->ri", inverse, moments / size).reshape(_REPEATS, unknowns) / size, blocks
