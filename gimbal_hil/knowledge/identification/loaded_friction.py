"""Friction that grows with the torque that position takes, as a gear under a weight has: no part of a Coulomb level."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.estimation import ShiftedFit, fit_shifted
from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.axis_motion import AxisMotion
from gimbal_hil.knowledge.identification.estimate import DataWarning, Interval, number_text
from gimbal_hil.knowledge.identification.log_parts import block_bootstrap
from gimbal_hil.knowledge.identification.over_position import moved_over
from gimbal_hil.knowledge.identification.position_ripple import OverPosition, PositionSlope

#: friction under load that is less than this share of the Coulomb level is no news
_NEWS = 0.05
#: rounds in which the load and the friction under it settle beside each other
_ROUNDS = 2


@dataclass(frozen=True)
class LoadedFriction:
    """The share of the load that its friction is, with its interval, and the motion beside which it was found."""

    share: float
    interval: Interval
    motion: AxisMotion
    over: tuple[OverPosition, ...]
    #: it is a part of the friction that a reader would miss
    is_news: bool

    @property
    def finding(self) -> DataWarning:
        """What a reader must know of it."""
        low, high = (number_text(end, 3) for end in (self.interval.low, self.interval.high))
        text = (
            f"friction grows with the torque that position takes (a weight, a spring), by {number_text(self.share, 3)} "
            f"({low} to {high}) of it: the numbers were fitted beside it, and coulomb is what is left without a load; "
            "what the model lacks there, gimbal-hil discrepancy says"
        )
        return DataWarning("friction_under_load", text)


def loaded_friction(
    motion: AxisMotion, over: tuple[OverPosition, ...], numbers: int, seed: int
) -> LoadedFriction | None:
    """Friction under load beside the first regression, of so many numbers, and what is `over` position; None where
    position takes nothing, or the interval of the share reaches no load's friction or all of the load.
    """
    found = None
    if not np.any(motion.known) and not any(isinstance(one, PositionSlope) for one in over):
        return None
    fit = fit_shifted(next(motion.problems(over))[0])
    for _ in range(_ROUNDS):
        load = _load(motion, over, fit)
        motion = replace(motion, load=load)
        fit = fit_shifted(next(motion.problems(over))[0])
        over = moved_over(over, fit.solution[numbers:])
        share = float(fit.solution[-1])
        replicates, _ = block_bootstrap(fit.design, fit.target, fit.residual, seed)
        low, high = np.percentile(replicates[:, len(fit.solution) - 1], [2.5, 97.5])
        if not 0.0 < low <= high < 1.0:
            return None
        is_news = share * float(np.mean(np.abs(load))) > _NEWS * abs(_coulomb(fit, motion.rule.per_direction))
        interval = Interval(min(share, float(low)), max(share, float(high)))
        found = LoadedFriction(share, interval, motion, over, is_news)
    return found


def _load(motion: AxisMotion, over: tuple[OverPosition, ...], fit: ShiftedFit) -> Vector:
    """What position takes of the torque, (n,): what was known before, and slopes over position with the offset, of
    which nobody knows how much belongs to them.
    """
    slopes = [one for one in over if isinstance(one, PositionSlope)]
    load = -motion.known
    for one in slopes:
        load = load + np.column_stack(one.columns(motion.position)) @ np.array(one.sizes)
    return load + _offset(fit, motion.rule.per_direction) if slopes else load


def _offset(fit: ShiftedFit, per_direction: bool) -> float:
    """The torque that is the same both ways: a number, or half the difference of two Coulomb levels."""
    return float(0.5 * (fit.solution[3] - fit.solution[4]) if per_direction else fit.solution[3])


def _coulomb(fit: ShiftedFit, per_direction: bool) -> float:
    """The Coulomb level, or the mean of those of both directions."""
    return float(0.5 * (fit.solution[3] + fit.solution[4]) if per_direction else fit.solution[2])


__all__ = ["LoadedFriction", "loaded_friction"]
