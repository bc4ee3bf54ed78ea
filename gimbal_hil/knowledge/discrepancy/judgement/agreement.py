"""Checks a number that was named as wrong against `identify`, on the same logs.

The search explains a residual and can choose among many names; the regression of `identify` knows only inertia and
sliding friction and takes the command as it is. Each method has errors of its own. If their intervals do not overlap
and the regression's value is nearer to the model, one of the two is wrong, so neither this number nor anything that was
fitted beside it on the axis is named. Where they overlap, the number is known no better than either method allows.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.discrepancy.hypotheses import values_of
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry
from gimbal_hil.knowledge.discrepancy.judgement.deciding import Decision, Denial, Status, Told, kind_of, rejudged
from gimbal_hil.knowledge.discrepancy.judgement.intervals import parameter_intervals
from gimbal_hil.knowledge.identification import Determination, Estimate, Log, numbers_of_motion, stretches_of_table
from sim_backend.effects import CATALOGUE

Intervals = Mapping[str, tuple[float, float]]
#: numbers of the model that both methods know
_BOTH_KNOW = ("friction.", "body.own_")


def with_identification(inquiry: Inquiry, decision: Decision) -> Decision:
    """The decision without names on an axis of which a named number is denied, and with what is identified."""
    denials: dict[str, tuple[Denial, ...]] = {}
    known: dict[tuple[str, str], tuple[float, float]] = {}
    for axis in {one.standing.label[1] for one in decision.told if one.status is Status.NAMED}:
        mine = [one for one in decision.told if one.standing.label[1] == axis and _is_known_to_both(one)]
        identified = _identified(inquiry, axis) if mine else {}
        denials[axis] = tuple(found for one in mine for found in _denials(inquiry, decision, one, identified))
        known |= {(axis, name): (one.interval.low, one.interval.high) for name, one in identified.items()}
    decision = replace(decision, identified=known)
    if not any(denials.values()):
        return decision
    told = tuple(
        rejudged(inquiry.policy, replace(one, denials=denials.get(one.standing.label[1], ())), one.close)
        for one in decision.told
    )
    return replace(decision, told=told, kind=kind_of(told))


def intervals_of_both(decision: Decision, label: tuple[str, str], mine: Intervals) -> Intervals:
    """Intervals of a cause's parameters that hold those of the other method too, where the two overlap: what one takes
    for certain (that nobody smoothed the columns, say) the other may doubt.
    """
    effect, axis = label
    found = dict(mine)
    for parameter in CATALOGUE[effect].parameters:
        theirs = decision.identified.get((axis, _there(parameter.path)))
        if theirs is not None and parameter.name in mine:
            low, high = mine[parameter.name]
            if theirs[0] <= high and theirs[1] >= low:
                found[parameter.name] = min(low, theirs[0]), max(high, theirs[1])
    return found


def _is_known_to_both(one: Told) -> bool:
    of = CATALOGUE[one.standing.label[0]].parameters
    return one.status is Status.NAMED and any(_there(parameter.path) for parameter in of)


def _there(path: str | None) -> str:
    """The name by which a number of the model is identified; empty where it is not."""
    return path.rpartition(".")[2].removeprefix("own_") if path and path.startswith(_BOTH_KNOW) else ""


def _identified(inquiry: Inquiry, axis: str) -> Mapping[str, Estimate]:
    """What motion in the searched logs says of an axis, by name, as far as it is identified."""
    logs = [Log(table.source, table, {axis: stretches_of_table(table, axis)}) for table in inquiry.logs]
    try:
        found = numbers_of_motion(logs, inquiry.twin.model, axis)
    except BadInputError:
        # too short, or without a motion that a regression could use: it says nothing
        return {}
    return {one.name: one for one in found if one.verdict is Determination.IDENTIFIED}


def _denials(inquiry: Inquiry, decision: Decision, one: Told, identified: Mapping[str, Estimate]) -> list[Denial]:
    """Numbers of one cause that were identified nearer to what the model states, both intervals excluding the other."""
    found, index = [], one.standing.entries[0]
    effect = CATALOGUE[one.standing.label[0]]
    values = values_of(inquiry.twin.model, inquiry.twin, decision.state.hypothesis, index)
    intervals = parameter_intervals(inquiry, decision.state, index)
    for parameter in effect.parameters:
        said = identified.get(_there(parameter.path))
        value, stated = values.get(parameter.name, (0.0, None))
        if said is None or stated is None:
            continue
        low, high = intervals[parameter.name]
        apart = said.interval.low > high or said.interval.high < low
        if apart and abs(said.value - stated) < abs(said.value - value):
            ends = said.interval
            found.append(
                Denial(one.standing.label, parameter.name, stated, value, said.value, ends.low, ends.high, said.unit)
            )
    return found
