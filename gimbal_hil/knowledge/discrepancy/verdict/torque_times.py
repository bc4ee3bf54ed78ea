"""Whether torque columns of logs are early or late against their positions, whatever numbers the model has wrong."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.inquiry import scored_band
from gimbal_hil.knowledge.discrepancy.judgement import Result
from gimbal_hil.knowledge.discrepancy.twin import Floats, Twin, record_of
from gimbal_hil.knowledge.discrepancy.verdict.corrected import corrected_model, explained_by, recalibrated_model
from gimbal_hil.knowledge.discrepancy.verdict.headlines import answer_of
from gimbal_hil.knowledge.discrepancy.verdict.verdict import Verdict
from gimbal_hil.knowledge.discrepancy.verdict.wording import SHIFTED, told_shifts
from gimbal_hil.knowledge.identification import DataWarning, Timing, centred_torque, fit_rigid_axis, regression_rule
from gimbal_hil.pages.report import quantity
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
    shifts = _shifts(_explained(result), tables, stated)
    against = tuple(_entry(axis, timing) for axis, timing in shifts.items())
    effects = tuple(_or_in_the_log(effect, shifts.get(effect["axis"])) for effect in found.effects)
    said = replace(found.said, against=f"{found.said.against} {told_shifts(against)}".strip())
    if effects != found.effects:
        said = replace(said, answer=answer_of(effects, found.alternatives))
    return replace(found, contradictions=(*found.contradictions, *against), effects=effects, said=said)


def _entry(axis: str, timing: Timing) -> Json:
    """A torque column that is early or late, as `contradictions` has it."""
    one = _finding(axis, timing)
    ends = {"late_s": timing.late_s, "low_s": timing.late.low, "high_s": timing.late.high}
    return {"rule": one.rule, "axis": axis, "text": one.text, **ends, "state_as": timing.stated_as(axis)}


def _or_in_the_log(effect: Json, timing: Timing | None) -> Json:
    """A told lag or delay, with the log that looks the same where the torque column is early without it."""
    if timing is None or timing.late_s > 0.0 or not _is_late(effect["name"]):
        return effect
    return {**effect, "or_in_the_log": f"a log whose torque is stamped {quantity(-timing.late_s, 's')} early"}


def _is_late(name: str) -> bool:
    """Whether an effect is a lag or a delay of the drive."""
    effect = CATALOGUE[name]
    return effect.is_before_the_joint and Variable.PAST in effect.acts_through


def _explained(result: Result) -> AntennaModel:
    """The model with what was told, but for lags and delays: a torque column that is early looks like them."""
    if not result.told:
        return corrected_model(result) or recalibrated_model(result)
    kept = result.best.hypothesis
    for index in reversed(range(len(kept.causes))):
        if _is_late(kept.labels[index][0]):
            kept = kept.minus(index)
    return explained_by(result.model, result.inquiry.twin, kept)


def shifted_torques(
    model: AntennaModel, tables: Sequence[SignalsTable], stated: frozenset[str] = frozenset()
) -> tuple[DataWarning, ...]:
    """What `_shifts` finds, as findings."""
    return tuple(_finding(axis, timing) for axis, timing in _shifts(model, tables, stated).items())


def _shifts(model: AntennaModel, tables: Sequence[SignalsTable], stated: frozenset[str]) -> dict[str, Timing]:
    """The time of each axis whose torque column every log excludes to be in time with its positions, on the same
    side, as the longest one says it; none for axes whose times were `stated` or whose torque an effect of the model
    changes on its way. A log that is too short to tell is not asked.

    What the model says of the motion is known, with its bristles, ripples and couplings: at reversals they would pass
    for a shift of many rows. What inertia, viscous and Coulomb friction and offset are off is asked beside the time.
    What the model lacks may pass for a shift too, but for another one in another motion.
    """
    own = {entry.axis for entry in model.effects if entry.effect.hook in (Hook.COMMAND, Hook.STRUCTURE)}
    asked, first = [axis for axis in model.axes if axis not in stated | own], dict[str, Timing]()
    for table in sorted(tables, key=len, reverse=True):
        part = table.rows(0, min(len(table), int(_ENOUGH_S / table.period_s)))
        for axis, timing in _timings(model, part, asked).items():
            one = first.setdefault(axis, timing)
            if not timing.excludes(_LEAST_ROWS) or (timing.late_s > 0.0) != (one.late_s > 0.0):
                asked.remove(axis)
    return {axis: first[axis] for axis in asked if axis in first}


def _finding(axis: str, timing: Timing) -> DataWarning:
    text = f"{timing.text}: {_ELSE[timing.late_s > 0.0]}, as {timing.stated_by(axis)}"
    return DataWarning(SHIFTED, text, axis)


def _moves(model: AntennaModel, table: SignalsTable, axis: str) -> bool:
    return bool(np.ptp(table.position(axis)) > 100.0 * model.number(axis, "encoder.step"))


def _needed(model: AntennaModel, table: SignalsTable) -> Floats:
    """Torque that the model needs for the motion of a log, sampled, (rows, axes)."""
    twin = Twin(model, (record_of(table, model, scored_band((table,)), "times"),))
    structure = twin.structure(())
    needed = twin.records[0].torque - twin.leftover(structure, structure.P, 0)[:, :2]
    held = np.concatenate([needed, needed[-1:]])
    return np.column_stack([centred_torque(column) for column in held.T])


def _timings(model: AntennaModel, table: SignalsTable, axes: Sequence[str]) -> dict[str, Timing]:
    """What a log says of the torques of these axes, as far as it does."""
    moving = [axis for axis in axes if _moves(model, table, axis)]
    found: dict[str, Timing] = {}
    if not moving:
        return found
    with suppress(BadInputError):
        needed = _needed(model, table)
        for axis in moving:
            with suppress(BadInputError):
                found[axis] = _timing(table, axis, needed[:, model.axes.index(axis)])
    return found


def _timing(table: SignalsTable, axis: str, needed: Floats) -> Timing:
    """Raises BadInputError for a log that is too short to tell."""
    rule, position, torque = regression_rule(table.period_s), table.position(axis), table.torque(axis)
    return fit_rigid_axis(table.time_s, position, torque, rule, known=-needed, smoothed=()).timing
