"""Regression of a signal that was perhaps logged at other times than what explains it: shifted, or behind a lag.

Torque and position of a log seldom have the same clock. A torque that is a row late, sampled instead of held, or that
comes through a low-pass makes friction out of inertia, so both numbers are unknowns like the others: `shift_s`, by
which the target is late, and `lag_s`, the time constant of a first-order lag that it went through. A lag is put on what
explains, never taken off the target: differences of a noisy target would be made small by smoothing it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

Floats = NDArray[np.float64]

#: a grid of shifts this share of the fastest period apart is fine enough to lead to the least sum of squares
_GRID = 0.05
#: Gauss-Newton steps, how often one is shortened, and what share of the cost makes the last one
_MOST_ROUNDS, _SHORTENINGS, _ENOUGH = 20, 6, 1e-7
#: step of time, s, over which the slope over the lag is taken
_DIFFERENCE_S = 1e-5


@dataclass(frozen=True)
class ShiftedProblem:
    """`target` (n,) + `known` (n,) is to be made of `columns` (n, k), all filtered alike, at rows of a period
    `step_s`.

    Only `rows` count. `band_hz` is the highest frequency that the filters left; shifts are sought up to `most_s` either
    way, lags up to as much.
    """

    step_s: float
    target: Floats
    known: Floats
    columns: Floats
    rows: NDArray[np.int64]
    band_hz: float
    most_s: float

    def sides(self, shift_s: float, lag_s: float) -> tuple[Floats, Floats]:
        """Target less its known part at the rows that count, and the columns there, (m,) and (m, k)."""
        explaining = _lagged(np.column_stack([self.columns, self.known]), self.step_s, lag_s)[self.rows]
        return self._at(shift_s) + explaining[:, -1], explaining[:, :-1]

    def _at(self, shift_s: float) -> Floats:
        return np.asarray(self._between(self.rows + shift_s / self.step_s))

    @cached_property
    def _between(self) -> CubicSpline:
        from scipy.interpolate import CubicSpline

        return CubicSpline(np.arange(len(self.target), dtype=np.float64), self.target)


@dataclass(frozen=True)
class ShiftedFit:
    """`solution` (k,) at a shift and a lag; `design` (m, k + free), its last columns what a later shift and a longer
    lag do, `target` (m,) and `residual` (m,).
    """

    solution: Floats
    shift_s: float
    lag_s: float
    design: Floats
    target: Floats
    residual: Floats

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.residual @ self.residual)


def fit_at(problem: ShiftedProblem, shift_s: float = 0.0, lag_s: float = 0.0, free: int = 0) -> ShiftedFit:
    """The linear fit at a shift and a lag; `free` (0, 1 or 2) is how many of both its design has columns for."""
    target, columns = problem.sides(shift_s, lag_s)
    solution, residual = _solved(columns, target)
    slopes = []
    if free > 0:
        # of the model, not of the target: the slope of a noisy target is noise for the most part
        modelled = _lagged(problem.columns @ solution - problem.known, problem.step_s, lag_s)
        slopes.append(-np.gradient(modelled, problem.step_s)[problem.rows])
    if free > 1:
        later, longer = problem.sides(shift_s, lag_s + _DIFFERENCE_S)
        slopes.append((residual - (later - longer @ solution)) / _DIFFERENCE_S)
    return ShiftedFit(solution, shift_s, lag_s, np.column_stack([columns, *slopes]), target, residual)


def fit_shifted(problem: ShiftedProblem, with_lag: bool = False, near_s: float | None = None) -> ShiftedFit:
    """The fit with the shift, and a lag where asked for, that leave least; sought everywhere, or `near_s` only.

    Gauss-Newton steps from the best place of a grid, shortened until the cost falls. A lag is a part of a torque that
    comes late: the shift beside it is never earlier than none.
    """
    step = _GRID / problem.band_hz
    shifts = np.arange(-problem.most_s, problem.most_s + 0.5 * step, step) if near_s is None else np.array([near_s])
    places = [(float(shift), 0.0) for shift in shifts if not with_lag or shift >= 0.0]
    if with_lag:
        places += [(0.0, shift) for shift, _ in places if shift > 0.0]
    count = 2 if with_lag else 1
    if not places:
        places = [(0.0, 0.0)]
    best = min((fit_at(problem, *place, count) for place in places), key=lambda one: one.cost)
    for _ in range(_MOST_ROUNDS):
        further = _step(best, with_lag)
        better = _shortened(problem, best, further, step, with_lag)
        if better is None:
            break
        gained, best = best.cost - better.cost, better
        if gained < _ENOUGH * best.cost:
            break
    return best


def _step(fit: ShiftedFit, with_lag: bool) -> Floats:
    """What the linear problem makes of shift and lag, (1,) or (2,); a shift that would become earlier than none beside
    a lag stays.
    """
    k = len(fit.solution)
    further = _solved(fit.design, fit.target)[0][k:]
    if not with_lag or fit.shift_s + further[0] >= 0.0:
        return further
    alone = _solved(np.delete(fit.design, k, axis=1), fit.target)[0][k:]
    return np.array([-fit.shift_s, alone[0]])


def _shortened(
    problem: ShiftedProblem, begun: ShiftedFit, further: Floats, longest: float, with_lag: bool
) -> ShiftedFit | None:
    """The fit after a step, or a part of it, that leaves less; None where none does."""
    length = min(1.0, longest / max(float(np.max(np.abs(further))), 1e-300))
    for _ in range(_SHORTENINGS):
        shift = begun.shift_s + length * float(further[0])
        lag = max(0.0, begun.lag_s + length * float(further[1])) if with_lag else 0.0
        if with_lag:
            shift = max(0.0, shift)
        if abs(shift) <= problem.most_s and lag <= problem.most_s:
            tried = fit_at(problem, shift, lag, len(further))
            if tried.cost < begun.cost:
                return tried
        length *= 0.35
    return None


def _solved(columns: Floats, target: Floats) -> tuple[Floats, Floats]:
    size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    scaled = columns / size
    # as many equations as columns: rows are many, columns few
    solution = np.asarray(np.linalg.pinv(scaled.T @ scaled, rcond=1e-12, hermitian=True) @ (scaled.T @ target)) / size
    return solution, target - columns @ solution


def _lagged(values: Floats, step_s: float, lag_s: float) -> Floats:
    """Values (n,) or (n, k) behind a first-order lag, taken as straight between rows, begun in balance."""
    from scipy.signal import lfilter

    if lag_s <= 0.0:
        return values
    decay = float(np.exp(-step_s / lag_s))
    share = lag_s / step_s * (1.0 - decay)
    numerator = [1.0 - share, share - decay]
    begun = np.atleast_1d(values[0] * (1.0 - numerator[0]))
    zi = begun[None, :] if values.ndim > 1 else begun
    return np.asarray(lfilter(numerator, [1.0, -decay], values, axis=0, zi=zi)[0])
