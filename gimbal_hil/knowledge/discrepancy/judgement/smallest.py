"""From which size on a cause shows: the size at which it leaves what a verdict takes for a gap, once known numbers have
taken of it what they can within their uncertainty. The same for logs that are there as for a rehearsal.
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
    bounds_of,
    command_residual,
    prior_weights,
    values_of,
)
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State, rms, weighing_of
from gimbal_hil.knowledge.discrepancy.judgement.gap import is_a_gap
from gimbal_hil.knowledge.discrepancy.judgement.wander import wander_of
from gimbal_hil.knowledge.discrepancy.search import basis_of, beside, responses, row_weights
from gimbal_hil.knowledge.discrepancy.twin import Floats
from sim_backend.effects import CATALOGUE, Start, ripple_start

#: a ripple is foreseen at so many periods a turn, or along the travel of a linear axis
ORDER = 12.0
#: a trace is taken as growing with its cause up to so many times the size that was tried, and looked for down to that
#: over the span; so many halvings leave 5 % of it open
_FARTHEST, _SPAN, _HALVINGS = 30.0, 1e5, 8
#: of a normal matrix: rounding
_ROUNDING = 1e-12
#: numbers find their ends in a few turns
_TURNS = 20


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
    #: every parameter as it was imagined: its name, where it is without the cause, and where it is at this size
    values: tuple[tuple[str, float, float], ...] = ()

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
    return tuple(one.shows for one in traces(inquiry, null))


def traces(inquiry: Inquiry, null: State) -> list[Trace]:
    """The trace of every family at the start that shows it at the smallest size; none of those that no start shows."""
    weighing = weighing_of(inquiry, null)
    whole, traced = _Judged(inquiry, null, weighing), []
    for family in inquiry.families:
        bare, _ = without_own(inquiry, null, family)
        tried = (_trace(inquiry, bare, whole, weighing, family, start) for start in _starts(inquiry, family))
        found = [trace for trace in tried if trace is not None]
        traced += [min(found, key=lambda trace: trace.shows.size)] if found else []
    return traced


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
    inquiry: Inquiry, bare: Fit, whole: _Judged, weighing: Weighing, family: Family, start: Start
) -> Trace | None:
    """What a start does, and from which size on it shows; None where it does not within the catalogue's bounds."""
    columns = responses(inquiry.twin, bare, inquiry.floor, family, start)
    if columns is None:
        return None
    basis, _ = basis_of(bare, weighing)
    per_row = row_weights(bare, weighing)
    left = beside(columns * per_row[:, None], basis)[: len(columns)]
    reach = np.sqrt(
        np.mean((left / per_row[:, None]).reshape(-1, len(inquiry.twin.channels), left.shape[1]) ** 2, axis=0)
    )
    channel, lead = np.unravel_index(int(np.argmax(reach)), reach.shape)
    as_tried = start.probes[lead] == start.base
    times = whole.shows_from(columns[:, lead], 1.0 if as_tried else _FARTHEST)
    if times is None:
        return None
    times = 1.0 if as_tried else times
    shows = _smallest(inquiry, bare, family, start, int(lead), times, channel_name(inquiry, int(channel)), as_tried)
    order = [int(lead), *(j for j in range(columns.shape[1]) if j != lead)]
    return None if shows is None else Trace(shows, times * left[:, order])


class _Judged:
    """The verdict's own question, asked of an effect that is only imagined: do known numbers, each no further than what
    is said of it lets it go, leave a gap of it beside the noise that is there?
    """

    def __init__(self, inquiry: Inquiry, null: State, weighing: Weighing) -> None:
        self.inquiry, self.null, fit = inquiry, null, null.fit
        self.wander = wander_of(inquiry.twin, null.hypothesis, inquiry.floor)
        self.weights = row_weights(fit, weighing) ** 2
        x, prior = fit.hypothesis.vector(), prior_weights(fit.hypothesis) ** 2
        low, high = bounds_of(fit.hypothesis, 1.0)
        # from where they stand; those at their bound go one way only
        self.low, self.high = np.minimum(low - x, 0.0), np.maximum(high - x, 0.0)
        normal = fit.jacobian.T @ (fit.jacobian * self.weights[:, None]) + np.diag(prior)
        self.normal = normal + np.diag(_ROUNDING * np.diag(normal))
        # beside what is missing already another effect shows as it would beside noise
        size = rms(fit.residual)
        is_noise = not is_a_gap(inquiry, size, size, lambda: self.wander.left(fit.residual))
        self.noise = (fit.residual / (1.0 if is_noise else np.maximum(size, 1.0))).ravel()
        self.pull = fit.jacobian.T @ (self.weights * self.noise) + prior * x

    def shows_from(self, response: Floats, most: float) -> float | None:
        """From how many times a response, (rows * channels,) in floors, on it makes a gap; None where not at `most`."""
        per_time = self.null.fit.jacobian.T @ (self.weights * response)
        if not self._shows(response, per_time, most):
            return None
        low, high = math.log(most / _SPAN), math.log(most)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self._shows(response, per_time, math.exp(middle)) else (middle, high)
        return math.exp(high)

    def _shows(self, response: Floats, per_time: Floats, times: float) -> bool:
        fit = self.null.fit
        rows = self.noise + times * response
        left = (rows + fit.jacobian @ self._taken(self.pull + times * per_time)).reshape(fit.residual.shape)
        size = rms(left)
        return is_a_gap(self.inquiry, size, size, lambda: self.wander.left(left))

    def _taken(self, pull: Floats) -> Floats:
        """How far numbers go against a pull, (numbers,), each within its room: those that would leave it are held at
        its end, and let go where they would come back by themselves.
        """
        x, free = np.zeros(len(pull)), np.ones(len(pull), dtype=bool)
        for _ in range(_TURNS):
            against = pull + self.normal[:, ~free] @ x[~free]
            x[free] = np.linalg.solve(self.normal[np.ix_(free, free)], -against[free])
            outside = free & ((x < self.low) | (x > self.high))
            x = np.clip(x, self.low, self.high)
            slope = pull + self.normal @ x
            back = ~free & (((x <= self.low) & (slope < 0.0)) | ((x >= self.high) & (slope > 0.0)))
            if not np.any(outside | back):
                break
            free = (free & ~outside) | back
        return x


def _smallest(
    inquiry: Inquiry,
    bare: Fit,
    family: Family,
    start: Start,
    lead: int,
    times: float,
    channel: str,
    as_tried: bool,
) -> Shows | None:
    """The size in the catalogue's words."""
    model, twin = inquiry.twin.model, inquiry.twin
    base = np.zeros(len(start.base)) if as_tried else np.array(start.base)
    x = base + times * (np.array(start.probes[lead]) - base)
    if any(not knob.low <= value <= knob.high for knob, value in zip(family.knobs, x, strict=True)):
        return None

    def at(coordinates: Floats) -> dict[str, tuple[float, float | None]]:
        hypothesis = bare.hypothesis.plus(Cause(family, tuple(float(value) for value in coordinates)))
        return values_of(model, twin, hypothesis, len(hypothesis.causes) - 1)

    values, without = at(x), at(base)
    periodic = {parameter.name for parameter in CATALOGUE[family.effect].parameters if parameter.periodic}
    imagined = tuple((n, value if n in periodic else without[n][0], value) for n, (value, _) in values.items())
    moves = np.array(start.probes[lead]) != np.array(start.base)
    # what the probe moves tells the size; what it holds, such as a frequency, tells only where
    for knob in (knob for knob, is_moved in zip(family.knobs, moves, strict=True) if is_moved or as_tried):
        for name in knob.parameters:
            value, nominal = values[name]
            parameter = next(p for p in CATALOGUE[family.effect].parameters if p.name == name)
            size = abs(value - (parameter.neutral if nominal is None else nominal))
            if size == 0.0:
                continue
            unit = parameter.linear_unit if model.is_linear and parameter.linear_unit else parameter.unit
            return Shows(family.effect, family.axis, channel, name, size, unit, nominal, as_tried, imagined)
    return None


def channel_name(inquiry: Inquiry, index: int) -> str:
    channel = inquiry.twin.channels[index]
    return f"{channel.signal} of {channel.axis}"


__all__ = ["ORDER", "Shows", "Trace", "channel_name", "smallest_sizes", "traces", "without_own"]
