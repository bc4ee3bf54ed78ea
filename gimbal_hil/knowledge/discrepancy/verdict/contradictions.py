"""Where the data contradict themselves: slow ramps that break away below the torque that sliding needs however slow.

No friction curve of the model's kind describes both, whatever its numbers and whatever is added beside it. Such a
finding stands beside the verdict and changes nothing in it: it says which of the data one should not fit through.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from sim_backend.model import AntennaModel

if TYPE_CHECKING:
    from gimbal_hil.knowledge.identification import BreakAway, DataWarning, PreslidingRun, StaticFit, VelocityPoint

#: slow ramps: the torque changes by less than this share of break-away a row, as identification takes it
_SLOW_SHARE = 0.02
#: and takes this long at least to its largest value, s
_LEAST_RISE_S = 2.0
#: and up to half of that the joint moves by no more than this share of the log's travel
_STANDING_SHARE = 0.15
#: and it goes one way, up to this share of its range, until it is at its largest
_BACK_SHARE = 0.05
_WITHOUT_BRISTLE = (
    "is a slow ramp of torque, about which a model without bristles says nothing: looked at for contradictions alone"
)


def contradictions(model: AntennaModel, tables: Sequence[SignalsTable]) -> list[dict[str, str]]:
    """Findings as `rule`, `axis` and `text`; empty where ramps or plateaus are missing, or where they agree.

    `model` is the one that explains the data best: its rigid body and actuator are taken out of the torque. What it
    adds by position is granted to the ramps in full: each stands at one place of that, while plateaus pass over it all.
    """
    found = []
    for axis in model.axes:
        if any(_is_ramp(table, model, axis) for table in tables):
            found += _of_axis(model, axis, tables)
    return found


def ramps_apart(
    model: AntennaModel, tables: tuple[SignalsTable, ...]
) -> tuple[tuple[SignalsTable, ...], tuple[SignalsTable, ...], list[str]]:
    """Logs that a search can use, slow ramps that it cannot (for a model without bristles), and notes that say so."""
    without = [axis for axis in model.axes if model.number(axis, "friction.sigma0") <= 0.0]
    ramps = tuple(table for table in tables if any(_is_ramp(table, model, axis) for axis in without))
    if len(ramps) == len(tables):
        return tables, (), []
    rest = tuple(table for table in tables if not any(table is ramp for ramp in ramps))
    return rest, ramps, [f"{table.source}: {_WITHOUT_BRISTLE}" for table in ramps]


def _by_position(model: AntennaModel, axis: str, tables: Sequence[SignalsTable]) -> float:
    """Largest torque that the model's effects add on an axis from one place to another, N m or N."""
    most, breakaway = 0.0, model.number(axis, "friction.breakaway")
    for entry in model.effects:
        if entry.axis == axis and entry.effect.torque_over_position is not None:
            travel = max(float(np.ptp(table.position(axis))) for table in tables)
            values = {parameter.name: entry.value(parameter.name) for parameter in entry.effect.parameters}
            most += entry.effect.torque_over_position(values, breakaway, travel)
    return most


def _is_ramp(table: SignalsTable, model: AntennaModel, axis: str) -> bool:
    """Whether nobody knows of a loop, the torque rises one way and slowly until it is at its largest, and the joint
    stands at first.
    """
    if any(table.signal(axis, name) is not None for name in ("rate_ref", "position_ref")):
        return False
    torque = table.torque(axis)
    away = torque - torque[0]
    peak = int(np.argmax(np.abs(away)))
    rising = np.sign(away[peak]) * away[: peak + 1]
    steps = np.diff(rising)
    slow = _SLOW_SHARE * model.number(axis, "friction.breakaway")
    back = np.maximum.accumulate(rising) - rising
    if peak * table.period_s < _LEAST_RISE_S or np.abs(steps).max() >= slow or back.max() > _BACK_SHARE * rising[-1]:
        return False
    position = table.position(axis)
    half = int(np.argmax(rising >= 0.5 * rising[-1]))
    return bool(np.ptp(position[: half + 1]) <= _STANDING_SHARE * np.ptp(position))


def _stiffness(model: AntennaModel, axis: str, runs: Sequence[PreslidingRun]) -> float:
    """The model's bristle stiffness, or for one without a bristle that which the ramps show; zero where neither is
    there.
    """
    from gimbal_hil.knowledge.identification import fit_presliding

    stated = model.number(axis, "friction.sigma0")
    if stated > 0.0 or not runs:
        return stated
    shown = fit_presliding(
        runs, max(model.number(axis, "friction.breakaway"), 1e-9), model.number(axis, "encoder.step")
    )
    return 0.0 if shown is None or not np.isfinite(shown.sigma0.fitted) else shown.sigma0.fitted


def _of_axis(model: AntennaModel, axis: str, tables: Sequence[SignalsTable]) -> list[dict[str, str]]:
    from gimbal_hil.knowledge.identification import (
        Log,
        MapHalf,
        Stretch,
        TorqueSource,
        break_away,
        collect,
        fit_static,
        friction_of,
        measure_velocity_map,
        stretches_of_table,
    )

    logs = []
    for table in tables:
        ramp = _is_ramp(table, model, axis)
        stretches = (Stretch("ramp", 0, len(table), TorqueSource.TORQUE),) if ramp else stretches_of_table(table, axis)
        logs.append(
            Log(
                table.source,
                table,
                {axis: tuple(replace(s, drive=TorqueSource.TORQUE if ramp else TorqueSource.LOOP) for s in stretches)},
            )
        )
    evidence = collect(logs, model, axis)
    step = model.number(axis, "encoder.step")
    stiffness = _stiffness(model, axis, evidence.presliding)
    if stiffness <= 0.0 or not evidence.plateaus:
        return []
    ramps = [one for run in evidence.presliding if (one := break_away(run, stiffness, step)) is not None]
    if not ramps:
        return []
    prior = friction_of(model, axis)
    points = measure_velocity_map(evidence.plateaus, None, step or None, prior.static.breakaway / stiffness).points
    sides = [fit_static(points, direction, prior.static) for direction in (MapHalf.POSITIVE, MapHalf.NEGATIVE)]
    found, generous = (
        _findings(at, sides, points, axis) for at in (ramps, _raised(ramps, _by_position(model, axis, tables)))
    )
    sure = {_direction(finding) for finding in generous}
    return [{"rule": f.rule, "axis": axis, "text": f.text} for f in found if _direction(f) in sure]


def _findings(
    ramps: Sequence[BreakAway], sides: Sequence[StaticFit | None], points: Sequence[VelocityPoint], axis: str
) -> list[DataWarning]:
    """One finding a direction at most, the positive one first: by the fitted Coulomb torque, else by the lowest sliding
    torque.
    """
    from gimbal_hil.knowledge.identification import break_away_below_sliding, break_away_findings

    fitted = [finding for side in sides if side is not None for finding in break_away_findings(ramps, side, axis)]
    told = {_direction(finding) for finding in fitted}
    seen = [finding for finding in break_away_below_sliding(ramps, points, axis) if _direction(finding) not in told]
    return sorted((*fitted, *seen), key=_direction, reverse=True)


def _direction(finding: DataWarning) -> str:
    return finding.text.split()[0]


def _raised(ramps: Sequence[BreakAway], by: float) -> list[BreakAway]:
    return [replace(one, torque=one.torque + math.copysign(by, one.torque)) for one in ramps]
