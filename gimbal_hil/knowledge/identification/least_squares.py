"""Bounded nonlinear least squares from several starts, on logarithmic scales."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from gimbal_hil.knowledge.identification.averaging import Vector

Matrix = NDArray[np.float64]
#: physical parameter values, shape (p,), to residuals in units of their standard error, shape (n,); picklable for
#: parallel starts
ResidualFunction = Callable[[Vector], Vector]


@dataclass(frozen=True)
class Unknown:
    """One unknown: its name, physical bounds, and whether it is searched on a logarithmic scale (then both bounds are
    positive).
    """

    name: str
    low: float
    high: float
    logarithmic: bool = True

    def coordinate(self, value: float) -> float:
        """Search coordinate of a physical value."""
        return float(np.log(value)) if self.logarithmic else value / self._unit()

    def value(self, coordinate: float) -> float:
        """Physical value of a search coordinate."""
        return float(np.exp(coordinate)) if self.logarithmic else coordinate * self._unit()

    def _unit(self) -> float:
        return max(abs(self.low), abs(self.high))


@dataclass(frozen=True)
class LeastSquaresFit:
    """The best of all starts.

    `values` (p,) physical, `coordinates` (p,) the same in search coordinates, `residuals` (n,), `jacobian` (n, p) with
    respect to the coordinates, `sum_of_squares`, `degrees_of_freedom`, and `agreeing_starts`, how many starts ended at
    this minimum.
    """

    values: Vector
    coordinates: Vector
    residuals: Vector
    jacobian: Matrix
    sum_of_squares: float
    degrees_of_freedom: int
    agreeing_starts: int

    @property
    def variance_scale(self) -> float:
        """`max(1, S / dof)`: misfit beyond the stated errors widens every interval, a lucky fit does not narrow it."""
        return max(1.0, self.sum_of_squares / max(1, self.degrees_of_freedom))

    def coordinate_errors(self) -> Vector:
        """Standard errors of the search coordinates from the curvature, shape (p,); huge for a direction without
        influence.
        """
        _, singular, vt = np.linalg.svd(self.jacobian, full_matrices=False)
        floor = singular[0] * 1e-10 if singular.size else 0.0
        spread = (vt.T**2) @ (1.0 / np.maximum(singular, max(floor, 1e-150)) ** 2)
        return np.asarray(np.sqrt(spread * self.variance_scale))


@dataclass(frozen=True)
class _Problem:
    residuals: ResidualFunction
    parameters: tuple[Unknown, ...]
    difference_step: float | None
    tolerance: float

    def at(self, coordinates: Vector) -> Vector:
        return self.residuals(np.array([p.value(c) for p, c in zip(self.parameters, coordinates, strict=True)]))

    def bounds(self) -> tuple[Vector, Vector]:
        low = np.array([p.coordinate(p.low) for p in self.parameters])
        high = np.array([p.coordinate(p.high) for p in self.parameters])
        return low, high


def fit(
    residuals: ResidualFunction,
    parameters: Sequence[Unknown],
    starts: Sequence[Vector],
    difference_step: float | None = None,
    tolerance: float = 1e-12,
) -> LeastSquaresFit:
    """Minimise the sum of squared residuals within the bounds, from every start (physical values), and keep the best.

    `difference_step` is the relative step of the finite-difference Jacobian in search coordinates; give it when the
    residuals come from a simulation whose numerical noise is above rounding; `tolerance` is the relative change of the
    sum at which a start ends.
    """
    problem = _Problem(residuals, tuple(parameters), difference_step, tolerance)
    results = [_solve(problem, start) for start in starts]
    best = min(results, key=lambda result: result.sum_of_squares)
    limit = best.sum_of_squares + 1.0 * best.variance_scale
    return replace(best, agreeing_starts=sum(result.sum_of_squares <= limit for result in results))


def refit_with_fixed(
    residuals: ResidualFunction,
    parameters: Sequence[Unknown],
    start: Vector,
    fixed: dict[int, float],
    difference_step: float | None = None,
    tolerance: float = 1e-12,
) -> LeastSquaresFit:
    """Minimise over the free parameters while those in `fixed` (index to physical value) stay; values keep the full
    length.
    """
    free = [index for index in range(len(parameters)) if index not in fixed]
    base = np.array([fixed.get(index, start[index]) for index in range(len(parameters))], dtype=np.float64)

    def partial_residuals(values: Vector) -> Vector:
        full = base.copy()
        full[free] = values
        return residuals(full)

    if not free:
        r = residuals(base)
        return LeastSquaresFit(base, np.zeros(0), r, np.zeros((len(r), 0)), float(r @ r), len(r), 1)
    inner = fit(
        partial_residuals,
        [parameters[index] for index in free],
        [base[free]],
        difference_step=difference_step,
        tolerance=tolerance,
    )
    full = base.copy()
    full[free] = inner.values
    return replace(inner, values=full)


def _solve(problem: _Problem, start: Vector) -> LeastSquaresFit:
    low, high = problem.bounds()
    margin = 1e-6 * (high - low)
    x0 = np.clip([p.coordinate(v) for p, v in zip(problem.parameters, start, strict=True)], low + margin, high - margin)
    solution = least_squares(
        problem.at, x0, bounds=(low, high), x_scale="jac", diff_step=problem.difference_step,
        xtol=min(1e-4, 100.0 * problem.tolerance), ftol=problem.tolerance, gtol=1e-12, max_nfev=100,
    )  # fmt: skip
    values = np.array([p.value(c) for p, c in zip(problem.parameters, solution.x, strict=True)])
    r = np.asarray(solution.fun)
    return LeastSquaresFit(
        values, solution.x, r, np.asarray(solution.jac), float(r @ r), max(1, len(r) - len(values)), 1
    )
