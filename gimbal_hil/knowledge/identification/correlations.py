"""Which identified numbers hang together: correlations, condition, and the worst pair in words.

An interval says how far one number may move while the others follow. Where two follow each other, both intervals are
wide and one combination is known well: who needs only that combination has it, who needs both has to make another run.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.identification.estimate import IDENTIFIED_RELATIVE_WIDTH, Estimate
from gimbal_hil.knowledge.identification.least_squares import LeastSquaresFit, Unknown

Matrix = NDArray[np.float64]

#: two numbers hang together from this correlation on: then one given the other is known less than half as loosely
HANG_TOGETHER = 0.9
#: half of a 95 % interval in standard errors
_HALF_WIDTH = 1.96


@dataclass(frozen=True)
class Correlations:
    """`matrix` (k, k) of the errors of k numbers, and how large each is relative to its number, (k,): standard errors,
    infinite where the number is zero.
    """

    names: tuple[str, ...]
    matrix: Matrix
    relative: Matrix

    @property
    def condition(self) -> float:
        """Largest over smallest eigenvalue of the correlations; 1 where every number is known by itself."""
        if not self.names:
            return 1.0
        values = np.linalg.eigvalsh(self.matrix)
        return float(values[-1] / max(values[0], 1e-12 * values[-1]))

    @property
    def worst_pair(self) -> tuple[int, int] | None:
        """Of those that hang together the two that are known worst, else the closest; None for fewer than two."""
        k = len(self.names)
        pairs = [(i, j) for i in range(k) for j in range(i + 1, k)]
        together = [pair for pair in pairs if abs(self.matrix[pair]) >= HANG_TOGETHER]
        if together:
            return max(together, key=lambda pair: max(self._sum_and_difference(pair)))
        return max(pairs, key=lambda pair: abs(self.matrix[pair]), default=None)

    def worst(self, axis: str) -> str:
        """The worst pair as a sentence; empty for fewer than two numbers."""
        pair = self.worst_pair
        if pair is None:
            return ""
        i, j = pair
        one, other, r = self.names[i], self.names[j], float(self.matrix[pair])
        if abs(r) < HANG_TOGETHER:
            return f"the numbers of {axis} are told apart (closest: {one} and {other}, correlation {r:.2f})"
        together, apart = self._sum_and_difference(pair)
        known, left = ("sum", "how it divides between them") if r < 0.0 else ("difference", "how large both are")
        together, apart = sorted((together, apart))
        if apart <= IDENTIFIED_RELATIVE_WIDTH:
            return f"{one} and {other} of {axis} are correlated ({r:.3f}), and each is known nonetheless"
        return (
            f"{one} and {other} of {axis} cannot be told apart (correlation {r:.3f}): a weighted {known} of them is "
            f"known to {_percent(together)}, {left} to {_percent(apart)} only"
        )

    def _sum_and_difference(self, pair: tuple[int, int]) -> tuple[float, float]:
        """Half widths of sum and difference of two numbers, each in units of its error, relative to their sum."""
        size = max(float(np.sum(1.0 / self.relative[list(pair)])), 1e-12)
        r = float(self.matrix[pair])
        return tuple(_HALF_WIDTH * np.sqrt(2.0 * max(1.0 + sign * r, 0.0)) / size for sign in (1.0, -1.0))  # type: ignore[return-value]

    def as_record(self, axis: str) -> dict[str, object]:
        """Plain types for `identification.json`."""
        pair = self.worst_pair
        return {
            "names": list(self.names),
            "matrix": [[round(float(r), 6) for r in row] for row in self.matrix],
            "condition": self.condition,
            "worst": {"names": [self.names[i] for i in pair or ()], "text": self.worst(axis)},
        }


def of_all_axes(axes: Mapping[str, Correlations]) -> dict[str, object]:
    """Plain types for `identification.json`: the numbers of all axes as `AXIS.NAME`; axes are fitted by themselves."""
    names = [f"{axis}.{name}" for axis, found in axes.items() for name in found.names]
    matrix = np.zeros((len(names), len(names)))
    first = 0
    for found in axes.values():
        own = slice(first, first := first + len(found.names))
        matrix[own, own] = found.matrix
    return {"names": names, "matrix": [[round(float(r), 6) for r in row] for row in matrix]}


def of_fit(unknowns: Sequence[Unknown], best: LeastSquaresFit) -> Correlations:
    """Correlations of all unknowns of a least-squares fit, from its curvature."""
    size = np.maximum(np.linalg.norm(best.jacobian, axis=0), 1e-300)
    scaled = best.jacobian / size
    covariance = np.linalg.pinv(scaled.T @ scaled, rcond=1e-12, hermitian=True) * best.variance_scale
    errors = np.sqrt(np.diag(covariance)) / size
    # of a logarithm the error is relative already; another is a share of its bounds
    shares = [
        error if one.logarithmic else error * max(abs(one.low), abs(one.high)) / max(abs(value), 1e-300)
        for error, one, value in zip(errors, unknowns, best.values, strict=True)
    ]
    return Correlations(tuple(one.name for one in unknowns), _scaled(covariance), np.array(shares))


def of_replicates(names: Sequence[str], replicates: Matrix, values: Matrix) -> Correlations:
    """Correlations of numbers (k,) from their bootstrap replicates, (repeats, k); what never changes is left out."""
    spread = np.std(replicates, axis=0)
    there = np.flatnonzero(spread > 0.0)
    covariance = np.atleast_2d(np.cov(replicates[:, there], rowvar=False))
    size = np.abs(values[there])
    relative = np.where(size > 0.0, spread[there] / np.where(size > 0.0, size, 1.0), np.inf)
    return Correlations(tuple(names[int(k)] for k in there), _scaled(covariance), relative)


def joined(estimates: Sequence[Estimate], fits: Sequence[tuple[Sequence[Estimate], Correlations]]) -> Correlations:
    """Correlations of final estimates that data determined: those of one fit as that fit has them, none between numbers
    of different fits, which come from different motion.
    """
    places: list[tuple[str, int, int]] = []
    for estimate in estimates:
        for number, (own, correlations) in enumerate(fits):
            same = any(one.name == estimate.name and one.interval == estimate.interval for one in own)
            if same and estimate.name in correlations.names and np.isfinite(estimate.fitted):
                places.append((estimate.name, number, correlations.names.index(estimate.name)))
                break
    matrix = np.eye(len(places))
    for a, (_, fit, i) in enumerate(places):
        for b, (_, other, j) in enumerate(places):
            if fit == other:
                matrix[a, b] = fits[fit][1].matrix[i, j]
    relative = np.array([fits[fit][1].relative[i] for _, fit, i in places])
    return Correlations(tuple(name for name, _, _ in places), matrix, relative)


def _scaled(covariance: Matrix) -> Matrix:
    errors = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    matrix = np.clip(covariance / np.outer(errors, errors), -1.0, 1.0)
    np.fill_diagonal(matrix, 1.0)
    return np.asarray(matrix)


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
