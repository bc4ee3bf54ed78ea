"""From a best fit to estimates: profile every parameter, send the undetermined ones back to their prior, refit the
rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.identification.averaging import Vector
from gimbal_hil.knowledge.identification.estimate import Determination, Estimate, Interval, settle, withheld
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
    fixing one parameter at its prior must not make another look better known than the data alone make it. `bias`,
    (p,), is how far the fit is known to lie off by the method's own fault: estimates are without it, and intervals hold
    what they hold with it and without. The fit that is answered has it, as what it simulates has.
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
    fixed = {
        i: e.value for i, e in enumerate(estimates) if e.verdict is Determination.NOT_IDENTIFIED and e.prior is not None
    }
    if not fixed:
        return tuple(estimates), task.best
    again = refit_with_fixed(
        task.residuals, task.parameters, task.best.values, fixed, task.difference_step, task.tolerance
    )
    moved = again.values - off
    return tuple(e if i in fixed else _moved(e, float(moved[i])) for i, e in enumerate(estimates)), again


def _moved(estimate: Estimate, value: float) -> Estimate:
    interval = estimate.interval
    return replace(
        estimate,
        value=value,
        interval=Interval(min(interval.low, value), max(interval.high, value), interval.open_low, interval.open_high),
    )
