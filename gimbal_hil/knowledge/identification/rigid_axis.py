"""Inertia, viscous and Coulomb friction and offset of one axis, by linear regression on filtered motion."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.signal import butter, sosfiltfilt

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.identification.averaging import Vector, autocorrelation_time
from gimbal_hil.knowledge.identification.estimate import Estimate, Interval, settle, withheld
from gimbal_hil.knowledge.identification.least_squares import Matrix

_REPEATS = 2000
#: a bootstrap block holds at least this many decorrelation times, and there are at least this many blocks
_TIMES_PER_BLOCK, _MIN_BLOCKS = 5.0, 8
#: a combination of columns, each of length 1, is nothing below this share of the largest; a column takes part in it
#: above that share
_DEPENDENT, _TAKES_PART = 1e-6, 1e-2
_EXPERIMENTS = {
    "inertia": "a trajectory with strong accelerations in both directions",
    "viscous": "plateaus at several speeds, both directions",
    "coulomb": "slow constant speeds, both directions",
    "offset": "equal travel in both directions at equal speeds",
}


@dataclass(frozen=True)
class RigidAxisRule:
    """How the regression is filtered: band of the fit, and what is dropped at each end.

    Motion is differentiated behind a zero-phase filter at five times `bandwidth_hz`; then torque and every regressor
    pass the same zero-phase filter at `bandwidth_hz`. The first and last `edge_periods / bandwidth_hz` seconds go, and
    so do rows slower than `slowest_share` of the top speed: there the sign of the speed says nothing about the
    friction.
    """

    bandwidth_hz: float
    edge_periods: float = 1.0
    slowest_share: float = 0.01


@dataclass(frozen=True)
class RigidAxisFit:
    """Estimates by name, rms of the torque residual, the same relative to the rms torque, and the rows behind them.

    `rate`, `torque`, `residual`, shape (n,), are at the decimated rows.
    """

    estimates: tuple[Estimate, ...]
    rms: float
    relative: float
    rate: Vector
    torque: Vector
    residual: Vector
    blocks: int

    def value(self, name: str) -> float:
        """Fitted value by name."""
        return next(estimate.fitted for estimate in self.estimates if estimate.name == name)


def centred_torque(torque: Vector) -> Vector:
    """Held torque seen at the samples: mean of the two values that meet at t_k, shape (n,).

    Row k acts over [t_k, t_k+1), so at t_k the mean of rows k-1 and k is in force; row k alone would be half a sample
    late and look like a delay or a flexibility.
    """
    return np.asarray(np.concatenate([torque[:1], 0.5 * (torque[1:] + torque[:-1])]))


def fit_rigid_axis(
    time_s: Vector,
    position: Vector,
    torque: Vector,
    rule: RigidAxisRule,
    per_direction: bool = False,
    linear: bool = False,
    seed: int = 0,
) -> RigidAxisFit:
    """Regress `torque = inertia a + viscous v + coulomb sign(v) + offset`, or with viscous and Coulomb friction per
    direction.

    `time_s`, `position`, `torque` (commanded, held over the sample), shape (n,), constant rate. The least-squares
    solution uses every sample behind the filters; intervals are percentiles of a block bootstrap (blocks of at least
    five decorrelation times of the residual), because filtered residuals are neither white nor equal in size along the
    trajectory.

    Raises:
        BadInputError: the table is shorter than the filters need or the joint does not move.
    """
    step = float(np.median(np.diff(time_s)))
    rate_hz = 1.0 / step
    edge = int(round(rule.edge_periods / rule.bandwidth_hz * rate_hz))
    if len(time_s) < 4 * edge + 200 or not np.ptp(position) > 0.0:
        raise BadInputError(
            "signals table",
            "too short or without motion for a regression",
            f"at least {4 * edge + 200} rows of a moving axis",
        )
    smooth = sosfiltfilt(_low_pass(5.0 * rule.bandwidth_hz, rate_hz), position)
    rate = np.gradient(smooth, step)
    names, columns = _columns(rate, np.gradient(rate, step), per_direction)
    narrow = _low_pass(rule.bandwidth_hz, rate_hz)
    design: Matrix = np.stack([sosfiltfilt(narrow, column) for column in columns], axis=1)
    target = sosfiltfilt(narrow, centred_torque(torque))
    keep = np.zeros(len(target), dtype=bool)
    keep[edge : len(target) - edge] = True
    keep &= np.abs(rate) >= rule.slowest_share * float(np.max(np.abs(rate)))
    thin = max(1, int(rate_hz / (2.5 * rule.bandwidth_hz)))
    rows = np.flatnonzero(keep)[::thin]
    design, target = design[rows], target[rows]
    size = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    solution = np.linalg.lstsq(design / size, target, rcond=_DEPENDENT)[0] / size
    residual = target - design @ solution
    open_ones = _undetermined(design / size)
    replicates, blocks = _block_bootstrap(design, target, residual, seed)
    estimates = []
    for index, name in enumerate(names):
        low, high = np.percentile(replicates[:, index], [2.5, 97.5])
        family = name.split("_")[0]
        if index in open_ones:
            partners = ", ".join(n for i, n in enumerate(names) if i in open_ones and i != index)
            reason = (
                f"in this motion it cannot be told from {partners}" if partners else "this motion does not depend on it"
            )
            estimates.append(withheld(name, _unit(family, linear), None, reason, _EXPERIMENTS[family]))
            continue
        estimates.append(
            settle(
                name,
                float(solution[index]),
                Interval(float(low), float(high)),
                _unit(family, linear),
                None,
                _EXPERIMENTS[family],
            )
        )
    rms = float(np.sqrt(np.mean(residual**2)))
    relative = rms / float(np.sqrt(np.mean(target**2)))
    return RigidAxisFit(tuple(estimates), rms, relative, rate[rows], target, residual, blocks)


def _columns(rate: Vector, acceleration: Vector, per_direction: bool) -> tuple[tuple[str, ...], tuple[Vector, ...]]:
    one = np.ones_like(rate)
    if not per_direction:
        return ("inertia", "viscous", "coulomb", "offset"), (acceleration, rate, np.sign(rate), one)
    forward, backward = np.maximum(rate, 0.0), np.minimum(rate, 0.0)
    # a common offset cannot be told from a difference between the two Coulomb levels: it is carried by them
    names = ("inertia", "viscous_positive", "viscous_negative", "coulomb_positive", "coulomb_negative")
    return names, (acceleration, forward, backward, (rate > 0.0).astype(np.float64), -(rate < 0.0).astype(np.float64))


def _low_pass(cutoff_hz: float, rate_hz: float) -> Matrix:
    return np.asarray(butter(4, min(cutoff_hz / (0.5 * rate_hz), 0.95), output="sos"))


def _block_bootstrap(design: Matrix, target: Vector, residual: Vector, seed: int) -> tuple[Matrix, int]:
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
    matrices = np.einsum("rb,bij->rij", counts, normal)
    # a resample without any row of one direction has no solution for it: a trace of the full data keeps it finite
    matrices += 1e-9 * np.sum(normal, axis=0)
    moments = counts @ moment + 1e-9 * np.sum(moment, axis=0)
    # columns of one size, so that what is cut off as dependent is that and not merely small; nothing is left of a
    # column of zeros
    size = np.sqrt(np.maximum(np.diag(np.sum(normal, axis=0)), 1e-300))
    inverse = np.linalg.pinv(matrices / np.outer(size, size), rcond=_DEPENDENT**2, hermitian=True)
    return np.einsum("rij,rj->ri", inverse, moments / size).reshape(_REPEATS, unknowns) / size, blocks


def _undetermined(scaled: Matrix) -> set[int]:
    """Indices of the columns, all of length 1 or zero, that take part in a combination which leaves nothing."""
    _, singular, vt = np.linalg.svd(scaled, full_matrices=False)
    nothing = vt[singular <= _DEPENDENT * singular[0]]
    return set(np.flatnonzero(np.any(np.abs(nothing) > _TAKES_PART, axis=0)).tolist())


def _unit(family: str, linear: bool) -> str:
    rotary = {"inertia": "kg m^2", "viscous": "N m s/rad", "coulomb": "N m", "offset": "N m"}
    straight = {"inertia": "kg", "viscous": "N s/m", "coulomb": "N", "offset": "N"}
    return (straight if linear else rotary)[family]
