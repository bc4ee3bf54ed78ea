"""Inertia, viscous and Coulomb friction and offset of one axis, by linear regression on filtered motion.

When torque and position were logged at different times, inertia passes for friction: the shift between them is an
unknown like the others. And no number may depend on a choice that nobody made: each interval holds those of the fit at
half the band, without slow rows, with a low-pass in place of a shift, and of parts of the log that disagree.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.estimation import ShiftedFit, ShiftedProblem, fit_at, fit_shifted
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.axis_motion import AxisMotion, RigidAxisRule
from gimbal_hil.knowledge.identification.correlations import Correlations, of_replicates
from gimbal_hil.knowledge.identification.creep_friction import creep_friction
from gimbal_hil.knowledge.identification.estimate import (
    DataWarning,
    Determination,
    Estimate,
    Interval,
    judge,
    settle,
    withheld,
)
from gimbal_hil.knowledge.identification.least_squares import Matrix
from gimbal_hil.knowledge.identification.loaded_friction import loaded_friction
from gimbal_hil.knowledge.identification.log_parts import DEPENDENT, FEWEST_ROWS, LogParts, block_bootstrap, parts_apart
from gimbal_hil.knowledge.identification.other_columns import (
    fits_of,
    lagged_position,
    refreshed_problems,
    two_clocks,
)
from gimbal_hil.knowledge.identification.over_position import beside_slope, over_position
from gimbal_hil.knowledge.identification.position_ripple import OverPosition
from gimbal_hil.knowledge.identification.smoothed_log import SmoothedColumn, SmoothedLog
from gimbal_hil.knowledge.identification.smoothing_search import (
    guesses_of,
    settled_over,
    share_left,
    smoothed_problems,
    smoothings_of,
)
from gimbal_hil.knowledge.identification.timing import STATE_IT, Timing
from gimbal_hil.knowledge.identification.torque_column import other_torques, with_room

#: a low-pass is seen where at most this share is left of what a shift alone leaves: less may be the noise of the
#: encoder, which a lag smooths too
_CLEARLY_LESS = 0.8
#: a column takes part in a combination that is nothing above this share
_TAKES_PART = 1e-2
#: what a regression leaves beyond this share of the torque's rms is no matter of friction
_UNEXPLAINED = 0.5
_NAMES = {
    False: ("inertia", "viscous", "coulomb", "offset"),
    # a common offset cannot be told from a difference between the two Coulomb levels: it is carried by them
    True: ("inertia", "viscous_positive", "viscous_negative", "coulomb_positive", "coulomb_negative"),
}
_EXPERIMENTS = {
    "inertia": "a trajectory with strong accelerations in both directions",
    "viscous": "plateaus at several speeds, both directions",
    "coulomb": "slow constant speeds, both directions",
    "offset": "equal travel in both directions at equal speeds",
}


@dataclass(frozen=True)
class RigidAxisFit:
    """Estimates by name, rms of the torque residual, the same relative to the rms torque, and the rows behind them.
    `ripples` are waves over position that were counted apart, `smoothed` what was done to the columns before, if
    anything; first what explains them best, then what would do too. `parts` are two of the log that ask for different
    inertias, if any do.

    `rate`, `torque`, `residual`, shape (n,), are at the decimated rows.
    """

    estimates: tuple[Estimate, ...]
    rms: float
    relative: float
    rate: Vector
    torque: Vector
    residual: Vector
    blocks: int
    timing: Timing
    correlations: Correlations
    ripples: tuple[OverPosition, ...] = ()
    smoothed: tuple[SmoothedLog, ...] = ()
    parts: LogParts | None = None
    warnings: tuple[DataWarning, ...] = ()

    def value(self, name: str) -> float:
        """Fitted value by name."""
        return next(estimate.fitted for estimate in self.estimates if estimate.name == name)

    def unexplained(self, axis: str) -> tuple[DataWarning, ...]:
        """What a reader must know where the motion asks for another torque than the log has."""
        if self.relative <= _UNEXPLAINED:
            return ()
        text = (
            f"inertia, friction and offset leave {100.0 * self.relative:.0f} % of the torque unexplained (rms): torque "
            "and position may not belong together, or something else moves the joint (a spring, a weight, a stop)"
        )
        return (DataWarning("unexplained", text, axis),)


@dataclass(frozen=True)
class _Replicates:
    """One fit and its bootstrap: numbers (repeats, k), how late (repeats,), and the blocks."""

    fit: ShiftedFit
    numbers: Matrix
    late_s: Vector
    blocks: int

    def interval(self, values: Vector) -> Interval:
        low, high = np.percentile(values, [2.5, 97.5])
        return Interval(float(low), float(high))

    @property
    def late(self) -> Interval:
        return self.interval(self.late_s)


def fit_rigid_axis(
    time_s: Vector,
    position: Vector,
    torque: Vector,
    rule: RigidAxisRule,
    seed: int = 0,
    known: Vector | None = None,
    smoothed: tuple[SmoothedLog, ...] | None = None,
) -> RigidAxisFit:
    """Regress `torque + known = inertia a + viscous v + coulomb sign(v) + offset`, or with viscous and Coulomb friction
    per direction.

    `time_s`, `position`, `torque` (commanded, held over the sample), `known` (sampled, from the positions), shape (n,),
    constant rate. The least-squares solution uses every sample behind the filters, at the shift of torque that leaves
    least where the data exclude that there is none; intervals are percentiles of a block bootstrap (blocks of at least
    five decorrelation times of the residual), with the shift free, because filtered residuals are neither white nor
    equal in size along the trajectory. `smoothed` is what is known to have been done to the columns; None looks for it.

    Raises:
        BadInputError: the table is shorter than the filters need or the joint does not move.
    """
    logged = as_logged(time_s, position, torque, rule, known, seed)
    motion, names, ripples, problems, fits = logged.motion, logged.names, logged.ripples, logged.problems, logged.fits
    step = motion.step_s
    likely, warnings = logged.smoothings() if smoothed is None else smoothed, logged.warnings
    if not likely:
        further = [pair for one in logged.others for pair in one.problems(ripples)]
        further += [] if rule.time_stated else refreshed_problems(motion, ripples)
        problems, fits = [*problems, *further], [*fits, *fits_of(further, fits[0])]
    else:
        ripples, late = over_position(motion, len(names), likely[0]), fits[0].shift_s
        problems = [pair for one in likely for pair in smoothed_problems(motion, one, ripples, late)]
        fits = [fit_shifted(problem, near_s=late) for problem, _ in problems]
    rate = problems[0][1]
    parts = parts_apart(problems[0][0], fits[0], position, seed)
    if parts is not None:
        own = fits[0]
        problems += [(problem, rate) for problem in parts.problems]
        fits += [fit_at(problem, own.shift_s, own.lag_s, 1 + (own.lag_s > 0.0)) for problem in parts.problems]
    shifted = [_replicates(fit, seed) for fit in fits]
    ends = [] if rule.time_stated else _ends(problems[0][0], fits[0], seed)
    warnings += two_clocks([one.late for one in ends])
    shifted += ends
    timing = replace(_timing(shifted, step, rule.time_stated), sought_s=problems[0][0].most_s)
    if timing.used and timing.late.low > 0.0:
        shifted += [_replicates(fit, seed) for fit in _perhaps_lagged(problems[0][0], fits[0])]
    elif timing.used and not likely:
        shifted += [_replicates(fit, seed) for fit in lagged_position(motion, ripples, fits[0])]
    plain = problems[0][0]
    fit = (
        fit_at(plain, timing.late_s - timing.lag_s, timing.lag_s, 1 + (timing.lag_s > 0.0))
        if timing.used
        else fit_at(plain)
    )
    as_stated = [_replicates(fit_at(problem), seed) for problem, _ in problems]
    estimates = _estimates(names, fit, shifted, as_stated, timing, rule.linear)
    rms = float(np.sqrt(np.mean(fit.residual**2)))
    relative = rms / float(np.sqrt(np.mean(fit.target**2)))
    estimates = _doubted(estimates, replace(logged, ripples=ripples), relative)
    rows = plain.rows
    first = (as_stated if rule.time_stated else shifted)[0]
    correlations = of_replicates(names, first.numbers[:, : len(names)], fit.solution[: len(names)])
    return RigidAxisFit(
        estimates,
        rms,
        relative,
        rate[rows],
        fit.target,
        fit.residual,
        shifted[0].blocks,
        timing,
        correlations,
        ripples,
        likely,
        parts,
        warnings,
    )


@dataclass(frozen=True)
class AsLogged:
    """The regression of an axis as if nobody had smoothed its columns: waves over position, problems beside them with
    the rate (n,) of all rows, and their fits.
    """

    motion: AxisMotion
    names: tuple[str, ...]
    ripples: tuple[OverPosition, ...]
    problems: list[tuple[ShiftedProblem, Vector]]
    fits: list[ShiftedFit]
    #: the motion with a torque that may as well have been logged otherwise, and what is to be known of this one
    others: tuple[AxisMotion, ...] = ()
    warnings: tuple[DataWarning, ...] = ()
    #: the torque (n,) as its column has it, and whether something took a part of it away for good
    column: Vector = field(default_factory=lambda: np.zeros(0))
    is_part: bool = False

    def smoothings(self) -> tuple[SmoothedLog, ...]:
        """What somebody did to the columns before they were saved, the likeliest first."""
        return smoothings_of(self.motion, self.fits, self.ripples, self._beside)

    def guesses(self, columns: Iterable[SmoothedColumn]) -> tuple[SmoothedLog, ...]:
        """A smoothing of each shape for each of these columns, whether it explains anything or not."""
        return guesses_of(self.motion, self.fits, self.ripples, columns)

    def settled(self, one: SmoothedLog) -> SmoothedLog:
        """The smoothing with the cut-off that this log likes best."""
        return settled_over(self.motion, self.fits, self.ripples, one)

    def _beside(self, one: SmoothedLog) -> tuple[OverPosition, ...]:
        return over_position(self.motion, len(self.names), one)

    def left_by(self, one: SmoothedLog) -> float:
        """Share of the squares that are left where the columns are taken to be smoothed so."""
        return share_left(self.motion, self.fits, self.ripples, one)


def as_logged(
    time_s: Vector,
    position: Vector,
    torque: Vector,
    rule: RigidAxisRule,
    known: Vector | None = None,
    seed: int = 0,
) -> AsLogged:
    """The regression before anything is said of its columns; arguments and error as those of `fit_rigid_axis`."""
    step = float(np.median(np.diff(time_s)))
    edge = int(round(rule.edge_periods / rule.bandwidth_hz / step))
    if len(time_s) < 4 * edge + 200 or not np.ptp(position) > 0.0:
        raise BadInputError(
            "signals table",
            "too short or without motion for a regression",
            f"at least {4 * edge + 200} rows of a moving axis",
        )
    load = np.zeros(len(torque)) if known is None else known
    motion, names = AxisMotion(time_s, position, torque, load, rule), _NAMES[rule.per_direction]
    ripples = over_position(motion, len(names))
    others = other_torques(motion, ripples)
    is_part = any(one.took_much for one in others)
    warnings = tuple({one.finding.rule: one.finding for one in others if one.is_told}.values())
    if others and others[0].is_certain:
        motion, others = others[0].motion, others[1:]
        ripples = over_position(motion, len(names))
    loaded = loaded_friction(motion, ripples, len(names), seed)
    if loaded is not None:
        motion, ripples = loaded.motion, loaded.over
        warnings = (*warnings, loaded.finding) if loaded.is_news else warnings
        others = [replace(one, motion=replace(one.motion, load=motion.load)) for one in others]
    creep = creep_friction(motion, ripples, seed)
    perhaps = [one.motion for one in others]
    if creep is not None:
        perhaps, warnings = [*perhaps, *creep.motions], (*warnings, *creep.findings)
    problems = list(motion.problems(ripples))
    fits = _shifted([problem for problem, _ in problems])
    return AsLogged(
        motion,
        names,
        ripples,
        problems,
        fits,
        tuple(perhaps),
        warnings,
        torque,
        is_part,
    )


def _shifted(problems: list[ShiftedProblem]) -> list[ShiftedFit]:
    """The fits with a shift, one a choice; with a low-pass too where that leaves clearly less whatever the choice."""
    first = fit_shifted(problems[0])
    alone = [first, *(fit_shifted(problem, near_s=first.shift_s) for problem in problems[1:])]
    lagged = []
    for problem, other in zip(reversed(problems), reversed(alone), strict=True):
        one = fit_shifted(problem, True, max(0.0, first.shift_s))
        if one.cost > _CLEARLY_LESS * other.cost:
            return alone
        lagged.append(one)
    return lagged[::-1]


def _ends(problem: ShiftedProblem, fit: ShiftedFit, seed: int) -> list[_Replicates]:
    """The fits of the first and the last third of a log, where the torque of one is late by another time than that of
    the other; else none.
    """
    third = len(problem.rows) // 3
    if third < FEWEST_ROWS:
        return []
    parts = (replace(problem, rows=rows) for rows in (problem.rows[:third], problem.rows[-third:]))
    first, last = (_replicates(fit_shifted(part, near_s=fit.shift_s), seed) for part in parts)
    far = abs(first.fit.shift_s - last.fit.shift_s) > problem.step_s
    return [first, last] if far and not first.late.overlaps(last.late) else []


def _perhaps_lagged(problem: ShiftedProblem, late: ShiftedFit) -> tuple[ShiftedFit, ...]:
    """The fit of a late torque in which a lag makes it late, where it leaves no more: a torque that is refreshed
    slowly, or comes through a fast low-pass, is late and a little too small as well. Where all of it is a shift the
    cost has a hollow, so that it is sought from none of it too.
    """
    if late.lag_s > 0.0 or late.shift_s <= 0.0:
        return ()
    lagged = min((fit_shifted(problem, True, near) for near in (late.shift_s, 0.0)), key=lambda one: one.cost)
    return (lagged,) if lagged.lag_s > 0.0 and lagged.cost <= late.cost else ()


def _timing(shifted: list[_Replicates], step: float, stated: bool) -> Timing:
    """The shift between torque and motion, with an interval that holds whatever a choice makes of it."""
    late = Interval(min(one.late.low for one in shifted), max(one.late.high for one in shifted))
    fit = shifted[0].fit
    used = not stated and not late.covers(0.0)
    return Timing(fit.shift_s + fit.lag_s, late, fit.lag_s, step, used, stated)


def _estimates(
    names: tuple[str, ...],
    fit: ShiftedFit,
    shifted: list[_Replicates],
    as_stated: list[_Replicates],
    timing: Timing,
    linear: bool,
) -> tuple[Estimate, ...]:
    design = fit.design[:, : len(names)]
    open_ones = _undetermined(design / np.maximum(np.linalg.norm(design, axis=0), 1e-300))
    estimates = []
    for index, name in enumerate(names):
        family, value = name.split("_")[0], float(fit.solution[index])
        unit, experiment = _unit(family, linear), _EXPERIMENTS[family]
        if index in open_ones:
            partners = ", ".join(n for i, n in enumerate(names) if i in open_ones and i != index)
            reason = (
                f"in this motion it cannot be told from {partners}" if partners else "this motion does not depend on it"
            )
            estimates.append(withheld(name, unit, None, reason, experiment))
            continue
        with_time, without = (_over(some, index, value) for some in (shifted, as_stated))
        interval = without if timing.stated else with_time
        estimate = settle(name, value, interval, unit, None, experiment)
        if not timing.stated and estimate.verdict is not judge(without, value):
            reason = f"in this motion it cannot be told from a shift of torque against position; state it: {STATE_IT}"
            estimate = replace(estimate, reason=reason)
        estimates.append(estimate)
    return tuple(estimates)


def _doubted(estimates: tuple[Estimate, ...], logged: AsLogged, relative: float) -> tuple[Estimate, ...]:
    """The estimates as far as a log allows them, of which this share of the torque is left."""
    estimates = tuple(
        beside_slope(with_room(one, logged.column), logged.ripples) if one.name == "offset" else one
        for one in estimates
    )
    if relative > _UNEXPLAINED:
        reason = "most of the torque in this log is of something else, and a part of that may be in this number"
    elif logged.is_part:
        reason = "a part of the torque is not in the column any more, and this number lacks it"
    else:
        return estimates
    return tuple(replace(one, verdict=Determination.NOT_IDENTIFIED, reason=reason) for one in estimates)


def _over(fits: list[_Replicates], index: int, value: float) -> Interval:
    """The interval of one number over all fits, the value in it."""
    intervals = [one.interval(one.numbers[:, index]) for one in fits]
    ends = [end for one in intervals for end in (one.low, one.high)]
    return Interval(value, value).stretched_over(ends)


def _replicates(fit: ShiftedFit, seed: int) -> _Replicates:
    numbers, blocks = block_bootstrap(fit.design, fit.target, fit.residual, seed)
    k = len(fit.solution)
    # a target made to fit with a longer lag or a later shift is later by their sum
    late = fit.shift_s + fit.lag_s + numbers[:, k:].sum(axis=1)
    return _Replicates(fit, numbers[:, :k], late, blocks)


def _undetermined(scaled: Matrix) -> set[int]:
    """Indices of the columns, all of length 1 or zero, that take part in a combination which leaves nothing."""
    _, singular, vt = np.linalg.svd(scaled, full_matrices=False)
    nothing = vt[singular <= DEPENDENT * singular[0]]
    return set(np.flatnonzero(np.any(np.abs(nothing) > _TAKES_PART, axis=0)).tolist())


def _unit(family: str, linear: bool) -> str:
    rotary = {"inertia": "kg m2", "viscous": "N m s/rad", "coulomb": "N m", "offset": "N m"}
    straight = {"inertia": "kg", "viscous": "N s/m", "coulomb": "N", "offset": "N"}
    return (straight if linear else rotary)[family]
