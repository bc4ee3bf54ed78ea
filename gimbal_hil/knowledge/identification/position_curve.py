"""Torque that depends on position alone, as one curve shared by every speed and both directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import lstsq

from gimbal_hil.knowledge.identification.averaging import Vector

_KNOTS = 60
#: means that stand in for the rows between two knots, of each piece
_MEANS = 8
#: weight of a level of zero, and of a straight line through knots that no piece passes
_WEAK = 1e-3
#: knots that at least this part of the pieces of the busiest knot pass are where the curve is zero on average
_COMMON_SHARE = 0.8


@dataclass(frozen=True)
class PositionCurve:
    """Torque over position, a cubic spline through `values` at `knots`, shape (k,); zero on average where most pieces
    pass.
    """

    knots: Vector
    values: Vector

    def torque(self, position: Vector) -> Vector:
        """Torque at positions of any shape; constant beyond the outer knots."""
        inside = np.clip(position, self.knots[0], self.knots[-1])
        return np.asarray(CubicSpline(self.knots, self.values)(inside))


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
    cells = _means(usable, low, high, knots)
    if _gain(cells, len(usable), knots) < 0.0:
        return None
    # a mean over a cell of a ripple is too small, and one over a part of a cell stands elsewhere
    values = _through(_means(usable, low, high, knots * _MEANS), edges, len(usable))
    covered = np.bincount(cells.cell, minlength=knots)
    common = np.flatnonzero(covered >= _COMMON_SHARE * int(np.max(covered)))
    among = (common[:, None] + (np.arange(_MEANS) + 0.5) / _MEANS) * (high - low) / knots + low
    curve = PositionCurve(edges, values)
    return PositionCurve(edges, values - float(np.mean(curve.torque(among))))


@dataclass(frozen=True)
class _Means:
    """Mean positions and torques of pieces over cells of the range; `weight` is the root of a cell's share of its
    piece; all (n,).
    """

    piece: NDArray[np.int64]
    cell: NDArray[np.int64]
    position: Vector
    torque: Vector
    weight: Vector


def _means(pieces: Sequence[tuple[Vector, Vector]], low: float, high: float, cells: int) -> _Means:
    found = []
    for number, (q, torque) in enumerate(pieces):
        cell = np.clip(((q - low) / (high - low) * cells).astype(np.int64), 0, cells - 1)
        counts = np.bincount(cell, minlength=cells)
        filled = np.flatnonzero(counts)
        sums = [np.bincount(cell, weights=x, minlength=cells)[filled] / counts[filled] for x in (q, torque)]
        found.append((np.full(len(filled), number), filled, *sums, np.sqrt(counts[filled] / len(q))))
    return _Means(*(np.concatenate(column) for column in zip(*found, strict=True)))


def _through(means: _Means, knots: Vector, pieces: int) -> Vector:
    """Values at the knots of the spline that is nearest to the means, each piece with a level of its own; straight
    where no piece passes.
    """
    count = len(means.piece)
    design = np.zeros((count + pieces + len(knots) - 2, len(knots) + pieces))
    design[:count, : len(knots)] = CubicSpline(knots, np.eye(len(knots)))(means.position) * means.weight[:, None]
    design[np.arange(count), len(knots) + means.piece] = means.weight
    design[count + np.arange(pieces), len(knots) + np.arange(pieces)] = _WEAK
    design[count + pieces :, : len(knots)] = _WEAK * np.diff(np.eye(len(knots)), 2, axis=0)
    torque = np.concatenate([means.torque * means.weight, np.zeros(pieces + len(knots) - 2)])
    return _solved(design, torque)[: len(knots)]


def _gain(means: _Means, pieces: int, cells: int) -> float:
    """What a curve of one value a cell gains over levels alone by the Bayesian information criterion; negative: not
    worth its unknowns.
    """
    n, index = len(means.piece), np.arange(len(means.piece))
    design = np.zeros((n + pieces, cells + pieces))
    design[index, means.cell] = means.weight
    design[index, cells + means.piece] = means.weight
    design[n + np.arange(pieces), cells + np.arange(pieces)] = _WEAK
    solution = _solved(design, np.concatenate([means.torque * means.weight, np.zeros(pieces)]))
    misfit = (means.torque - solution[means.cell] - solution[cells + means.piece]) * means.weight
    share = means.weight**2
    level = np.bincount(means.piece, weights=means.torque * share) / np.bincount(means.piece, weights=share)
    plain = (means.torque - level[means.piece]) * means.weight
    unknowns = len(np.unique(means.cell)) - 1
    floor = 1e-24 * float(means.torque @ means.torque) + 1e-300
    gain = n * np.log((float(plain @ plain) + floor) / (float(misfit @ misfit) + floor)) - unknowns * np.log(n)
    return float(gain)


def _solved(design: NDArray[np.float64], wanted: Vector) -> Vector:
    """Least squares of least norm by complete orthogonal decomposition: a fifth of the time of the singular value
    decomposition that numpy takes.
    """
    return np.asarray(lstsq(design, wanted, lapack_driver="gelsy", check_finite=False)[0])
