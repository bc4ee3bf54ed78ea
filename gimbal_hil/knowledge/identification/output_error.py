"""Output-error fit in the time domain (thesis section 4.4): simulate, compare motion, adjust the parameters.

Where the thesis descends along a finite-difference gradient of the squared rate error, this uses trust-region least
squares on logarithmic scales within bounds, from several starts, and reports how far each parameter could be moved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.axis_response import AxisRecord, simulate_axis
from gimbal_hil.knowledge.identification.correlations import Correlations, of_fit
from gimbal_hil.knowledge.identification.estimate import Estimate
from gimbal_hil.knowledge.identification.least_squares import LeastSquaresFit, Unknown, fit
from gimbal_hil.knowledge.identification.profile import (
    ProfileTask,
    between_pieces_ratio,
    pieces,
    robust_variance_ratio,
)
from gimbal_hil.knowledge.identification.settled import Asked, settle_parameters
from gimbal_hil.knowledge.identification.stribeck import LUGRE_NAMES, LUGRE_UNITS, LugreFriction

#: relative step of the finite differences in search coordinates: far above the simulation's rounding, far below its
#: curvature
_DIFFERENCE_STEP = 1e-4
_SPREAD = 0.35
#: relative change of the sum of squares at which a fit, and a refit of a profile, is good enough: well below one
#: residual's worth
_TOLERANCE, _PROFILE_TOLERANCE = 1e-8, 1e-6
#: the simulation is of second order: steps of no length lie so many times as far away as steps of half the length
_TO_NO_STEP = 4.0 / 3.0
#: pieces between which friction may wander are at most so long, s
_PIECE_S = 2.0
EXPERIMENTS = {
    "breakaway": "slow torque ramps through break-away, or plateaus below the Stribeck velocity",
    "coulomb": "plateaus at three and more times the Stribeck velocity",
    "stribeck_velocity": "a reversing multisine with rates around the Stribeck velocity, or dense plateaus there",
    "viscous": "plateaus at ten and more times the Stribeck velocity",
    "shape": "dense plateaus around the Stribeck velocity",
    "sigma0": "slow torque ramps below break-away and back",
    "sigma1": "torque or rate pulses within presliding, sampled several times per period of sqrt(sigma0 / inertia)",
}


@dataclass(frozen=True)
class OutputErrorRule:
    """What is compared and how the search is spread.

    Motion is compared as displacement over `compare_s` seconds, so that neither an unknown zero nor slow drift counts.
    `starts` points are drawn log-uniformly within a factor exp(+-0.35) of the first; `substep_s` is the simulation
    step.
    """

    compare_s: float = 0.01
    starts: int = 4
    seed: int = 0
    substep_s: float = 5e-4
    #: into so many each of these steps is cut
    finer: int = 1


@dataclass(frozen=True)
class OutputErrorFit:
    """Estimates of the free parameters, the friction that results, and the fit behind it.

    `offset` is the constant torque error that was fitted along; `simulated` holds one position series per record; `rms`
    is the displacement error (rad) over `compare_s`; `sensitivities` (p,) is the rms displacement change in units of
    its error when the parameter changes by 1 %, in the order of `estimates`.
    """

    estimates: tuple[Estimate, ...]
    friction: LugreFriction
    offset: float
    records: tuple[AxisRecord, ...]
    simulated: tuple[Vector, ...]
    rms: float
    sensitivities: Vector
    agreeing_starts: int
    correlations: Correlations


@dataclass(frozen=True)
class _ResponseResiduals:
    """Displacement error over its standard error; `values` = the free parameters, then the torque offset."""

    records: tuple[AxisRecord, ...]
    inertia: float
    base: LugreFriction
    free: tuple[str, ...]
    rule: OutputErrorRule
    error: float

    def __call__(self, values: Vector) -> Vector:
        friction = self.base.with_values(self.free, values[: len(self.free)])
        pieces = []
        for record in self.records:
            position, _ = simulate_axis(
                record, self.inertia, friction, float(values[-1]), self.rule.substep_s, self.rule.finer
            )
            pieces.append(displacements(record.position - position, record.step_s, self.rule.compare_s))
        return np.concatenate(pieces) / self.error


def displacements(position: Vector, step_s: float, compare_s: float) -> Vector:
    """Changes of a position series, shape (n,), over consecutive stretches of `compare_s` seconds."""
    stride = max(1, int(round(compare_s / step_s)))
    return np.diff(position[::stride])


def fit_output_error(
    records: Sequence[AxisRecord],
    inertia: float,
    start: LugreFriction,
    free: tuple[str, ...],
    encoder_step: float,
    rule: OutputErrorRule | None = None,
) -> OutputErrorFit:
    """Fit the parameters named in `free` (of LUGRE_NAMES) to measured motion; the others stay at `start`, which is also
    the prior.

    A constant torque offset is always fitted along: an unmodelled trifle of unbalance must not become friction.
    Residual scatter sets the error (not below the encoder's); intervals are profile likelihood, widened per parameter
    by the ratio of its variance to the naive one, autocorrelation-robust or between pieces of the data, whichever is
    larger. Estimates are those of a simulation without steps; intervals hold what they hold with steps too.
    """
    rules = rule or OutputErrorRule()
    floor = max(encoder_step / np.sqrt(6.0), 1e-12)
    level = max(float(np.max(np.abs(record.torque))) for record in records)
    parameters = (*_parameters(start, free), Unknown("offset", -0.5 * level, 0.5 * level, logarithmic=False))
    residuals = _ResponseResiduals(tuple(records), inertia, start, free, rules, floor)
    centre = np.array([start.values()[LUGRE_NAMES.index(name)] for name in free] + [0.0])
    best = fit(residuals, parameters, _starts(centre, rules), _DIFFERENCE_STEP, _TOLERANCE)
    scatter = floor * max(1.0, float(np.sqrt(best.sum_of_squares / best.degrees_of_freedom)))
    residuals = _ResponseResiduals(tuple(records), inertia, start, free, rules, scatter)
    agreeing = best.agreeing_starts
    best = fit(residuals, parameters, [best.values], _DIFFERENCE_STEP, _TOLERANCE)
    lengths = [len(displacements(record.position, record.step_s, rules.compare_s)) for record in records]
    piece = pieces(lengths, len(parameters), round(_PIECE_S / rules.compare_s))
    ratio = np.maximum(robust_variance_ratio(best), between_pieces_ratio(best, piece))
    task = ProfileTask(residuals, parameters, best, ratio, _DIFFERENCE_STEP, _PROFILE_TOLERANCE)
    asked = [
        Asked(name, LUGRE_UNITS[LUGRE_NAMES.index(name)], float(centre[i]), EXPERIMENTS[name])
        for i, name in enumerate(free)
    ]
    sensitivity = np.sqrt(np.mean(best.jacobian[:, : len(free)] ** 2, axis=0)) * 0.01
    correlations = of_fit(parameters, best)
    estimates, best = settle_parameters(task, asked, _bias_of_steps(residuals, parameters, best))
    friction = start.with_values(free, best.values[:-1])
    offset = float(best.values[-1])
    simulated = tuple(simulate_axis(record, inertia, friction, offset, rules.substep_s)[0] for record in records)
    rms = float(np.sqrt(np.mean(best.residuals**2)) * scatter)
    return OutputErrorFit(
        estimates, friction, offset, tuple(records), simulated, rms, sensitivity, agreeing, correlations
    )


def _bias_of_steps(residuals: _ResponseResiduals, parameters: Sequence[Unknown], best: LeastSquaresFit) -> Vector:
    """How far the best fit lies from that of a simulation without steps, (p,): from what half its steps change, to
    first order.
    """
    finer = replace(residuals, rule=replace(residuals.rule, finer=2 * residuals.rule.finer))
    change = finer(best.values) - residuals(best.values)
    away = np.linalg.lstsq(best.jacobian, -_TO_NO_STEP * change, rcond=1e-10)[0]
    ends = [(p.coordinate(p.low), p.coordinate(p.high)) for p in parameters]
    there = [min(max(x, low), high) for x, (low, high) in zip(best.coordinates + away, ends, strict=True)]
    return best.values - np.array([p.value(float(x)) for p, x in zip(parameters, there, strict=True)])


def _parameters(start: LugreFriction, free: tuple[str, ...]) -> tuple[Unknown, ...]:
    """Two decades around the start, the shape within what the Stribeck curve can mean."""
    parameters = []
    for name in free:
        value = float(start.values()[LUGRE_NAMES.index(name)])
        low, high = (0.3, 6.0) if name == "shape" else (value / 30.0, value * 30.0)
        parameters.append(Unknown(name, low, high))
    return tuple(parameters)


def _starts(centre: Vector, rule: OutputErrorRule) -> list[Vector]:
    generator = np.random.default_rng(rule.seed)
    starts = [centre]
    for _ in range(rule.starts - 1):
        factors = np.exp(generator.uniform(-_SPREAD, _SPREAD, len(centre)))
        starts.append(np.where(centre == 0.0, 0.0, centre * factors))
    return starts
