"""Whether torque columns of logs are early or late against their positions, whatever numbers the model has wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.inquiry import scored_band
from gimbal_hil.knowledge.discrepancy.judgement import Result
from gimbal_hil.knowledge.discrepancy.twin import Floats, Twin, record_of
from gimbal_hil.knowledge.discrepancy.verdict.corrected import corrected_model, explained_by, recalibrated_model
from gimbal_hil.knowledge.discrepancy.verdict.verdict import Verdict
from gimbal_hil.knowledge.discrepancy.verdict.wording import told_shift
from gimbal_hil.knowledge.identification import DataWarning, Timing, centred_torque, fit_rigid_axis, regression_rule
from sim_backend.effects import CATALOGUE, Hook, Variable
from sim_backend.model import AntennaModel

#: a minute of a log says enough of its clocks
_ENOUGH_S = 60.0
#: rows: what is nearer to being in time than this is as near as stamps and integrators are
_LEAST_ROWS = 0.1
#: what looks the same: nothing acts before its command, but a drive may act late
_ELSE = {
    True: "no drive acts before its command, so it is the log; state it",
    False: "a delay of the drive looks the same; if it is the log, state it",
}


def with_torque_times(
    found: Verdict, result: Result, tables: Sequence[SignalsTable], stated: frozenset[str]
) -> Verdict:
    """A verdict that also says whose torque column is early or late, the told causes being there."""
    shifted = shifted_torques(_explained(result), tables, stated)
    against = tuple({"rule": one.rule, "axis": one.axis, "text": one.text} for one in shifted)
    text = found.text + "".join(map(told_shift, against))
    return replace(found, contradictions=(*found.contradictions, *against), text=text)


def _explained(result: Result) -> AntennaModel:
    """The model with what was told, but for lags and delays: a torque column that is early looks like them."""
    if not result.told:
        return corrected_model(result) or recalibrated_model(result)
    kept = result.best.hypothesis
    for index in reversed(range(len(kept.causes))):
        effect = CATALOGUE[kept.labels[index][0]]
        if effect.is_before_the_joint and Variable.PAST in effect.acts_through:
            kept = kept.minus(index)
    return explained_by(result.model, result.inquiry.twin, kept)


def shifted_torques(
    model: AntennaModel, tables: Sequence[SignalsTable], stated: frozenset[str] = frozenset()
) -> tuple[DataWarning, ...]:
    """A finding for each axis whose torque column every log excludes to be in time with its positions, on the same
    side, as the longest one says it; none for axes whose times were `stated` or whose torque an effect of the model
    changes on its way. A log that is too short to tell is not asked.

    What the model says of the motion is known, with its bristles, ripples and couplings: at reversals they would pass
    for a shift of many rows. What inertia, viscous and Coulomb friction and offset are off is asked beside the time.
    What the model lacks may pass for a shift too, but for another one in another motion.
    """
    own = {entry.axis for entry in model.effects if entry.effect.hook in (Hook.COMMAND, Hook.STRUCTURE)}
    found = []
    for axis in (axis for axis in model.axes if axis not in stated | own):
        timing = _timing_of_all(model, tables, axis)
        if timing is not None:
            text = f"{timing.text}: {_ELSE[timing.late_s > 0.0]}, as {timing.stated_by(axis)}"
            found.append(DataWarning("torque_shifted", text, axis))
    return tuple(found)


def _timing_of_all(model: AntennaModel, tables: Sequence[SignalsTable], axis: str) -> Timing | None:
    """What the longest log says of an axis' torque, if all logs exclude that it is in time and say the same way."""
    first: Timing | None = None
    for table in sorted(tables, key=len, reverse=True):
        part = table.rows(0, min(len(table), int(_ENOUGH_S / table.period_s)))
        timing = _timing(model, part, axis) if _moves(model, part, axis) else None
        if timing is None:
            continue
        first = first or timing
        if not timing.excludes(_LEAST_ROWS) or (timing.late_s > 0.0) != (first.late_s > 0.0):
            return None
    return first


def _moves(model: AntennaModel, table: SignalsTable, axis: str) -> bool:
    return bool(np.ptp(table.position(axis)) > 100.0 * model.number(axis, "encoder.step"))


def _needed(model: AntennaModel, table: SignalsTable) -> Floats:
    """Torque that the model needs for the motion of a log, sampled, (rows, axes)."""
    twin = Twin(model, (record_of(table, model, scored_band((table,)), "times"),))
    structure = twin.structure(())
    needed = twin.records[0].torque - twin.leftover(structure, structure.P, 0)[:, :2]
    held = np.concatenate([needed, needed[-1:]])
    return np.column_stack([centred_torque(column) for column in held.T])


def _timing(model: AntennaModel, table: SignalsTable, axis: str) -> Timing | None:
    try:
        rule = regression_rule(table.period_s)
        needed = _needed(model, table)[:, model.axes.index(axis)]
        position, torque = table.position(axis), table.torque(axis)
        return fit_rigid_axis(table.time_s, position, torque, rule, known=-needed, smoothed=()).timing
    except BadInputError:
        return None
