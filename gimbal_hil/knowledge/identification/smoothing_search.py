"""Whether the columns of a log were smoothed before they were saved, from what the regression of an axis leaves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.estimation import ShiftedFit, ShiftedProblem, Smoothing, SmoothingShape, fit_at, fit_shifted
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.axis_motion import AxisMotion
from gimbal_hil.knowledge.identification.position_ripple import OverPosition
from gimbal_hil.knowledge.identification.smoothed_log import SmoothedColumn, SmoothedLog

Ripples = tuple[OverPosition, ...]

#: a smoothing counts where at most this share of the squares is left, whatever the choice of band and rows: a friction
#: that the regression does not know leaves a little less behind any filter
_LEFT = 0.5
#: smoothings that leave at most so many times what the best one does are possible too
_POSSIBLE = 5.0
#: cut-offs that are tried first, as shares of the band; a cut-off settles in so many rounds
_CUT_OFFS, _ROUNDS = tuple(np.geomspace(0.1, 1.2, 6).tolist()), 5
#: where a smoothing leaves this share, what is left besides may be waves over position, which were smoothed too
_PERHAPS = 0.95
#: share of a cut-off over which its slope is taken, and the most that it moves by in a round
_SLOPE, _FARTHEST = 1e-3, 0.3
#: rows that say enough for the search, of a rate that the band allows
_ENOUGH_ROWS = 5_000
_FIRST = (SmoothingShape.ONE_POLE, SmoothingShape.TWO_POLES, SmoothingShape.MEAN)


def smoothings_of(
    motion: AxisMotion, plain: list[ShiftedFit], ripples: Ripples, ripples_of: Callable[[SmoothedLog], Ripples]
) -> tuple[SmoothedLog, ...]:
    """Smoothings that explain a log clearly better than none, the best first; `plain` are the fits of its problems
    without one, `ripples_of` says which waves over position there are beside one.
    """
    plainly = _search(motion.middle(_ENOUGH_ROWS), plain, ripples)
    part, late = plainly.motion, plainly.late_s
    base = plainly.base

    found: list[tuple[float, SmoothedLog]] = []
    beside: dict[SmoothedColumn, Ripples] = {}
    for which in SmoothedColumn:
        beside[which], search = ripples, plainly
        least, near = search.coarse(which)
        if least < _PERHAPS * base and not ripples and (waves := ripples_of(near)):
            beside[which] = waves
            search = _Search(part, next(part.problems(waves))[0], waves, late)
            least, near = search.coarse(which)
        if least <= _LEFT * min(base, search.behind(near)):
            found += [search.settled(search.nearest(which, shape)) for shape in SmoothingShape]
    found.sort(key=lambda pair: pair[0])
    found = [(left, one) for left, one in found if left <= _LEFT * min(base, plainly.behind(one))]
    possible = [one for left, one in found if left <= _POSSIBLE * found[0][0]]
    return tuple(one for one in possible if _whatever_the_choice(motion, one, plain, beside[one.which]))


def guesses_of(
    motion: AxisMotion, plain: list[ShiftedFit], ripples: Ripples, columns: Iterable[SmoothedColumn]
) -> tuple[SmoothedLog, ...]:
    """The best of a few cut-offs of every shape for each of these columns, whether it explains anything or not."""
    search = _search(motion.middle(_ENOUGH_ROWS), plain, ripples)
    return tuple(search.nearest(*pair) for pair in product(columns, SmoothingShape))


def settled_over(motion: AxisMotion, plain: list[ShiftedFit], ripples: Ripples, one: SmoothedLog) -> SmoothedLog:
    """The smoothing with the cut-off that leaves least of all rows of a log."""
    return _over_all(motion, plain, ripples).settled(one)[1]


def share_left(motion: AxisMotion, plain: list[ShiftedFit], ripples: Ripples, one: SmoothedLog) -> float:
    """Share of the squares over all rows of a log that a smoothing leaves, of those that are left without any."""
    search = _over_all(motion, plain, ripples)
    return search.left(one) / search.base


def _over_all(motion: AxisMotion, plain: list[ShiftedFit], ripples: Ripples) -> _Search:
    """All rows, at a rate that the band of the fit allows."""
    return _search(motion.middle(len(motion.time_s)), plain, ripples)


def _search(motion: AxisMotion, plain: list[ShiftedFit], ripples: Ripples) -> _Search:
    late = 0.0 if motion.rule.time_stated else plain[0].shift_s
    return _Search(motion, next(motion.problems(ripples))[0], ripples, late)


@dataclass(frozen=True)
class _Search:
    """Part of a log, its first problem as if it was not smoothed, waves over position, and how late its torque is."""

    motion: AxisMotion
    sharp: ShiftedProblem
    ripples: Ripples
    late_s: float

    @property
    def base(self) -> float:
        """Mean square that is left of the torque without any smoothing; next to nothing where the rows are so few."""
        left = _left(fit_at(self.sharp, self.late_s), self.motion.rule.bandwidth_hz * self.sharp.step_s)
        return max(left, 1e-300) if np.isfinite(left) else 1e-300

    def behind(self, one: SmoothedLog) -> float:
        """The same with both sides behind a smoothing: what any filter takes of the position's noise is no sign of it,
        and where it takes no more, columns that were not smoothed explain the log as well.
        """
        if one.which is SmoothedColumn.POSITION:
            return self.base
        sharp = self.sharp
        sides = (one.smoothing.of(values, sharp.step_s) for values in (sharp.target, sharp.known, sharp.columns))
        target, known, columns = sides
        problem = replace(sharp, target=target, known=known, columns=columns, rows=self._inside(one))
        return _left(
            fit_at(problem, self.late_s), min(self.motion.rule.bandwidth_hz, one.smoothing.half_hz) * sharp.step_s
        )

    def coarse(self, which: SmoothedColumn) -> tuple[float, SmoothedLog]:
        """The best of a few smoothings of some column, and what it leaves."""
        band = self.motion.rule.bandwidth_hz
        few = (SmoothedLog(which, Smoothing(*pair)) for pair in product(_FIRST, (band * x for x in _CUT_OFFS)))
        return min(((self.left(one), one) for one in few), key=lambda pair: pair[0])

    def nearest(self, which: SmoothedColumn, shape: SmoothingShape) -> SmoothedLog:
        """The best of a few cut-offs of one shape: a gentle filter and a steep one look alike at different ones."""
        band = self.motion.rule.bandwidth_hz
        few = (SmoothedLog(which, Smoothing(shape, band * share)) for share in _CUT_OFFS)
        return min(few, key=self.left)

    def settled(self, one: SmoothedLog) -> tuple[float, SmoothedLog]:
        """The cut-off near one that leaves least, and what it leaves."""
        left = self.left(one)
        for _ in range(_ROUNDS):
            problem = next(smoothed_problems(self.motion, one, self.ripples, self.late_s))[0]
            further = float(np.clip(fit_at(problem, self.late_s).solution[-1], -_FARTHEST, _FARTHEST))
            other = one.times(float(np.exp(further)))
            if (now := self.left(other)) >= left:
                break
            left, one = now, other
        return left, one

    def left(self, one: SmoothedLog) -> float:
        """Mean square that is left of the torque."""
        band = self.motion.rule.bandwidth_hz
        hz = band if one.which is SmoothedColumn.POSITION else min(band, one.smoothing.half_hz)
        return _left(fit_at(self._problem(one), self.late_s), hz * self.sharp.step_s)

    def _problem(self, one: SmoothedLog) -> ShiftedProblem:
        sharp = self.sharp
        if one.which is not SmoothedColumn.TORQUE:
            return next(self.motion.problems(self.ripples, one))[0]
        # filters that are the same over time may come in any order
        columns, known = (one.as_torque(values, sharp.step_s) for values in (sharp.columns, sharp.known))
        return replace(sharp, columns=columns, known=known, rows=self._inside(one))

    def _inside(self, one: SmoothedLog) -> NDArray[np.int64]:
        """Rows that count and are far enough from both ends for a smoothing."""
        rows, margin = self.sharp.rows, int(1.0 / one.smoothing.half_hz / self.sharp.step_s)
        return rows[(rows >= margin) & (rows < len(self.sharp.target) - margin)]


def smoothed_problems(
    motion: AxisMotion, one: SmoothedLog, ripples: Ripples, near_s: float
) -> Iterator[tuple[ShiftedProblem, Vector]]:
    """The regression at each choice of band and slowest rows, as of a log that was smoothed so, with what another
    cut-off does as a last column: it is an unknown too.
    """
    for (problem, rate), (moved, _) in zip(
        motion.problems(ripples, one), motion.problems(ripples, one.times(1.0 + _SLOPE)), strict=False
    ):
        solution = fit_shifted(problem, near_s=near_s).solution
        change = (moved.columns - problem.columns) @ solution - (moved.known - problem.known)
        columns = np.column_stack([problem.columns, change / _SLOPE])
        yield replace(problem, columns=columns), rate


def _whatever_the_choice(motion: AxisMotion, one: SmoothedLog, plain: list[ShiftedFit], ripples: Ripples) -> bool:
    near = plain[0].shift_s
    return all(
        _mean_square(fit_shifted(problem, near_s=near)) <= _LEFT * _mean_square(fit)
        for (problem, _), fit in zip(motion.problems(ripples, one), plain, strict=False)
    )


def _left(fit: ShiftedFit, band: float) -> float:
    """Mean square a degree of freedom, of which rows have two a period of what a filter lets through (`band`, its end
    times the time between rows): a slow filter on a short log leaves fewer than there are numbers, and explains
    nothing.
    """
    independent = min(1.0, 2.0 * band) * len(fit.residual)
    freedom = independent - len(fit.solution)
    return fit.cost / len(fit.residual) * independent / freedom if freedom > 0.0 else np.inf


def _mean_square(fit: ShiftedFit) -> float:
    return fit.cost / max(1, len(fit.residual))
