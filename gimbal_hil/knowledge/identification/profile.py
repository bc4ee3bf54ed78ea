"""Profile-likelihood intervals: how far a parameter can move, all others refitted, before the fit gets worse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from gimbal_hil.knowledge.identification.averaging import Vector, autocorrelation_time
from gimbal_hil.knowledge.identification.estimate import Interval
from gimbal_hil.knowledge.identification.least_squares import (
    LeastSquaresFit,
    Matrix,
    ResidualFunction,
    Unknown,
    refit_with_fixed,
)

_LEVEL = 0.95
_SEARCH_STEPS = 12
#: a sandwich from one series is itself uncertain: it narrows no interval by more than this share of its variance
_LEAST_RATIO = 0.02
#: pieces of a series count as repeats of one another: so many of them beyond the unknowns, that what is left of their
#: scatter says something
_PIECES_LEFT = 12


@dataclass(frozen=True)
class ProfileTask:
    """What is profiled: the residuals, their parameters and the best fit, with the difference step and tolerance of
    refits.

    `variance_ratio` (p,) scales the threshold of each parameter by the ratio of its autocorrelation-robust variance to
    the naive one (ones when residuals are independent).
    """

    residuals: ResidualFunction
    parameters: Sequence[Unknown]
    best: LeastSquaresFit
    variance_ratio: Vector | None = None
    difference_step: float | None = None
    tolerance: float = 1e-12


def profile_interval(task: ProfileTask, index: int) -> Interval:
    """95 % interval of parameter `index`, in physical units.

    The side ends where the refitted sum of squares exceeds the minimum by `t^2 s^2` with Student's t at the fit's
    degrees of freedom and s^2 its variance scale (Bates and Watts, Nonlinear Regression Analysis, 1988, section 6.1.2),
    or at the parameter's bound, which makes that side open.
    """
    low, open_low = _side(task, index, -1.0)
    high, open_high = _side(task, index, +1.0)
    return Interval(low, high, open_low, open_high)


def robust_variance_ratio(best: LeastSquaresFit) -> Vector:
    """Autocorrelation-robust variance over the naive one for each parameter, shape (p,).

    Above 1 where neighbouring residuals err alike; below it where they take back what the last one gave, as
    displacements between positions do that are each off by their own share of an encoder step.

    Bartlett-weighted sandwich (Newey and West, Econometrica 55, 1987) with a window of five autocorrelation times of
    the residual.
    """
    n, unknowns = best.jacobian.shape
    scores = best.jacobian * best.residuals[:, None]
    window = int(min(n // 4, np.ceil(5.0 * autocorrelation_time(best.residuals))))
    meat: Matrix = scores.T @ scores
    for lag in range(1, window + 1):
        cross = scores[lag:].T @ scores[:-lag]
        meat += (1.0 - lag / (window + 1.0)) * (cross + cross.T)
    bread = np.linalg.pinv(best.jacobian.T @ best.jacobian, rcond=1e-14)
    robust = np.diag(bread @ meat @ bread)
    naive = np.diag(bread) * max(best.sum_of_squares / best.degrees_of_freedom, 1e-300)
    return np.asarray(np.clip(robust / np.maximum(naive, 1e-300), _LEAST_RATIO, 1e4)).reshape(unknowns)


def pieces(lengths: Sequence[int], unknowns: int, longest: int) -> NDArray[np.int64]:
    """Number of the piece that each row of several series, of these lengths, belongs to: pieces of at most `longest`
    rows, and so many that their scatter is known beside so many unknowns. No piece crosses from one series to the next.
    """
    rows = max(1, min(longest, sum(lengths) // (unknowns + _PIECES_LEFT)))
    counts = [max(1, round(length / rows)) for length in lengths]
    first = np.cumsum([0, *counts[:-1]])
    found = [at + np.arange(n) * count // n for at, n, count in zip(first, lengths, counts, strict=True) if n]
    return np.concatenate(found) if found else np.zeros(0, dtype=np.int64)


def between_pieces_ratio(best: LeastSquaresFit, piece: NDArray[np.int64]) -> Vector:
    """Variance of each parameter as pieces of the data differ in it, over the naive one, shape (p,): what wanders from
    one piece to the next, as friction does, no residual of one row tells. Zero where there are too few pieces.

    Sandwich over pieces (Liang and Zeger, Biometrika 73, 1986) with what the unknowns have taken of their scatter, and
    Student's t of what is left in the place of the normal deviate.
    """
    unknowns = best.jacobian.shape[1]
    sums = np.zeros((int(piece.max(initial=-1)) + 1, unknowns))
    np.add.at(sums, piece, best.jacobian * best.residuals[:, None])
    left = len(sums) - unknowns
    if left < 1:
        return np.zeros(unknowns)
    bread = np.linalg.pinv(best.jacobian.T @ best.jacobian, rcond=1e-14)
    quantiles = student.ppf(0.5 + _LEVEL / 2.0, [left, best.degrees_of_freedom])
    scatter = np.diag(bread @ (sums.T @ sums) @ bread) * len(sums) / left * (quantiles[0] / quantiles[1]) ** 2
    naive = np.diag(bread) * max(best.sum_of_squares / best.degrees_of_freedom, 1e-300)
    return np.asarray(scatter / np.maximum(naive, 1e-300))


def _side(task: ProfileTask, index: int, direction: float) -> tuple[float, bool]:
    best, parameter = task.best, task.parameters[index]
    ratio = 1.0 if task.variance_ratio is None else float(task.variance_ratio[index])
    quantile = float(student.ppf(0.5 + _LEVEL / 2.0, best.degrees_of_freedom))
    threshold = best.sum_of_squares + quantile**2 * best.variance_scale * ratio
    bound = parameter.coordinate(parameter.high if direction > 0.0 else parameter.low)
    centre = float(best.coordinates[index])
    reach = abs(bound - centre)
    if reach == 0.0:
        return parameter.value(bound), True
    guess = float(best.coordinate_errors()[index]) * quantile * np.sqrt(ratio)
    step = min(guess if np.isfinite(guess) and guess > 0.0 else reach, reach)
    start = best.values
    inside, inside_excess = 0.0, best.sum_of_squares - threshold
    while True:
        value = parameter.value(centre + direction * step)
        refit = refit_with_fixed(
            task.residuals, task.parameters, start, {index: value}, task.difference_step, task.tolerance
        )
        excess = refit.sum_of_squares - threshold
        if excess > 0.0:
            break
        inside, inside_excess, start = step, excess, refit.values
        if step >= reach:
            return parameter.value(bound), True
        step = min(2.0 * step, reach)
    crossing = _crossing(task, index, centre, direction, (inside, inside_excess), (step, excess), threshold, start)
    return parameter.value(centre + direction * crossing), False


def _crossing(
    task: ProfileTask,
    index: int,
    centre: float,
    direction: float,
    inside: tuple[float, float],
    outside: tuple[float, float],
    threshold: float,
    start: Vector,
) -> float:
    """Distance from the best fit at which the profile meets the threshold: secant on the square root, kept in the
    bracket.
    """
    base = task.best.sum_of_squares
    limit = np.sqrt(threshold - base)
    (a, fa), (b, fb) = inside, outside
    for _ in range(_SEARCH_STEPS):
        ra, rb = np.sqrt(max(fa + threshold - base, 0.0)) - limit, np.sqrt(fb + threshold - base) - limit
        middle = a + (b - a) * (-ra / (rb - ra)) if rb > ra else 0.5 * (a + b)
        middle = min(max(middle, a + 0.05 * (b - a)), b - 0.05 * (b - a))
        value = task.parameters[index].value(centre + direction * middle)
        refit = refit_with_fixed(
            task.residuals, task.parameters, start, {index: value}, task.difference_step, task.tolerance
        )
        excess = refit.sum_of_squares - threshold
        if abs(excess) < 0.02 * (threshold - base):
            return float(middle)
        if excess > 0.0:
            b, fb = middle, excess
        else:
            a, fa, start = middle, excess, refit.values
    return float(0.5 * (a + b))
