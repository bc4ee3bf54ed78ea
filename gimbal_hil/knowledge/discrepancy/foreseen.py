"""What a run could show, before any data: read from a rehearsal of it on the model alone.

A cause shows from the size at which its trace, less everything that known numbers can do within their uncertainty,
makes a gap. Two causes are told apart from the size at which one leaves enough of the other's trace.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.hypotheses import Weighing, present_in
from gimbal_hil.knowledge.discrepancy.inquiry import (
    Inquiry,
    Policy,
    as_stated,
    effect_names,
    prepared,
    recalibrated,
    weighing_of,
)
from gimbal_hil.knowledge.discrepancy.judgement import ORDER, Shows, Trace, channel_name, traces
from gimbal_hil.knowledge.discrepancy.verdict import why_not_testable
from gimbal_hil.knowledge.executor import open_executor
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel

#: at more times their smallest size two causes count as never told apart
_TOLD_AT_NONE = 1e3
#: standard errors by which two explanations differ when one leaves squares of so many times those of one row
_SQUARES_OF_SURE = 4.0


@dataclass(frozen=True)
class Confused:
    """Two causes that this run tells apart only from so many times their smallest size; None: at no size."""

    one: tuple[str, str]
    other: tuple[str, str]
    from_times: float | None


@dataclass(frozen=True)
class Foreseen:
    """Everything that can be said of a run before it is made."""

    band_hz: float
    #: (channel, rms noise, unit)
    floors: tuple[tuple[str, float, str], ...]
    shows: tuple[Shows, ...]
    #: (effect, axis, reason)
    hidden: tuple[tuple[str, str, str], ...]
    confused: tuple[Confused, ...]


def foreseen(model: AntennaModel, table: SignalsTable, policy: Policy | None = None) -> Foreseen:
    """What a run with this log could show if the model were the truth: `table` is a rehearsal's.

    BadInputError for a log that is too short for the scored band.
    """
    policy = policy or Policy()
    with open_executor(1, None) as executor:
        names = effect_names((), ())
        inquiry, noise = prepared(model, (table,), (table,), None, names, policy, executor, lambda text: None)
        inquiry = replace(inquiry, inexact=noise.processing / inquiry.floor)
        inquiry, null = recalibrated(inquiry, as_stated(inquiry))
    weighing = weighing_of(inquiry, null)
    found = traces(inquiry, null)
    shown = {(trace.shows.name, trace.shows.axis) for trace in found}
    return Foreseen(
        float(inquiry.twin.records[0].bands.scored_hz),
        tuple(
            (channel_name(inquiry, j), float(inquiry.floor[j]), inquiry.twin.channels[j].unit(model.is_linear))
            for j in range(len(inquiry.floor))
        ),
        tuple(trace.shows for trace in found),
        tuple(_hidden(inquiry, shown)),
        tuple(_confused(inquiry, found, weighing, len(null.fitted))),
    )


def _confused(inquiry: Inquiry, traces: list[Trace], weighing: Weighing, rows: int) -> list[Confused]:
    """Pairs that the smallest sizes do not tell apart, those that need most first."""
    policy = inquiry.policy
    independent = rows * len(inquiry.twin.channels) / weighing.spread**2
    needed = max(_SQUARES_OF_SURE * policy.sure**2, policy.same * independent)
    found = []
    for one, other in combinations(traces, 2):
        names = (one.shows.name, one.shows.axis), (other.shows.name, other.shows.axis)
        # what contains a cause and does not pay for its further numbers is no rival of it
        left = min(_left_beside(*pair) for pair in ((one, other), (other, one)) if not _contains(pair[1], pair[0]))
        same = (CATALOGUE[names[0][0]].same_by_command, names[0][1]) == names[1]
        times = math.sqrt(needed / left) if left > 0.0 and not same else math.inf
        if times > 1.0:
            found.append(Confused(*names, times if times < _TOLD_AT_NONE else None))
    return sorted(found, key=lambda pair: -(pair.from_times or math.inf))


def _contains(fuller: Trace, plainer: Trace) -> bool:
    own = CATALOGUE[fuller.shows.name].plainer
    return own is not None and (own.name, fuller.shows.axis) == (plainer.shows.name, plainer.shows.axis)


def _left_beside(one: Trace, other: Trace) -> float:
    """Weighed squares of one leading trace that another cause cannot take."""
    lead = one.columns[:, 0]
    basis, _ = np.linalg.qr(other.columns)
    return max(0.0, float(lead @ lead - np.sum((basis.T @ lead) ** 2)) - 1e-9 * float(lead @ lead))


def _hidden(inquiry: Inquiry, shown: set[tuple[str, str]]) -> list[tuple[str, str, str]]:
    """Effects that the run would not show, with the reason."""
    model, records = inquiry.twin.model, inquiry.twin.records
    found = []
    for axis in model.axes:
        present = present_in(model, axis, records)
        for name, effect in CATALOGUE.items():
            possible = not (effect.rotary_only and model.is_linear) and (
                len(model.axes) > 1 or not effect.two_axis_only
            )
            if possible and (name, axis) not in shown:
                found.append((name, axis, why_not_testable(name, present)))
    return found


__all__ = ["ORDER", "Confused", "Foreseen", "Shows", "foreseen"]
