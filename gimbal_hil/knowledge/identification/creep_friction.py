"""Friction that falls off with speed, as Stribeck's bump does, or sets in with it: what it does to other numbers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import compress

import numpy as np

from gimbal_hil.knowledge.estimation import fit_shifted
from gimbal_hil.knowledge.identification.axis_motion import AxisMotion
from gimbal_hil.knowledge.identification.estimate import DataWarning, Interval, number_text
from gimbal_hil.knowledge.identification.log_parts import block_bootstrap
from gimbal_hil.knowledge.identification.position_ripple import OverPosition

#: speeds at which it may have fallen to 37 %, shares of the rms of the rate: below them hardly a row is left, and
#: above them it is a straight line where most rows are, as viscous friction is
_SPEEDS = (0.03, 0.042, 0.06, 0.085, 0.12, 0.17, 0.25)
#: share of the rows that must be as slow as that or slower: what no row shows a part of is no bump but noise
_SHOWN, _FADED = 0.01, float(np.exp(-1.0))
#: a bump that is less than this share of the Coulomb level is no news
_NEWS = 0.05


@dataclass(frozen=True)
class CreepFriction:
    """How much more friction there is towards standstill than Coulomb and viscous friction say, N m (N), with its
    interval, the speed over which that falls to 37 %, and the motion with it: at this speed and at the next ones, which
    nobody chose against it. That the friction of a plain regression has no such part nobody chose either.
    """

    more: float
    interval: Interval
    speed: float
    motions: tuple[AxisMotion, ...]
    #: it is a bump that a reader would miss; a joint that sticks has less friction there
    is_news: bool

    @property
    def findings(self) -> tuple[DataWarning, ...]:
        """What a reader must know of it, if anything."""
        if not self.is_news:
            return ()
        torque, length = ("N", "m") if self.motions[0].rule.linear else ("N m", "rad")
        low, high = (number_text(end, 3) for end in (self.interval.low, self.interval.high))
        more, fades = number_text(self.more, 3), number_text(self.speed, 2)
        text = (
            f"towards standstill friction is {more} {torque} ({low} to {high}) more than coulomb and viscous "
            f"friction, a bump that fades over {fades} {length}/s: the intervals hold what the numbers are beside "
            "it; its form shows at the constant speeds of gimbal-hil experiment sliding"
        )
        return (DataWarning("friction_at_creep", text),)


def creep_friction(motion: AxisMotion, over: tuple[OverPosition, ...], seed: int) -> CreepFriction | None:
    """Friction at creep beside the first regression, of so many numbers; None where its interval reaches nothing."""
    rate_rms = float(np.sqrt(np.mean(motion.rate() ** 2)))
    tried = [replace(motion, creep_speed=share * rate_rms) for share in _SPEEDS]
    problems = [next(one.problems(over))[0] for one in tried]
    shown = [float(np.mean(np.abs(one.columns[one.rows, -1]) > _FADED)) > _SHOWN for one in problems]
    if not any(shown):
        return None
    tried = list(compress(tried, shown))
    fits = [fit_shifted(one) for one in compress(problems, shown)]
    best = min(range(len(fits)), key=lambda index: fits[index].cost)
    fit, speed = fits[best], tried[best].creep_speed
    assert speed is not None
    index = len(fit.solution) - 1
    more = float(fit.solution[index])
    replicates, _ = block_bootstrap(fit.design, fit.target, fit.residual, seed)
    low, high = (float(end) for end in np.percentile(replicates[:, index], [2.5, 97.5]))
    if low <= 0.0 <= high:
        return None
    coulomb = np.mean(fit.solution[3:5]) if motion.rule.per_direction else fit.solution[2]
    interval = Interval(min(more, low), max(more, high))
    near = tuple(tried[best - 1 if best else 0 : best + 2])
    return CreepFriction(more, interval, speed, near, interval.low > _NEWS * abs(float(coulomb)))


__all__ = ["CreepFriction", "creep_friction"]
