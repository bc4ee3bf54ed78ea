"""Identification of one axis: velocity map, presliding, output error, regression, and their combined result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.identification.axis_motion import regression_rule
from gimbal_hil.knowledge.identification.axis_response import AxisRecord
from gimbal_hil.knowledge.identification.consistency import (
    BreakAway,
    break_away,
    break_away_findings,
    physical_findings,
    points_at_rest,
    repeatability_findings,
)
from gimbal_hil.knowledge.identification.correlations import Correlations, joined
from gimbal_hil.knowledge.identification.estimate import DataWarning, Determination, Estimate, straight, withheld
from gimbal_hil.knowledge.identification.evidence import Evidence, Log, collect
from gimbal_hil.knowledge.identification.output_error import (
    EXPERIMENTS,
    OutputErrorFit,
    OutputErrorRule,
    fit_output_error,
)
from gimbal_hil.knowledge.identification.presliding import (
    STEPS_FOR_SIGMA1,
    PreslidingFit,
    PreslidingRun,
    fit_presliding,
)
from gimbal_hil.knowledge.identification.rigid_axis import RigidAxisFit, fit_rigid_axis
from gimbal_hil.knowledge.identification.rigid_load import axis_load
from gimbal_hil.knowledge.identification.segments import TorqueSource
from gimbal_hil.knowledge.identification.sliding import LEAST_POINTS, MapHalf, StaticFit, fit_static
from gimbal_hil.knowledge.identification.stiffness import disagreement, doubted, with_own_error
from gimbal_hil.knowledge.identification.stribeck import LUGRE_NAMES, LUGRE_UNITS, LugreFriction, StaticFriction
from gimbal_hil.knowledge.identification.torque_scale import scale_findings, without_doubted
from gimbal_hil.knowledge.identification.velocity_map import VelocityMap, measure_velocity_map
from sim_backend.model import AntennaModel

#: longest total stretch that goes into one output-error fit; shorter stretches first
_MOST_SECONDS = 60.0
#: without a velocity map the whole motion counts; with one, only up to this many bristle lengths Ts / sigma0 from rest
_BRISTLE_LENGTHS = 3.0
_LEAST_ROWS = 100
_LEAST_REGRESSION_ROWS = 1000


@dataclass(frozen=True)
class AxisIdentification:
    """Everything found out about one axis. What the data did not allow is None; `estimates` are the final word per
    parameter.
    """

    axis: str
    evidence: Evidence
    velocity_map: VelocityMap | None
    both: StaticFit | None
    positive: StaticFit | None
    negative: StaticFit | None
    presliding: PreslidingFit | None
    dynamic: OutputErrorFit | None
    rigid: RigidAxisFit | None
    rigid_per_direction: RigidAxisFit | None
    break_aways: tuple[BreakAway, ...]
    estimates: tuple[Estimate, ...]
    friction: LugreFriction
    findings: tuple[DataWarning, ...]
    correlations: Correlations


def friction_of(model: AntennaModel, axis: str) -> LugreFriction:
    """The LuGre numbers that a model holds for an axis."""
    static, dynamic = LUGRE_NAMES[:5], LUGRE_NAMES[5:]
    return LugreFriction(
        StaticFriction(*(model.number(axis, f"friction.{name}") for name in static)),
        *(model.number(axis, f"friction.{name}") for name in dynamic),
    )


def axes_to_identify(model: AntennaModel, asked: Sequence[str] | None, where: str) -> tuple[str, ...]:
    """The axes asked for, or all; BadInputError for a name that the model has not (told with `where`)."""
    for name in asked or ():
        if name not in model.axes:
            raise BadInputError(where, f"no axis {name!r}", "one of " + ", ".join(model.axes))
    return tuple(asked or model.axes)


def identify_axis(
    logs: Sequence[Log],
    model: AntennaModel,
    axis: str,
    seed: int = 0,
    ramps_at_rest: bool = False,
) -> AxisIdentification:
    """Identify one axis from logs, with the model as prior and as source of inertia, gravity and the encoder step.

    With `ramps_at_rest` the torques at which slow ramps break away are points of the velocity map at rest, one a
    direction.
    """
    evidence = collect(logs, model, axis)
    prior = friction_of(model, axis)
    step = model.number(axis, "encoder.step")
    velocity_map = _velocity_map(evidence, prior, step)
    points = velocity_map.points if velocity_map else ()
    if ramps_at_rest and points:
        points = (*points, *points_at_rest(_break_aways(evidence, _bent(evidence, prior, step), step), points))
    both, positive, negative = (
        fit_static(points, d, prior.static) for d in (MapHalf.BOTH, MapHalf.POSITIVE, MapHalf.NEGATIVE)
    )
    static = both or positive or negative
    known = prior if static is None else LugreFriction(static.friction, prior.sigma0, prior.sigma1)
    presliding, dynamic = _bristles(evidence, known, static is not None, step, OutputErrorRule(seed=seed))
    rigid = (
        _rigid(logs, model, axis)
        if static is None and len(model.axes) == 1 and not _only_bends(logs, axis)
        else (None, None)
    )
    disagreeing = disagreement(presliding, dynamic, axis)
    said = doubted(dynamic) if disagreeing else dynamic
    estimates = _final(prior, velocity_map, static, presliding, said, rigid[0])
    scale: tuple[DataWarning, ...] = ()
    if rigid[0] is not None:
        estimates, scale = _beside_the_model(estimates, _longest(logs).table, model, axis)
    usable = [e for e in estimates if e.name in LUGRE_NAMES and np.isfinite(e.value)]
    friction = prior.with_values(tuple(e.name for e in usable), np.array([e.value for e in usable]))
    broken = _break_aways(evidence, friction, step)
    findings = [
        finding
        for fit in ((positive, negative) if positive and negative else (static,))
        if fit is not None
        for finding in break_away_findings(broken, fit, axis)
    ]
    findings += repeatability_findings(velocity_map.points if velocity_map else (), axis)
    decided = {e.name for e in estimates if e.verdict is not Determination.NOT_IDENTIFIED}
    unit = "N s/m" if model.is_linear else "N m s/rad"
    findings += [finding for finding in physical_findings(friction, axis, unit) if decided & finding.concerns]
    findings += disagreeing
    if rigid[0] is not None:
        findings += rigid[0].unexplained(axis)
        findings += [replace(one, axis=axis) for one in rigid[0].warnings]
        findings += rigid[0].timing.findings(axis)
        findings += [] if rigid[0].parts is None else [rigid[0].parts.finding(axis)]
        findings += [smoothed.finding(axis) for smoothed in rigid[0].smoothed[:1]]
        findings += scale
        findings += [ripple.finding(axis, model.is_linear) for ripple in rigid[0].ripples]
    found = AxisIdentification(
        axis=axis,
        evidence=evidence,
        velocity_map=velocity_map,
        both=both,
        positive=positive,
        negative=negative,
        presliding=presliding,
        dynamic=dynamic,
        rigid=rigid[0],
        rigid_per_direction=rigid[1],
        break_aways=broken,
        estimates=estimates,
        friction=friction,
        findings=tuple(findings),
        correlations=joined(
            estimates,
            [(fit.estimates, fit.correlations) for fit in (static, dynamic, rigid[0]) if fit is not None],
        ),
    )
    return _in_straight_units(found) if model.is_linear else found


def numbers_of_motion(logs: Sequence[Log], model: AntennaModel, axis: str) -> tuple[Estimate, ...]:
    """The same estimates as far as motion that slides tells them, without the fits to simulated motion: friction from
    plateaus, otherwise friction and inertia of a single axis from a regression.
    """
    evidence, prior = collect(logs, model, axis), friction_of(model, axis)
    velocity_map = _velocity_map(evidence, prior, model.number(axis, "encoder.step"))
    static = fit_static(velocity_map.points, MapHalf.BOTH, prior.static) if velocity_map else None
    rigid = _rigid(logs, model, axis)[0] if static is None and len(model.axes) == 1 else None
    found = _final(prior, velocity_map, static, None, None, rigid)
    return tuple(map(straight, found)) if model.is_linear else found


def _velocity_map(evidence: Evidence, prior: LugreFriction, step: float) -> VelocityMap | None:
    """Friction over speed, as far as there are plateaus."""
    length = prior.static.breakaway / prior.sigma0 if prior.sigma0 > 0.0 else 0.0
    return measure_velocity_map(evidence.plateaus, None, step or None, length) if evidence.plateaus else None


def _in_straight_units(found: AxisIdentification) -> AxisIdentification:
    """The same with the units of a linear axis: the fits know numbers only."""
    fits = {
        name: fit for name in ("both", "positive", "negative", "dynamic") if (fit := getattr(found, name)) is not None
    }
    converted = {name: replace(fit, estimates=tuple(map(straight, fit.estimates))) for name, fit in fits.items()}
    if found.presliding is not None:
        sigma0, breakaway = straight(found.presliding.sigma0), straight(found.presliding.breakaway)
        converted["presliding"] = replace(found.presliding, sigma0=sigma0, breakaway=breakaway)
    return replace(found, estimates=tuple(map(straight, found.estimates)), **converted)


def _bristles(
    evidence: Evidence,
    known: LugreFriction,
    has_map: bool,
    step: float,
    rule: OutputErrorRule,
) -> tuple[PreslidingFit | None, OutputErrorFit | None]:
    """sigma0 from the exact presliding curve, then sigma0 and sigma1 from simulated motion; the curve again with the
    new sigma1.
    """
    breakaway = max(known.static.breakaway, 1e-9)
    presliding = (
        fit_presliding(evidence.presliding, breakaway, step, known.sigma0, known.sigma1, False, known.static)
        if evidence.presliding
        else None
    )
    if presliding is not None and presliding.sigma0.verdict is not Determination.NOT_IDENTIFIED:
        known = replace(known, sigma0=presliding.sigma0.fitted)
    bend = _BRISTLE_LENGTHS * breakaway / known.sigma0 if known.sigma0 > 0.0 else float("inf")
    # a joint that never slides says nothing of sliding: there viscosity and the bristle's damping are one number
    slides = any(np.ptp(record.position) > bend for record in evidence.records)
    free = LUGRE_NAMES if slides and not has_map else ("breakaway", "sigma0", "sigma1")
    records = _cut(evidence.records, bend if has_map else float("inf"))
    if not records or evidence.inertia is None or known.sigma0 <= 0.0 or known.sigma1 <= 0.0:
        return presliding, None
    dynamic = fit_output_error(records, evidence.inertia, known, free, step, rule)
    sigma1 = next(e for e in dynamic.estimates if e.name == "sigma1")
    if presliding is not None and sigma1.verdict is Determination.IDENTIFIED:

        def curve(runs: Sequence[PreslidingRun]) -> PreslidingFit | None:
            return fit_presliding(runs, breakaway, step, known.sigma0, sigma1.value, True, known.static)

        presliding = curve(evidence.presliding)
        presliding = None if presliding is None else with_own_error(presliding, curve, evidence, dynamic)
    return presliding, dynamic


def _cut(records: Sequence[AxisRecord], length: float) -> tuple[AxisRecord, ...]:
    """Records up to the row where the joint has left its start by `length`, shortest first, up to a minute in total."""
    chosen: list[AxisRecord] = []
    total = 0.0
    for record in sorted(records, key=lambda r: len(r.position) * r.step_s):
        away = abs(record.position - record.position[0]) > length
        stop = int(away.argmax()) if away.any() else len(away)
        if stop < _LEAST_ROWS or (total + stop * record.step_s > _MOST_SECONDS and chosen):
            continue
        total += stop * record.step_s
        chosen.append(AxisRecord(record.label, record.step_s, record.torque[:stop], record.position[:stop]))
    return tuple(chosen)


def _rigid(logs: Sequence[Log], model: AntennaModel, axis: str) -> tuple[RigidAxisFit | None, RigidAxisFit | None]:
    """Regression of a single axis over its longest log, gravity taken out, symmetric and per direction; None when it
    hardly moves.
    """
    longest = _longest(logs)
    table = longest.table
    position = table.position(axis)
    if len(table) < _LEAST_REGRESSION_ROWS or np.ptp(position) <= 100.0 * model.number(axis, "encoder.step"):
        return None, None
    load = axis_load(table, model, axis)
    rule = regression_rule(table.period_s, axis in longest.time_stated, model.is_linear)
    logged = (table.time_s, position, load.held)
    both = fit_rigid_axis(*logged, rule, known=load.bias)
    split = fit_rigid_axis(*logged, replace(rule, per_direction=True), known=load.bias, smoothed=both.smoothed)
    return both, split


def _longest(logs: Sequence[Log]) -> Log:
    return max(logs, key=lambda one: len(one.table))


def _only_bends(logs: Sequence[Log], axis: str) -> bool:
    """Whether torque was commanded directly all the time: then the joint mostly stands, and a regression on its speed
    means nothing.
    """
    stretches = [stretch for log in logs for stretch in log.stretches[axis]]
    return bool(stretches) and all(stretch.drive is TorqueSource.TORQUE for stretch in stretches)


def _final(
    prior: LugreFriction,
    velocity_map: VelocityMap | None,
    static: StaticFit | None,
    presliding: PreslidingFit | None,
    dynamic: OutputErrorFit | None,
    rigid: RigidAxisFit | None,
) -> tuple[Estimate, ...]:
    """One estimate per parameter: static ones from the map, bristles from simulated motion or the presliding curve,
    else the prior.
    """
    from_map = {e.name: e for e in static.estimates} if static else {}
    # where these fits began is not where the model stood: the map and the slow ramps have spoken before them
    given = dict(zip(LUGRE_NAMES, prior.values().tolist(), strict=True))
    from_motion = {e.name: replace(e, prior=given[e.name]) for e in dynamic.estimates} if dynamic else {}
    from_regression = {name: _beside(e, given.get(name)) for name, e in _possible(rigid, given).items()}
    final = []
    for name, unit, value in zip(LUGRE_NAMES, LUGRE_UNITS, prior.values().tolist(), strict=True):
        candidates = [source[name] for source in (from_map, from_regression, from_motion) if name in source]
        identified = any(c.verdict is Determination.IDENTIFIED for c in candidates)
        if name == "sigma0" and presliding is not None and not identified:
            # simulated motion makes no approximation; the curve stands in where there is none
            candidates.append(replace(presliding.sigma0, prior=value))
        if name == "sigma1" and presliding is not None and presliding.travel_steps < STEPS_FOR_SIGMA1:
            travel = f"presliding travel is only {presliding.travel_steps:.1f} encoder steps"
            reason = f"{travel}, {STEPS_FOR_SIGMA1:.0f} are needed"
            candidates = [withheld(name, unit, value, reason, EXPERIMENTS[name])]
        if not candidates:
            candidates = [withheld(name, unit, value, _why_none(name, velocity_map), EXPERIMENTS[name])]
        final.append(min(candidates, key=_rank))
    final += [from_regression[name] for name in ("inertia", "offset") if name in from_regression]
    return tuple(final)


def _beside_the_model(
    estimates: tuple[Estimate, ...], table: SignalsTable, model: AntennaModel, axis: str
) -> tuple[tuple[Estimate, ...], tuple[DataWarning, ...]]:
    """Numbers of a regression with the model's inertia beside theirs, and what the model's torques say of them."""
    load = axis_load(table, model, axis)
    scale = scale_findings(load, table, model, axis, estimates)
    given = (_beside(e, load.inertia if e.name == "inertia" else e.prior) for e in estimates)
    return without_doubted(tuple(given), scale), scale


def _beside(found: Estimate, given: float | None) -> Estimate:
    """A number of a regression, which begins from none, beside the model's; that stands where it is not identified."""
    if given is None:
        return found
    stands = found.verdict is Determination.NOT_IDENTIFIED
    return replace(found, prior=given, value=given if stands else found.value)


def _why_none(name: str, velocity_map: VelocityMap | None) -> str:
    """Why nothing speaks of a number: no motion that depends on it, or too few steady speeds for a friction curve."""
    seen = 0 if velocity_map is None else len(velocity_map.points)
    if name in ("sigma0", "sigma1") or seen == 0:
        return "nothing in these logs depends on it"
    return f"{seen} steady speeds, and a friction curve takes {LEAST_POINTS} at least, both directions counted"


def _possible(rigid: RigidAxisFit | None, given: Mapping[str, float]) -> dict[str, Estimate]:
    """Estimates of a regression by name; all withheld where it asks for an inertia or a Coulomb level below zero, which
    means that the torque did not drive the motion: it bends a joint that stands. A viscosity below zero is hardly seen.
    `given` are the model's numbers.
    """
    if rigid is None:
        return {}
    found = {e.name: e for e in rigid.estimates}
    meaningless = any(found[name].value <= 0.0 for name in ("inertia", "coulomb") if name in found)
    below = {e.name: e.value for e in rigid.estimates if e.name != "offset" and e.value <= 0.0}
    asked_for = ", ".join(f"{name} {value:.3g}" for name, value in below.items())
    reason = f"a regression over the whole log gives {asked_for}, which cannot be below zero"
    experiment = "a log in which the joint slides both ways; of torque that was commanded directly, --torque-driven"
    return {
        name: withheld(name, e.unit, given.get(name), reason, experiment) if meaningless or name in below else e
        for name, e in found.items()
    }


def _rank(estimate: Estimate) -> tuple[int, float]:
    """Better verdict first, then the narrower interval."""
    return estimate.verdict.rank, estimate.interval.high - estimate.interval.low


def _break_aways(evidence: Evidence, friction: LugreFriction, step: float) -> tuple[BreakAway, ...]:
    if friction.sigma0 <= 0.0:
        return ()
    found = (break_away(run, friction.sigma0, step) for run in evidence.presliding)
    return tuple(one for one in found if one is not None)


def _bent(evidence: Evidence, prior: LugreFriction, step: float) -> LugreFriction:
    """The prior with the stiffness found from slow torque, by which a break-away is recognised."""
    if not evidence.presliding:
        return prior
    shown = fit_presliding(evidence.presliding, max(prior.static.breakaway, 1e-9), step, prior.sigma0)
    return (
        prior
        if shown is None or shown.sigma0.verdict is Determination.NOT_IDENTIFIED
        else replace(prior, sigma0=shown.sigma0.fitted)
    )
