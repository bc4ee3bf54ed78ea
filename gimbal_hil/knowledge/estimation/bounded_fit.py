"""Nonlinear least squares inside bounds, never worse than where it began.

Gauss-Newton steps, each the exact solution of its bounded linear problem (scipy's `lsq_linear`), shortened until the
cost falls. The start is a point of the search, so a fit that contains another one and starts from it cannot end above
it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: how a step is shortened, and how often, before a fit is taken for finished
_SHORTER, _SHORTENINGS = 0.35, 5
#: share of the largest curvature, in units of each coordinate's own, that every direction has at least
_DAMPING = 1e-12


@dataclass(frozen=True)
class BoundedFit:
    """Where a fit ended: coordinates (k,), residual (n,), Jacobian (n, k) of the last step but one, cost (sum of
    squares).
    """

    x: Floats
    residual: Floats
    jacobian: Floats

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.residual @ self.residual)


def bounded_fit(
    residual_at: Callable[[Floats], Floats],
    jacobian_at: Callable[[Floats, Floats], Floats],
    x: Floats,
    low: Floats,
    high: Floats,
    rounds: int,
    enough: float = 1e-4,
) -> BoundedFit:
    """Minimise the sum of squares of `residual_at(x)` over low <= x <= high from x.

    `jacobian_at(x, residual)` gives (n, k). At most `rounds` steps; one that takes less than the share `enough` is the
    last. A residual that is not finite is a step too far.
    """
    x = np.clip(x, low, high)
    residual = residual_at(x)
    jacobian = np.zeros((len(residual), len(x)))
    if not np.all(np.isfinite(residual)):
        return BoundedFit(x, residual, jacobian)
    for _ in range(rounds if len(x) else 0):
        jacobian = jacobian_at(x, residual)
        step = _bounded_step(jacobian, residual, low - x, high - x)
        cost, length, better = float(residual @ residual), 1.0, False
        for _ in range(_SHORTENINGS):
            trial = np.clip(x + length * step, low, high)
            tried = residual_at(trial)
            if np.all(np.isfinite(tried)) and float(tried @ tried) < cost:
                better = True
                break
            length *= _SHORTER
        if not better:
            break
        taken = cost - float(tried @ tried)
        x, residual = trial, tried
        if taken < enough * cost:
            break
    return BoundedFit(x, residual, jacobian)


def _bounded_step(jacobian: Floats, residual: Floats, low: Floats, high: Floats) -> Floats:
    """The step inside its bounds after which the linearised residual is least; coordinates without effect stay."""
    from scipy.optimize import lsq_linear

    normal = jacobian.T @ jacobian
    gradient = jacobian.T @ residual
    size = np.sqrt(np.diag(normal))
    moving = (size > 1e-9 * max(float(size.max()), 1e-300)) & (high > low)
    step = np.zeros(len(size))
    if not np.any(moving):
        return step
    scale = size[moving]
    # the square root of the normal matrix stands for the long Jacobian
    values, vectors = np.linalg.eigh(normal[np.ix_(moving, moving)] / np.outer(scale, scale))
    # a direction that the data hardly see is damped, not left out: inside bounds nothing else would hold it, and two
    # coordinates that cancel each other would run away together
    root = np.sqrt(np.maximum(values, 0.0) + _DAMPING * values[-1])
    triangle, target = root[:, None] * vectors.T, -(vectors.T @ (gradient[moving] / scale)) / root
    bounds = low[moving] * scale, high[moving] * scale
    free = vectors @ (target / root)
    if np.any(free < bounds[0]) or np.any(free > bounds[1]):
        free = lsq_linear(triangle, target, bounds=bounds, method="bvls", max_iter=200).x
    step[moving] = free / scale
    return step
