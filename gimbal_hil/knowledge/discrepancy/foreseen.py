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
from gimbal_hil.knowledge.discrepancy.hypotheses import Cause, Family, Fit, KnownNumber, Weighing, present_in, values_of
from gimbal_hil.knowledge.discrepancy.inquiry import (
    Inquiry,
    Policy,
    State,
    as_stated,
    effect_names,
    prepared,
    recalibrated,
    weighing_of,
)
from gimbal_hil.knowledge.discrepancy.search import basis_of, responses, row_weights
from gimbal_hil.knowledge.discrepancy.twin import Floats
from gimbal_hil.knowledge.discrepancy.verdict import why_not_testable
from gimbal_hil.knowledge.executor import open_executor
from sim_backend.effects import CATALOGUE, Start, ripple_start
from sim_backend.model import AntennaModel

#: a ripple is foreseen at so many periods a turn, or along the travel of a linear axis
ORDER = 12.0
#: a trace is taken as growing with its cause up to so many times the size that was tried
_FARTHEST = 30.0
#: at more times their smallest size two causes count as never told apart
_TOLD_AT_NONE = 1e3
#: standard errors by which two explanations differ when one leaves squares of so many times those of one row
_SQUARES_OF_SURE = 4.0


@dataclass(frozen=True)
class Shows:
    """A cause that the run would show, from this size on: the change of a parameter, in its unit."""

    name: str
    axis: str
    channel: str
    parameter: str
    size: float
    unit: str
    #: the number as the model has it, where it has one
    nominal: float | None
    #: it was tried at this size only, from which a larger one cannot be told
    as_tried: bool = False


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


@dataclass(frozen=True)
class _Trace:
    """What a cause does to the residual beside known numbers: weighed columns, of which the first is its leading one,
    scaled to the smallest size that shows.
    """

    shows: Shows
    columns: Floats


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
    traces = [trace for family in inquiry.families for trace in _traces(inquiry, null, weighing, family)]
    shown = {(trace.shows.name, trace.shows.axis) for trace in traces}
    return Foreseen(
        float(inquiry.twin.records[0].bands.scored_hz),
        tuple(
            (_channel(inquiry, j), float(inquiry.floor[j]), inquiry.twin.channels[j].unit(model.is_linear))
            for j in range(len(inquiry.floor))
        ),
        tuple(trace.shows for trace in traces),
        tuple(_hidden(inquiry, shown)),
        tuple(_confused(inquiry, traces, weighing, len(null.fitted))),
    )


def _traces(inquiry: Inquiry, null: State, weighing: Weighing, family: Family) -> list[_Trace]:
    """The trace of a family at the start that shows it at the smallest size; none where no start does."""
    bare, own = _without_own(inquiry, null, family)
    found = []
    for start in _starts(inquiry, family):
        trace = _trace(inquiry, bare, own, weighing, family, start)
        if trace is not None:
            found.append(trace)
    return [min(found, key=lambda trace: trace.shows.size)] if found else []


def _starts(inquiry: Inquiry, family: Family) -> tuple[Start, ...]:
    if family.ripple is None:
        return family.starts
    model, travel = inquiry.twin.model, 2.0 * math.pi
    if model.is_linear:
        i = model.axes.index(family.axis)
        travel = max(float(np.ptp(np.concatenate([r.motion[:, i] for r in inquiry.twin.records]))), 1e-9)
    return (ripple_start(ORDER * 2.0 * math.pi / travel),)


def _without_own(inquiry: Inquiry, null: State, family: Family) -> tuple[Fit, tuple[KnownNumber, ...]]:
    """The null fit in which the numbers that a cause moves do not float, and those numbers."""
    model, hypothesis = inquiry.twin.model, null.hypothesis
    paths = {model.number_path(family.axis, p.path) for p in CATALOGUE[family.effect].parameters if p.path}
    mine = [known.axis == family.axis and known.path in paths for known in hypothesis.floating]
    if not any(mine):
        return null.fit, ()
    first = len(hypothesis.vector()) - len(hypothesis.y)
    others = [j for j, own in enumerate(mine) if not own]
    kept = [*range(first), *(first + j for j in others)]
    shorter = replace(
        hypothesis,
        floating=tuple(hypothesis.floating[j] for j in others),
        y=tuple(hypothesis.y[j] for j in others),
    )
    own = tuple(known for known, is_own in zip(hypothesis.floating, mine, strict=True) if is_own)
    return replace(null.fit, hypothesis=shorter, jacobian=null.fit.jacobian[:, kept]), own


def _trace(
    inquiry: Inquiry, bare: Fit, own: tuple[KnownNumber, ...], weighing: Weighing, family: Family, start: Start
) -> _Trace | None:
    """What a start does, and from which size on it shows; None where it does not within the catalogue's bounds."""
    columns = responses(inquiry.twin, bare, inquiry.floor, family, start)
    if columns is None:
        return None
    basis, _ = basis_of(bare, weighing)
    per_row = row_weights(bare, weighing)
    longer = np.zeros((len(basis), columns.shape[1]))
    longer[: len(columns)] = columns * per_row[:, None]
    longer -= basis @ (basis.T @ longer)
    left = longer[: len(columns)]
    floors = (left / per_row[:, None]).reshape(-1, len(inquiry.twin.channels), columns.shape[1])
    rms = np.sqrt(np.mean(floors**2, axis=0))
    # what is missing makes a gap beside the noise
    gap = np.sqrt((inquiry.policy.least_gap**2 - 1.0) * (1.0 + np.broadcast_to(inquiry.inexact, rms.shape[:1]) ** 2))
    reach = rms / gap[:, None]
    channel, lead = np.unravel_index(int(np.argmax(reach)), reach.shape)
    if reach[channel, lead] <= 0.0:
        return None
    times = 1.0 / float(reach[channel, lead])
    as_tried = start.probes[lead] == start.base
    if (as_tried and times > 1.0) or times > _FARTHEST:
        return None
    times = 1.0 if as_tried else times
    shows = _smallest(inquiry, bare, own, family, start, int(lead), times, _channel(inquiry, int(channel)), as_tried)
    order = [int(lead), *(j for j in range(columns.shape[1]) if j != lead)]
    return None if shows is None else _Trace(shows, times * left[:, order])


def _smallest(
    inquiry: Inquiry,
    bare: Fit,
    own: tuple[KnownNumber, ...],
    family: Family,
    start: Start,
    lead: int,
    times: float,
    channel: str,
    as_tried: bool,
) -> Shows | None:
    """The size in the catalogue's words; a known number has to leave its uncertainty first."""
    model, twin = inquiry.twin.model, inquiry.twin
    base = np.zeros(len(start.base)) if as_tried else np.array(start.base)
    x = base + times * (np.array(start.probes[lead]) - base)
    if any(not knob.low <= value <= knob.high for knob, value in zip(family.knobs, x, strict=True)):
        return None
    hypothesis = bare.hypothesis.plus(Cause(family, tuple(float(value) for value in x)))
    values = values_of(model, twin, hypothesis, len(hypothesis.causes) - 1)
    moves = np.array(start.probes[lead]) != np.array(start.base)
    # what the probe moves tells the size; what it holds, such as a frequency, tells only where
    for knob in (knob for knob, is_moved in zip(family.knobs, moves, strict=True) if is_moved or as_tried):
        for name in knob.parameters:
            value, nominal = values[name]
            parameter = next(p for p in CATALOGUE[family.effect].parameters if p.name == name)
            size = abs(value - (parameter.neutral if nominal is None else nominal))
            if size == 0.0:
                continue
            if own and nominal is not None:
                path = model.number_path(family.axis, parameter.path or "")
                size += sum(abs(k.moved(nominal, k.trust) - nominal) for k in own if k.path == path)
            unit = parameter.linear_unit if model.is_linear and parameter.linear_unit else parameter.unit
            return Shows(family.effect, family.axis, channel, name, size, unit, nominal, as_tried)
    return None


def _confused(inquiry: Inquiry, traces: list[_Trace], weighing: Weighing, rows: int) -> list[Confused]:
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


def _contains(fuller: _Trace, plainer: _Trace) -> bool:
    own = CATALOGUE[fuller.shows.name].plainer
    return own is not None and (own.name, fuller.shows.axis) == (plainer.shows.name, plainer.shows.axis)


def _left_beside(one: _Trace, other: _Trace) -> float:
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


def _channel(inquiry: Inquiry, index: int) -> str:
    channel = inquiry.twin.channels[index]
    return f"{channel.signal} of {channel.axis}"


__all__ = ["ORDER", "Confused", "Foreseen", "Shows", "foreseen"]
