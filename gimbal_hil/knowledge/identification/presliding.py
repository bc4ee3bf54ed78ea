"""Bristle stiffness from presliding motion: torque against micro-displacement, with the exact LuGre curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.estimate import Determination, Estimate, settle, withheld
from gimbal_hil.knowledge.identification.least_squares import LeastSquaresFit, Unknown, fit
from gimbal_hil.knowledge.identification.profile import (
    ProfileTask,
    between_pieces_ratio,
    profile_interval,
    robust_variance_ratio,
)
from gimbal_hil.knowledge.identification.stribeck import StaticFriction, stribeck_bump

#: below so many encoder steps of presliding travel sigma1 is not reported; below so many sigma0 is not either
STEPS_FOR_SIGMA1, STEPS_FOR_SIGMA0 = 20.0, 4.0
#: rows up to this share of the break-away torque are used: above, the curve turns into break-away itself
_HIGHEST_SHARE = 0.9
#: and compared up to this share: above, the bend depends on break-away and speed more than on stiffness
_COMPARED_SHARE = 0.75
#: a turn of the torque counts from this share of its range; the first 1/7 of a leg after a turn is left out
_TURNING_SHARE, _TURNING_PART = 0.02, 7
#: slow motion needs no more rows than about this a run: torque is known between them, and the legs are long
_ROWS = 1200
_SIGMA0_EXPERIMENT = (
    "slow torque ramps to about 0.8 of break-away and back, both signs, with a finer encoder or more repeats"
)
_BREAKAWAY_EXPERIMENT = "slow torque ramps through break-away from rest, both signs, several rates"


@dataclass(frozen=True)
class PreslidingRun:
    """Slow torque below break-away: `time_s`, `position` (encoder), `friction` (applied minus rigid-body torque), shape
    (n,).

    The run starts at rest, so that its first friction value is the torque that the bristles hold.
    """

    label: str
    time_s: Vector
    position: Vector
    friction: Vector


@dataclass(frozen=True)
class PreslidingFit:
    """Stiffness and break-away as seen in presliding, the rows used and what the fit predicts at them.

    `travel_steps` is the presliding travel in encoder steps (infinite for an ideal encoder), `secant` the straight-line
    stiffness of thesis eq. 4.11 on the same rows, for comparison only.
    """

    sigma0: Estimate
    breakaway: Estimate
    runs: tuple[PreslidingRun, ...]
    predicted: tuple[Vector, ...]
    travel_steps: float
    secant: float
    rms: float


def presliding_path(friction: Vector, sigma0: float, breakaway: float | Vector) -> Vector:
    """Displacement (rad) that a slowly changing friction torque, shape (n,), has brought about since its first row.

    For slow motion LuGre reads `dF/dq = sigma0 (1 - sign(q') F / Ts)`, whose solution between turning points is
    logarithmic: `dq = -+(Ts / sigma0) ln((Ts -+ F2) / (Ts -+ F1))`. From rest and F = 0 this is `-(Ts/sigma0) ln(1 -
    T/Ts)` (eq. 4.11 as corrected); unloading and inner loops follow from the same two branches. `breakaway` may be a
    level per row, (n,), of which each stretch between rows takes the mean. Torques at or beyond Ts are taken at 0.999
    Ts.
    """
    levels = np.broadcast_to(np.asarray(breakaway, dtype=np.float64), friction.shape)
    level = 0.5 * (levels[1:] + levels[:-1])
    before, after = (
        np.clip(friction[:-1], -0.999 * level, 0.999 * level),
        np.clip(friction[1:], -0.999 * level, 0.999 * level),
    )
    ahead = np.log((level - after) / (level - before))
    back = np.log((level + after) / (level + before))
    steps = np.where(after >= before, -ahead, back) * (level / sigma0)
    return np.concatenate([[0.0], np.cumsum(steps)])


def bristle_torque(friction: Vector, time_s: Vector, relaxation_s: float) -> Vector:
    """Torque sigma0 z that bends the bristles while sigma0 z + sigma1 z' is the friction torque, shape (n,).

    That is a first-order lag of `relaxation_s = sigma1 / sigma0`, started in balance; friction is taken as linear
    between rows.
    """
    if relaxation_s <= 0.0:
        return friction
    step = float(np.median(np.diff(time_s)))
    decay = float(np.exp(-step / relaxation_s))
    share = relaxation_s / step * (1.0 - decay)
    numerator = [1.0 - share, share - decay]
    balance = np.array([friction[0] * (1.0 - numerator[0])])
    return np.asarray(lfilter(numerator, [1.0, -decay], friction, zi=balance)[0])


@dataclass(frozen=True)
class _PathResiduals:
    """Measured minus predicted position over its error, each leg with its own zero; `values` = sigma0, Ts."""

    runs: tuple[PreslidingRun, ...]
    errors: tuple[float, ...]
    legs: tuple[NDArray[np.int64], ...]
    sigma1: float
    curve: StaticFriction | None

    def path(self, run: PreslidingRun, values: Vector) -> Vector:
        sigma0, breakaway = float(values[0]), float(values[1])
        bending = bristle_torque(run.friction, run.time_s, self.sigma1 / sigma0)
        path = presliding_path(bending, sigma0, breakaway)
        if self.curve is None:
            return path
        # towards break-away the speed is no longer nothing: one correction of the level s(v) with the speed of the path
        # itself
        speed = np.abs(np.gradient(path, run.time_s))
        sinking = stribeck_bump(speed, self.curve.stribeck_velocity, self.curve.shape)
        share = min(1.0, self.curve.coulomb / self.curve.breakaway)
        return presliding_path(bending, sigma0, breakaway * (share + (1.0 - share) * sinking))

    def aligned(self, number: int, values: Vector) -> Vector:
        """Predicted positions of one run, (n,), each leg set on the measurement; NaN in rows that do not count."""
        run, leg = self.runs[number], self.legs[number]
        counted = leg >= 0
        path = self.path(run, values)
        means = np.bincount(leg[counted], weights=(run.position - path)[counted]) / np.maximum(
            np.bincount(leg[counted]), 1
        )
        return np.asarray(np.where(counted, path + means[np.maximum(leg, 0)], np.nan))

    def leg_of_each_row(self) -> NDArray[np.int64]:
        """Number of the leg of each residual, counted through all runs."""
        before = np.cumsum([0, *(int(leg.max(initial=-1)) + 1 for leg in self.legs)])
        every = np.concatenate([leg[leg >= 0] + first for leg, first in zip(self.legs, before, strict=False)])
        return np.asarray(np.unique(every, return_inverse=True)[1])

    def __call__(self, values: Vector) -> Vector:
        pieces = []
        for number, (run, error) in enumerate(zip(self.runs, self.errors, strict=True)):
            misfit = run.position - self.aligned(number, values)
            pieces.append(misfit[self.legs[number] >= 0] / error)
        return np.concatenate(pieces)


def monotonic_legs(friction: Vector) -> NDArray[np.int64]:
    """Number of the monotonic leg of each row, shape (n,); -1 in the first seventh of a leg.

    At a turning point the moving inertia carries the joint on for a moment, which slow friction knows nothing of: legs
    are compared each with a zero of its own, after that moment.
    """
    swing = _TURNING_SHARE * float(np.ptp(friction))
    turns, extreme, rising = [0], 0, 0
    for row, value in enumerate(friction.tolist()):
        ahead = value - friction[extreme]
        if rising == 0 and abs(ahead) > swing:
            rising = 1 if ahead > 0.0 else -1
        if rising and ahead * rising >= 0.0:
            extreme = row
        elif rising and -ahead * rising > swing:
            turns.append(extreme)
            rising, extreme = -rising, row
    turns.append(len(friction))
    legs = np.full(len(friction), -1, dtype=np.int64)
    for number, (start, stop) in enumerate(pairwise(turns)):
        legs[start + (stop - start) // _TURNING_PART if number else start : stop] = number
    return legs


def fit_presliding(
    runs: Sequence[PreslidingRun],
    breakaway: float,
    encoder_step: float,
    prior_sigma0: float | None = None,
    sigma1: float = 0.0,
    sigma1_is_known: bool = True,
    curve: StaticFriction | None = None,
) -> PreslidingFit | None:
    """Fit sigma0, and Ts from the bend of the curve, to presliding runs; None when no run has usable rows.

    `breakaway` (N m) starts the search and limits the rows to nine tenths of it. `sigma1` is the bristle damping; when
    it is not known the intervals are stretched over what none and twice as much of it would give. `curve` is the steady
    curve as far as known: with it the level sinks with the speed that a ramp reaches near break-away. Intervals are
    profile likelihoods widened by the autocorrelation-robust variance of the residuals, which carry the encoder step,
    or by how the legs differ, whichever is more.
    """
    used = tuple(cut for run in runs if (cut := _below(run, _HIGHEST_SHARE * breakaway)) is not None)
    if not used:
        return None
    travel = max(float(np.ptp(run.position)) for run in used)
    steps = travel / encoder_step if encoder_step > 0.0 else float("inf")
    if steps < STEPS_FOR_SIGMA0:
        reason = f"presliding travel is {steps:.1f} encoder steps"
        nothing = withheld("sigma0", "N m/rad", prior_sigma0, reason, _SIGMA0_EXPERIMENT)
        seen = withheld("breakaway", "N m", breakaway, reason, _BREAKAWAY_EXPERIMENT)
        return PreslidingFit(
            nothing, seen, used, tuple(np.full(len(r.time_s), np.nan) for r in used), steps, float("nan"), float("nan")
        )
    residuals, best = _solve(used, breakaway, encoder_step, sigma1, curve)
    ratio = np.maximum(robust_variance_ratio(best), between_pieces_ratio(best, residuals.leg_of_each_row()))
    task = ProfileTask(residuals, _parameters(used, breakaway), best, ratio)
    others = (
        ()
        if sigma1_is_known
        else (_solve(used, breakaway, encoder_step, other, curve)[1].values for other in (0.0, 2.0 * sigma1))
    )
    spread = np.stack([best.values, *others])
    intervals = [profile_interval(task, index).stretched_over(spread[:, index].tolist()) for index in (0, 1)]
    sigma0 = settle("sigma0", float(best.values[0]), intervals[0], "N m/rad", prior_sigma0, _SIGMA0_EXPERIMENT)
    seen = settle("breakaway", float(best.values[1]), intervals[1], "N m", breakaway, _BREAKAWAY_EXPERIMENT)
    if sigma0.verdict is Determination.IDENTIFIED and steps < STEPS_FOR_SIGMA1:
        few = f"only {steps:.1f} encoder steps of presliding travel"
        sigma0 = replace(sigma0, verdict=Determination.WEAKLY_IDENTIFIED, reason=few, experiment=_SIGMA0_EXPERIMENT)
    predicted = tuple(residuals.aligned(number, best.values) for number in range(len(used)))
    misfit = np.concatenate([run.position - path for run, path in zip(used, predicted, strict=True)])
    return PreslidingFit(sigma0, seen, used, predicted, steps, _secant(used), float(np.sqrt(np.nanmean(misfit**2))))


def _parameters(runs: Sequence[PreslidingRun], breakaway: float) -> tuple[Unknown, ...]:
    secant = _secant(runs)
    return (Unknown("sigma0", secant / 30.0, secant * 30.0), Unknown("breakaway", 0.5 * breakaway, 3.0 * breakaway))


def _solve(
    runs: tuple[PreslidingRun, ...], breakaway: float, encoder_step: float, sigma1: float, curve: StaticFriction | None
) -> tuple[_PathResiduals, LeastSquaresFit]:
    """Fit once with the encoder's own error, once more with the scatter that was found."""
    floor = max(encoder_step / np.sqrt(12.0), 1e-12)
    parameters = _parameters(runs, breakaway)
    starts = [np.array([_secant(runs) * factor, breakaway]) for factor in (1.0, 1.5, 3.0)]
    legs = tuple(
        np.where(np.abs(run.friction) < _COMPARED_SHARE * breakaway, monotonic_legs(run.friction), -1) for run in runs
    )
    residuals = _PathResiduals(runs, tuple(floor for _ in runs), legs, sigma1, curve)
    best = fit(residuals, parameters, starts)
    ends = np.cumsum([int(np.sum(leg >= 0)) for leg in legs])[:-1]
    scatter = tuple(max(floor, floor * float(np.std(piece))) for piece in np.split(best.residuals, ends))
    residuals = _PathResiduals(runs, scatter, legs, sigma1, curve)
    return residuals, fit(residuals, parameters, [best.values])


def _below(run: PreslidingRun, limit: float) -> PreslidingRun | None:
    """The run up to the first row whose friction torque reaches the limit; None when too little is left."""
    above = np.flatnonzero(np.abs(run.friction) > limit)
    stop = int(above[0]) if len(above) else len(run.friction)
    if stop < 20 or float(np.ptp(run.friction[:stop])) < 0.1 * limit:
        return None
    rows = slice(0, stop, max(1, stop // _ROWS))
    return PreslidingRun(run.label, run.time_s[rows], run.position[rows], run.friction[rows])


def _secant(runs: Sequence[PreslidingRun]) -> float:
    """Straight-line stiffness from rest to the largest torque, `dT / dz` of thesis eq. 4.11, mean over the runs."""
    found = []
    for run in runs:
        peak = int(np.argmax(np.abs(run.friction - run.friction[0])))
        travel = float(run.position[peak] - run.position[0])
        if travel != 0.0:
            found.append(abs(float(run.friction[peak] - run.friction[0]) / travel))
    return float(np.mean(found)) if found else 1.0
