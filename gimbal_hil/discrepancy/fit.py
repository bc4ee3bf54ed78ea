"""Refit by Gauss-Newton on the twin's residual, in units of the floors, with weak priors on numbers that are known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimbal_hil.discrepancy.hypothesis import Hypothesis, parameters_of
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.twin import Twin

_STEP = 0.02
_RIDGE = 1e-3
#: residual, in floors, of a hypothesis that the twin cannot carry
_BROKEN = 1e6


@dataclass(frozen=True)
class Fit:
    """A hypothesis at its best coordinates: residual (rows, channels) in floors, and its Jacobian (rows * channels, coordinates)."""

    hypothesis: Hypothesis
    residual: Floats
    jacobian: Floats

    @property
    def cost(self) -> float:
        """Sum of squares in floors."""
        return float(np.sum(self.residual**2))


def residual_of(twin: Twin, hypothesis: Hypothesis, floor: Floats) -> Floats:
    """Scored residual in floors, (rows, channels)."""
    return np.asarray(twin.residual(*parameters_of(twin, hypothesis)) / floor)


def prior_weights(hypothesis: Hypothesis) -> Floats:
    """One over the trust of every coordinate: next to nothing for causes, the stated share for known numbers."""
    causes = sum(len(cause.x) for cause in hypothesis.causes)
    return np.array([_RIDGE] * causes + [1.0 / known.trust for known in hypothesis.floating])


def refit(
    twin: Twin,
    hypothesis: Hypothesis,
    floor: Floats,
    rounds: int = 3,
    known: Floats | None = None,
    spread: float = 1.0,
    enough: float = 1e-4,
) -> Fit:
    """Gauss-Newton with step halving. `spread` multiplies the noise against which priors are weighed (correlated rows count less).

    `known` are the columns of the known numbers' Jacobian where they have been computed before: they hardly change. A step that takes less
    than the share `enough` of the cost is the last.
    """
    weights = prior_weights(hypothesis) * spread
    x = hypothesis.vector()
    residual = residual_of(twin, hypothesis, floor)
    jacobian = np.zeros((residual.size, len(x)))
    if not np.all(np.isfinite(residual)):
        return Fit(hypothesis, np.full_like(residual, _BROKEN), jacobian)
    for _ in range(rounds):
        jacobian = _jacobian(twin, hypothesis, floor, x, residual, known)
        prior = np.concatenate([np.zeros(len(x) - len(hypothesis.y)), np.array(hypothesis.y)]) * weights
        gradient = jacobian.T @ residual.ravel() + weights * prior
        normal = jacobian.T @ jacobian + np.diag(weights**2)
        scale = np.sqrt(np.diag(normal))
        step = np.linalg.lstsq(normal / np.outer(scale, scale), -gradient / scale, rcond=1e-9)[0] / scale
        cost = float(np.sum(residual**2)) + float(prior @ prior)
        length, better = 1.0, False
        for _ in range(4):
            trial = hypothesis.at(x + length * step)
            tried = residual_of(twin, trial, floor)
            tried_prior = np.array(trial.y) * weights[len(x) - len(trial.y) :]
            new = float(np.sum(tried**2)) + float(tried_prior @ tried_prior)
            if np.isfinite(new) and new < cost:
                better = True
                break
            length *= 0.35
        if not better:
            break
        hypothesis, x, residual = trial, trial.vector(), tried
        if cost - new < enough * cost:
            break
    return Fit(hypothesis, residual, jacobian)


def _jacobian(twin: Twin, hypothesis: Hypothesis, floor: Floats, x: Floats, residual: Floats, known: Floats | None) -> Floats:
    columns = []
    for i in range(len(x) if known is None else len(x) - known.shape[1]):
        moved = x.copy()
        moved[i] += _STEP
        trial = hypothesis.at(moved)
        if trial.vector()[i] == x[i]:
            moved[i] -= 2.0 * _STEP
            trial = hypothesis.at(moved)
        change = trial.vector()[i] - x[i]
        column = ((residual_of(twin, trial, floor) - residual) / change).ravel() if change != 0.0 else np.zeros(residual.size)
        # a coordinate that breaks the twin at its next step stays where it is
        columns.append(column if np.all(np.isfinite(column)) else np.zeros(residual.size))
    own = np.column_stack(columns) if columns else np.zeros((residual.size, 0))
    return own if known is None else np.hstack([own, known])
