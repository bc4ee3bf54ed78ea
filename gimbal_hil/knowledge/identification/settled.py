"""From a best fit to estimates: profile every parameter, send the undetermined ones back to their prior, refit the
rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.estimate import (
    Determination,
    Estimate,
    Interval,
    number_text,
    settle,
    withheld,
)
from gimbal_hil.knowledge.identification.least_squares import LeastSquaresFit, refit_with_fixed
from gimbal_hil.knowledge.identification.profile import ProfileTask, profile_interval


@dataclass(frozen=True)
class Asked:
    """One parameter that a fit is asked about: unit, prior (None without one), the experiment that would settle it.

    `silent` is a reason why this data cannot say anything about it at all; then it is not profiled.
    """

    name: str
    unit: str
    prior: float | None
    experiment: str
    silent: str = ""


def settle_parameters(
    task: ProfileTask, asked: Sequence[Asked], bias: Vector | None = None
) -> tuple[tuple[Estimate, ...], LeastSquaresFit]:
    """Estimates of the first `len(asked)` parameters, and the fit that holds with the undetermined ones at their prior.

    An interval is that of the joint fit, in which nothing was fixed, stretched to hold the value after the refit:
    fixing one parameter at its prior must not make another look better known than the data alone make it. One whose
    interval is too wide for the value that it then has goes back to its prior as well. `bias`, (p,), is how far the fit
    is known to lie off by the method's own fault: estimates are without it, and intervals hold what they hold with it
    and without. The fit that is answered has it, as what it simulates has.
    """
    intervals = {index: profile_interval(task, index) for index, one in enumerate(asked) if not one.silent}
    off = np.zeros(len(task.best.values)) if bias is None else bias
    intervals = {index: one.moved(-float(off[index])) for index, one in intervals.items()}
    estimates = []
    for index, one in enumerate(asked):
        if one.silent:
            estimates.append(withheld(one.name, one.unit, one.prior, one.silent, one.experiment))
        else:
            fitted = float(task.best.values[index] - off[index])
            estimates.append(settle(one.name, fitted, intervals[index], one.unit, one.prior, one.experiment))
    joint, found, best = tuple(estimates), tuple(estimates), task.best
    kept = _at_their_prior(joint)
    while kept:
        fixed = {i: one.value for i, one in kept.items()}
        best = refit_with_fixed(
            task.residuals, task.parameters, task.best.values, fixed, task.difference_step, task.tolerance
        )
        values = best.values - off
        found = tuple(kept.get(i) or _moved(e, float(values[i]), asked[i]) for i, e in enumerate(joint))
        more = _at_their_prior(found)
        if len(more) == len(kept):
            break
        kept = more
    return found, best


def _at_their_prior(estimates: Sequence[Estimate]) -> dict[int, Estimate]:
    """Those that keep their prior, by place."""
    open_ones = ((i, one) for i, one in enumerate(estimates) if one.verdict is Determination.NOT_IDENTIFIED)
    return {i: one for i, one in open_ones if one.prior is not None}


def _moved(joint: Estimate, value: float, asked: Asked) -> Estimate:
    """An estimate at the value that it has beside those at their prior, with what its interval is worth there where
    that is less.
    """
    known = joint.interval
    interval = Interval(min(known.low, value), max(known.high, value), known.open_low, known.open_high)
    there = settle(joint.name, value, interval, joint.unit, joint.prior, asked.experiment)
    if there.verdict.rank <= joint.verdict.rank:
        return replace(joint, value=value, interval=interval)
    if there.verdict is not Determination.NOT_IDENTIFIED:
        return replace(there, fitted=joint.fitted)
    why = f"beside the priors of others it comes to {number_text(value)}, and its interval is too wide for that"
    return replace(there, fitted=joint.fitted, interval=known, reason=why)
