"""Torque that depends on position alone, as one smooth curve shared by every speed and both directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lstsq

from gimbal_hil.knowledge.identification.averaging import Vector

_KNOTS = 60
#: knots that at least this part of the pieces of the busiest knot pass are where the curve is zero on average
_COMMON_SHARE = 0.8


@dataclass(frozen=True)
class PositionCurve:
    """Piecewise linear torque over position, zero on average where most pieces pass; `knots`, `values`: shape (k,)."""

    knots: Vector
    values: Vector

    def torque(self, position: Vector) -> Vector:
        """Torque at positions of any shape; constant beyond the outer knots."""
        return np.asarray(np.interp(position, self.knots, self.values))


def fit_position_curve(pieces: Sequence[tuple[Vector, Vector]], knots: int = _KNOTS) -> PositionCurve | None:
    """Curve through pieces of (position, torque), each piece with the same weight.

    Each piece keeps its own level as a nuisance parameter, so pieces over different stretches join. The curve is zero
    on average over the stretch that most pieces pass: what is constant there counts as friction. None when fewer than
    two pieces span a range, or when levels alone do as well (Bayesian information criterion).
    """
    usable = [(q, torque) for q, torque in pieces if len(q) > 2 and np.ptp(q) > 0.0]
    if len(usable) < 2:
        return None
    low, high = min(float(q.min()) for q, _ in usable), max(float(q.max()) for q, _ in usable)
    edges = np.linspace(low, high, knots + 1)
    centres = 0.5 * (edges[1:] + edges[:-1])
    rows, columns, means, weights = [], [], [], []
    for number, (q, torque) in enumerate(usable):
        bins = np.clip(((q - low) / (high - low) * knots).astype(np.int64), 0, knots - 1)
        counts = np.bincount(bins, minlength=knots)
        sums = np.bincount(bins, weights=torque, minlength=knots)
        filled = np.flatnonzero(counts)
        rows.extend([number] * len(filled))
        columns.extend(filled.tolist())
        means.extend((sums[filled] / counts[filled]).tolist())
        weights.extend(np.sqrt(counts[filled] / len(q)).tolist())
    values, gain = _levelled(np.array(rows), np.array(columns), np.array(means), np.array(weights), len(usable), knots)
    if gain < 0.0:
        return None
    covered = np.bincount(np.array(columns), minlength=knots)
    seen = covered > 0
    curve = np.interp(centres, centres[seen], values[seen])
    common = covered >= _COMMON_SHARE * int(np.max(covered))
    return PositionCurve(centres, curve - float(np.mean(curve[common])))


def _levelled(
    rows: Vector, columns: Vector, means: Vector, weights: Vector, pieces: int, knots: int
) -> tuple[Vector, float]:
    """Least squares of `mean = curve[column] + level[row]`, with the levels as weakly held nuisances.

    Answers the curve at its knots and what it gains over levels alone by the Bayesian information criterion; negative:
    not worth its unknowns.
    """
    n = len(means)
    design = np.zeros((n + pieces, knots + pieces))
    index = np.arange(n)
    design[index, columns.astype(np.int64)] = weights
    design[index, knots + rows.astype(np.int64)] = weights
    design[n + np.arange(pieces), knots + np.arange(pieces)] = 1e-3
    # complete orthogonal decomposition: a fifth of the time of the singular value decomposition that numpy takes
    solution = lstsq(
        design, np.concatenate([means * weights, np.zeros(pieces)]), lapack_driver="gelsy", check_finite=False
    )[0]
    misfit = (means - solution[columns] - solution[knots + rows]) * weights
    level = np.bincount(rows, weights=means * weights**2) / np.bincount(rows, weights=weights**2)
    plain = (means - level[rows]) * weights
    unknowns = len(np.unique(columns)) - 1
    floor = 1e-24 * float(means @ means) + 1e-300
    gain = n * np.log((float(plain @ plain) + floor) / (float(misfit @ misfit) + floor)) - unknowns * np.log(n)
    return np.asarray(solution[:knots]), float(gain)
