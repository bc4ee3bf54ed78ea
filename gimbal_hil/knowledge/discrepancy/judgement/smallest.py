"""From which size on a cause shows: the size at which its trace, less everything that known numbers can do within
their uncertainty, makes a gap. The same for logs that are there as for a rehearsal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import (
    Cause,
    Family,
    Fit,
    KnownNumber,
    Weighing,
    command_residual,
    values_of,
)
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State, weighing_of
from gimbal_hil.knowledge.discrepancy.search import basis_of, responses, row_weights
from gimbal_hil.knowledge.discrepancy.twin import Floats
from sim_backend.effects import CATALOGUE, Start, ripple_start

#: a ripple is foreseen at so many periods a turn, or along the travel of a linear axis
ORDER = 12.0
#: a trace is taken as growing with its cause up to so many times the size that was tried
_FARTHEST = 30.0


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

    @property
    def relative(self) -> float | None:
        """The size as a share of the number that the model has; a gain is a share itself."""
        if self.unit == "1" and not self.nominal and CATALOGUE[self.name].is_number:
            return self.size
        return self.size / abs(self.nominal) if self.nominal else None


@dataclass(frozen=True)
class Trace:
    """What a cause does to the residual beside known numbers: weighed columns, of which the first is its leading one,
    scaled to the smallest size that shows.
    """

    shows: Shows
    columns: Floats


def smallest_sizes(inquiry: Inquiry, null: State) -> tuple[Shows, ...]:
    """Every cause that these logs would show, from which size on."""
    weighing = weighing_of(inquiry, null)
    return tuple(one.shows for family in inquiry.families for one in traces(inquiry, null, weighing, family))


def traces(inquiry: Inquiry, null: State, weighing: Weighing, family: Family) -> list[Trace]:
    """The trace of a family at the start that shows it at the smallest size; none where no start does."""
    bare, own = without_own(inquiry, null, family)
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


def without_own(inquiry: Inquiry, null: State, family: Family) -> tuple[Fit, tuple[KnownNumber, ...]]:
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
    # where its own numbers had moved, they stand at what the model says again
    residual = command_residual(inquiry.twin, shorter, inquiry.floor)
    return replace(null.fit, hypothesis=shorter, residual=residual, jacobian=null.fit.jacobian[:, kept]), own


def _trace(
    inquiry: Inquiry, bare: Fit, own: tuple[KnownNumber, ...], weighing: Weighing, family: Family, start: Start
) -> Trace | None:
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
    shows = _smallest(
        inquiry, bare, own, family, start, int(lead), times, channel_name(inquiry, int(channel)), as_tried
    )
    order = [int(lead), *(j for j in range(columns.shape[1]) if j != lead)]
    return None if shows is None else Trace(shows, times * left[:, order])


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


def channel_name(inquiry: Inquiry, index: int) -> str:
    channel = inquiry.twin.channels[index]
    return f"{channel.signal} of {channel.axis}"


__all__ = ["ORDER", "Shows", "Trace", "channel_name", "smallest_sizes", "traces", "without_own"]
