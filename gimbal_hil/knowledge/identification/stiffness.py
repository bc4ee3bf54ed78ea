"""Stiffness from slow torque and from simulated motion: what the curve's approximations do to it, and where the two
exclude each other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gimbal_hil.knowledge.identification.axis_response import simulate_axis
from gimbal_hil.knowledge.identification.estimate import DataWarning, Determination
from gimbal_hil.knowledge.identification.evidence import Evidence
from gimbal_hil.knowledge.identification.output_error import EXPERIMENTS, OutputErrorFit
from gimbal_hil.knowledge.identification.presliding import PreslidingFit, PreslidingRun


def with_own_error(
    presliding: PreslidingFit,
    curve: Callable[[Sequence[PreslidingRun]], PreslidingFit | None],
    evidence: Evidence,
    dynamic: OutputErrorFit,
) -> PreslidingFit:
    """The curve's stiffness with an interval that holds what its approximations do to it: the same torque on the axis
    as simulated with a known stiffness, by the same curve.
    """
    assert evidence.inertia is not None
    simulated = []
    for run in evidence.presliding:
        record = next(one for one in evidence.records if one.position is run.position)
        position, _ = simulate_axis(record, evidence.inertia, dynamic.friction, dynamic.offset)
        simulated.append(replace(run, position=position))
    again = curve(simulated)
    if again is None or not np.isfinite(again.sigma0.fitted):
        return presliding
    off = presliding.sigma0.fitted * (dynamic.friction.sigma0 / again.sigma0.fitted - 1.0)
    return replace(presliding, sigma0=replace(presliding.sigma0, interval=presliding.sigma0.interval.moved(float(off))))


def doubted(dynamic: OutputErrorFit | None) -> OutputErrorFit | None:
    """A fit to simulated motion whose stiffness slow ramps exclude: nothing of it is known as well as it says."""
    if dynamic is None:
        return None
    reason = "slow ramps exclude the stiffness of the simulated motion that this comes from"
    experiment = EXPERIMENTS["sigma1"]
    weaker = {Determination.IDENTIFIED: Determination.WEAKLY_IDENTIFIED}
    return replace(
        dynamic,
        estimates=tuple(
            replace(
                e,
                verdict=weaker.get(e.verdict, e.verdict),
                reason=e.reason or reason,
                experiment=e.experiment or experiment,
            )
            for e in dynamic.estimates
        ),
    )


def disagreement(
    presliding: PreslidingFit | None, dynamic: OutputErrorFit | None, axis: str
) -> tuple[DataWarning, ...]:
    """Slow and fast presliding that ask for different stiffness: the bristle model itself is then in doubt."""
    if presliding is None or dynamic is None:
        return ()
    slow, fast = presliding.sigma0, next((e for e in dynamic.estimates if e.name == "sigma0"), None)
    if fast is None or Determination.NOT_IDENTIFIED in (slow.verdict, fast.verdict):
        return ()
    if slow.interval.low <= fast.interval.high and fast.interval.low <= slow.interval.high:
        return ()
    text = (
        f"sigma0 from slow ramps {slow.fitted_text} ({slow.interval_text}) and from "
        f"simulated motion {fast.fitted_text} ({fast.interval_text}) exclude each other: "
        "one bristle does not describe both"
    )
    return (DataWarning("stiffness_disagrees", text, axis),)
