"""What of a torque depends on position alone, beside inertia and friction: no number may hold a part of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimbal_hil.knowledge.estimation import fit_shifted
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.axis_motion import AxisMotion
from gimbal_hil.knowledge.identification.estimate import Determination, Estimate
from gimbal_hil.knowledge.identification.position_ripple import OverPosition, PositionSlope, ripples_of, slopes_over
from gimbal_hil.knowledge.identification.smoothed_log import SmoothedLog

#: a slope over position counts where it leaves at most this share of the squares: what it means for friction and
#: inertia is too much to be guessed from less
_SLOPE_LEAVES = 0.5
#: rounds in which waves over position, found beside a first fit, settle beside the numbers
_ROUNDS = 3


def over_position(motion: AxisMotion, numbers: int, smoothed: SmoothedLog | None = None) -> tuple[OverPosition, ...]:
    """What the torque has over position beside the first regression, of so many numbers: waves as fast as the filters
    let through, and a slope where that leaves clearly less; none where the filters leave no row of a short log.
    """
    problem, rate = next(motion.problems((), smoothed))
    position = motion.position[problem.rows]
    if not len(position):
        return ()
    plain = fit_shifted(problem)
    usual_rate = float(np.median(np.abs(rate[problem.rows])))
    fastest = 2.0 * np.pi * motion.rule.bandwidth_hz / max(usual_rate, 1e-12)
    beside = [
        (fit_shifted(next(motion.problems((slope,), smoothed))[0]), slope)
        for slope in slopes_over(position, motion.rule.linear)
    ]
    best = min(beside, key=lambda pair: pair[0].cost, default=None)
    left, slopes = (plain, ()) if best is None or best[0].cost > _SLOPE_LEAVES * plain.cost else (best[0], best[1:])
    over: tuple[OverPosition, ...] = (*slopes, *ripples_of(left.residual, position, fastest))
    for _ in range(_ROUNDS if over else 0):
        solution = fit_shifted(next(motion.problems(over, smoothed))[0]).solution
        over = moved_over(over, solution[numbers:])
    return over


def moved_over(over: tuple[OverPosition, ...], solution: Vector) -> tuple[OverPosition, ...]:
    """What is over position, where a fit of its columns leads, three each; what follows them is of something else."""
    return tuple(one.moved(own) for one, own in zip(over, solution[: 3 * len(over)].reshape(-1, 3), strict=True))


def beside_slope(offset: Estimate, over: tuple[OverPosition, ...]) -> Estimate:
    """An offset beside a torque that follows position: where that is nothing, nobody said."""
    if not any(isinstance(one, PositionSlope) for one in over):
        return offset
    reason = "it cannot be told from the torque that follows position"
    return replace(offset, verdict=Determination.NOT_IDENTIFIED, reason=reason)
