"""Static LuGre parameters from a velocity map: robust, weighted, with profile intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.correlations import Correlations, of_fit
from gimbal_hil.knowledge.identification.estimate import Estimate
from gimbal_hil.knowledge.identification.least_squares import LeastSquaresFit, Matrix, Unknown, fit
from gimbal_hil.knowledge.identification.profile import ProfileTask
from gimbal_hil.knowledge.identification.settled import Asked, settle_parameters
from gimbal_hil.knowledge.identification.stribeck import LUGRE_UNITS, StaticFriction, stribeck_bump
from gimbal_hil.knowledge.identification.velocity_map import VelocityPoint

STATIC_NAMES = ("breakaway", "coulomb", "stribeck_velocity", "viscous", "shape")
_SHAPE_BOUNDS = (0.3, 6.0)
_ROUNDS = 8
#: residuals beyond this many (robust) standard deviations pull with constant force only
_OUTLIER = 2.5
#: share of a plateau's torque that its mean is exact to, however long it lasts: of a curve taken at mean speeds so much
#: was off on the simulated axis (tests/identification/test_coverage.py)
_INEXACT = 5e-5
#: the fluctuation of the speed is told from torque, where bristle damping takes part of it: it may be this much less or
#: more
_DOUBT = (0.25, 1.75)
_EXPERIMENTS = {
    "breakaway": "more plateaus below the Stribeck velocity, and slow torque ramps through break-away",
    "coulomb": "plateaus at three and more times the Stribeck velocity, both directions, several passes",
    "stribeck_velocity": "plateaus dense between a fifth and three times the Stribeck velocity, more passes each",
    "viscous": "plateaus at higher speeds (ten and more times the Stribeck velocity), both directions",
    "shape": "plateaus dense around the Stribeck velocity with more passes each",
}


class MapHalf(Enum):
    """Which half of the map a curve describes."""

    BOTH = "both"
    POSITIVE = "positive"
    NEGATIVE = "negative"


@dataclass(frozen=True)
class StaticFit:
    """A steady curve through a map, or through one half of it.

    `offset` is the constant torque that both directions share (BOTH only; zero else); `residuals` are measured minus
    fitted in torque units, in the order of `points`; `rms` is over them; `between_runs` is the scatter beyond the
    points' own errors that had to be granted to every point; `outliers` are the labels that were held down.
    """

    direction: MapHalf
    friction: StaticFriction
    estimates: tuple[Estimate, ...]
    offset: float
    points: tuple[VelocityPoint, ...]
    residuals: Vector
    rms: float
    between_runs: float
    outliers: tuple[str, ...]
    correlations: Correlations

    def torque(self, rate: Vector) -> Vector:
        """Fitted torque at signed rates, shape (n,), offset included."""
        return np.asarray(np.sign(rate) * self.friction.torque(np.abs(rate)) + self.offset)


@dataclass(frozen=True)
class _MapResiduals:
    """Weighted residuals of the static curve at `values` = Ts, Tc, vs, sigma2, delta [, offset]."""

    speed: Vector
    sign: Vector
    torque: Vector
    weight: Vector
    jitter: Vector

    def __call__(self, values: Vector) -> Vector:
        curve = StaticFriction(*(float(v) for v in values[:5])).torque_with_jitter(self.speed, self.jitter)
        offset = float(values[5]) if len(values) > 5 else 0.0
        return np.asarray((self.torque - self.sign * curve - offset) * self.weight)


#: points of a map that a curve of both directions takes: one more than its six unknowns
LEAST_POINTS = 7


def fit_static(
    points: Sequence[VelocityPoint], direction: MapHalf = MapHalf.BOTH, prior: StaticFriction | None = None
) -> StaticFit | None:
    """Fit `F(v) = Tc + (Ts - Tc) exp(-(v/vs)^delta) + sigma2 v` to a map; None when fewer points than unknowns are
    there.

    Where the speed fluctuates around its mean the curve is that of `torque_with_jitter`. Points weigh by their standard
    error (not below a fifth of the median one), to which a common scatter between runs is added when the residuals call
    for it. Ts, Tc and sigma2 enter linearly once vs and delta are given, so starts come from a grid over those two
    (variable projection, Golub and Pereyra 1973); everything is then refined together on logarithmic scales within
    physical bounds. Outliers are held down by Huber weights at 2.5 robust deviations. Intervals are profile likelihood.
    Parameters that the map does not determine keep their `prior`.
    """
    used = [p for p in points if direction is MapHalf.BOTH or (p.rate > 0.0) == (direction is MapHalf.POSITIVE)]
    unknowns = LEAST_POINTS - 1 if direction is MapHalf.BOTH else LEAST_POINTS - 2
    if len(used) <= unknowns:
        return None
    rate = np.array([p.rate for p in used])
    torque = np.array([p.torque for p in used])
    error = _point_errors(used)
    base = _MapResiduals(np.abs(rate), np.sign(rate), torque, 1.0 / error, np.array([p.jitter for p in used]))
    parameters = _parameters(base, with_offset=direction is MapHalf.BOTH)
    residuals, best, between = _robust_fit(base, parameters)
    correlations = of_fit(parameters, best)
    estimates, best = _estimates(
        residuals, parameters, best, prior, (float(np.min(np.abs(rate))), float(np.max(np.abs(rate))))
    )
    estimates = _doubting_jitter(estimates, residuals, parameters, best)
    friction = StaticFriction(*(float(v) for v in best.values[:5]))
    offset = float(best.values[5]) if direction is MapHalf.BOTH else 0.0
    misfit = torque - np.sign(rate) * friction.torque_with_jitter(base.speed, base.jitter) - offset
    held = residuals.weight * np.hypot(error, between) < 0.999
    return StaticFit(
        direction, friction, estimates, offset, tuple(used), misfit, float(np.sqrt(np.mean(misfit**2))),
        between, tuple(used[i].labels[0] for i in np.flatnonzero(held)), correlations,
    )  # fmt: skip


def _point_errors(points: Sequence[VelocityPoint]) -> Vector:
    errors = np.array([p.standard_error for p in points])
    floor = max(0.2 * float(np.median(errors)), 1e-12)
    return np.hypot(np.maximum(errors, floor), _INEXACT * np.abs([p.torque for p in points]))


def _parameters(data: _MapResiduals, with_offset: bool) -> tuple[Unknown, ...]:
    level = float(np.max(np.abs(data.torque)))
    slow, fast = float(np.min(data.speed)), float(np.max(data.speed))
    known = (
        Unknown("breakaway", 1e-3 * level, 10.0 * level),
        Unknown("coulomb", 1e-3 * level, 10.0 * level),
        Unknown("stribeck_velocity", slow / 10.0, fast * 3.0),
        Unknown("viscous", 1e-5 * level / fast, 10.0 * level / fast),
        Unknown("shape", *_SHAPE_BOUNDS),
    )
    return (*known, Unknown("offset", -level, level, logarithmic=False)) if with_offset else known


def _starts(data: _MapResiduals, parameters: Sequence[Unknown], count: int = 6) -> list[Vector]:
    """Best `count` of a grid over (vs, delta), the linear parameters solved for at each node."""
    candidates: list[tuple[float, Vector]] = []
    low, high = parameters[2].low, parameters[2].high
    for velocity in np.geomspace(low * 3.0, high / 3.0, 14):
        for shape in (0.5, 0.8, 1.1, 1.5, 2.2, 4.0):
            bump = stribeck_bump(data.speed, float(velocity), shape)
            columns = [data.sign * bump, data.sign * (1.0 - bump), data.sign * data.speed]
            if len(parameters) == 6:
                columns.append(np.ones_like(bump))
            design: Matrix = np.stack(columns, axis=1) * data.weight[:, None]
            linear = np.linalg.lstsq(design, data.torque * data.weight, rcond=None)[0]
            values = np.array([linear[0], linear[1], velocity, linear[2], shape, *linear[3:]])
            bounded = np.array(
                [
                    min(max(v, p.low * 1.01 if p.logarithmic else p.low), p.high)
                    for v, p in zip(values, parameters, strict=True)
                ]
            )
            candidates.append((float(np.sum(data(bounded) ** 2)), bounded))
    candidates.sort(key=lambda pair: pair[0])
    return [values for _, values in candidates[:count]]


def _robust_fit(base: _MapResiduals, parameters: Sequence[Unknown]) -> tuple[_MapResiduals, LeastSquaresFit, float]:
    """Reweighted least squares; answers the last round's residuals (for the intervals), its fit, and the scatter
    between runs.
    """
    error = 1.0 / base.weight
    current, between = base, 0.0
    best = fit(current, parameters, _starts(base, parameters))
    for _ in range(_ROUNDS):
        misfit = np.abs(base(best.values)) * error
        between = np.sqrt(max(0.0, (1.4826 * float(np.median(misfit))) ** 2 - float(np.median(error**2))))
        total = np.sqrt(error**2 + between**2)
        held = np.minimum(1.0, _OUTLIER * total / np.maximum(misfit, 1e-300))
        updated = replace(base, weight=np.sqrt(held) / total)
        if np.allclose(updated.weight, current.weight, rtol=1e-3):
            break
        current = updated
        best = fit(current, parameters, [best.values])
    return current, best, between


def _estimates(
    residuals: _MapResiduals,
    parameters: Sequence[Unknown],
    best: LeastSquaresFit,
    prior: StaticFriction | None,
    speeds: tuple[float, float],
) -> tuple[tuple[Estimate, ...], LeastSquaresFit]:
    """Estimates of the static parameters, and the fit with the undetermined ones at their prior."""
    priors = (
        [None] * 5
        if prior is None
        else [prior.breakaway, prior.coulomb, prior.stribeck_velocity, prior.viscous, prior.shape]
    )
    flat = ""
    if _no_bump(residuals, parameters, best):
        flat = f"between {speeds[0]:.3g} and {speeds[1]:.3g} rad/s the data need no Stribeck bump"
    asked = [
        Asked(name, unit, known, _EXPERIMENTS[name], flat if name in ("stribeck_velocity", "shape") else "")
        for name, unit, known in zip(STATIC_NAMES, LUGRE_UNITS[:5], priors, strict=True)
    ]
    return settle_parameters(ProfileTask(residuals, parameters, best), asked)


def _doubting_jitter(
    estimates: tuple[Estimate, ...], residuals: _MapResiduals, parameters: Sequence[Unknown], best: LeastSquaresFit
) -> tuple[Estimate, ...]:
    """Intervals stretched over what much less and much more fluctuation of the speed would give: it is inferred."""
    if not np.any(residuals.jitter):
        return estimates
    others = [
        fit(replace(residuals, jitter=scale * residuals.jitter), parameters, [best.values]).values for scale in _DOUBT
    ]
    return tuple(
        replace(e, interval=e.interval.stretched_over([float(other[i]) for other in others]))
        if np.isfinite(e.fitted)
        else e
        for i, e in enumerate(estimates)
    )


def _no_bump(residuals: _MapResiduals, parameters: Sequence[Unknown], best: LeastSquaresFit) -> bool:
    """True when Coulomb plus viscous friction fits as well, by the Bayesian information criterion (three parameters
    fewer).
    """
    level = float(best.values[1])
    tied = _Tied(residuals)
    reduced = [parameters[1], parameters[3], *parameters[5:]]
    simple = fit(tied, reduced, [np.array([level, float(best.values[3]), *best.values[5:]])])
    gain = (simple.sum_of_squares - best.sum_of_squares) / best.variance_scale
    return gain < 3.0 * np.log(len(best.residuals))


@dataclass(frozen=True)
class _Tied:
    """Coulomb plus viscous friction as a special case: Ts = Tc."""

    full: _MapResiduals

    def __call__(self, values: Vector) -> Vector:
        return self.full(np.array([values[0], values[0], 1.0, values[1], 1.0, *values[2:]]))
