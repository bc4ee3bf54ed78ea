"""From which size on a cause shows: the size at which it leaves what a verdict takes for a gap, in the fitted logs and
in the hold-out, once known numbers have taken of it what they can within their uncertainty. The same for logs that are
there as for a rehearsal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import (
    STEP,
    Cause,
    Family,
    Fit,
    Hypothesis,
    KnownNumber,
    Weighing,
    bounds_of,
    command_residual,
    prior_weights,
    values_of,
)
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State, rms, weighing_of
from gimbal_hil.knowledge.discrepancy.judgement.gap import is_a_gap
from gimbal_hil.knowledge.discrepancy.judgement.wander import wander_beside
from gimbal_hil.knowledge.discrepancy.search import basis_of, beside, responses, row_weights
from gimbal_hil.knowledge.discrepancy.twin import Floats
from sim_backend.effects import CATALOGUE, Move, Start, ripple_start
from sim_backend.model import MOMENTS, AntennaModel

#: a ripple is foreseen at so many periods a turn, or along the travel of a linear axis
ORDER = 12.0
#: a trace is taken as growing with its cause up to so many times the size that was tried, and looked for down to that
#: over the span; so many halvings leave 5 % of it open
_FARTHEST, _SPAN, _HALVINGS = 30.0, 1e5, 8
#: what a factor does grows in line up to about this logarithm of it
_LINEAR = 1.0
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
    whole, every, traced = _Judged(inquiry, null, weighing), basis_of(null.fit, weighing)[0], []
    for family in inquiry.families:
        bare, own = without_own(inquiry, null, family)
        basis = every if bare is null.fit else basis_of(bare, weighing)[0]
        tried = (
            _trace(inquiry, bare, basis, own, whole, weighing, family, start) for start in _starts(inquiry, family)
        )
        found = [trace for trace in tried if trace is not None]
        traced += [min(found, key=lambda trace: trace.shows.size)] if found else []
    return traced


def _starts(inquiry: Inquiry, family: Family) -> tuple[Start, ...]:
    """Starts at which a cause of size nothing does nothing: a number of the model that begins elsewhere, such as the
    speed at which a bump of friction fades, is off already.
    """
    if CATALOGUE[family.effect].is_number:
        return tuple(start for start in family.starts if not any(start.base))
    if family.ripple is None:
        return family.starts
    model, travel = inquiry.twin.model, 2.0 * math.pi
    if model.is_linear:
        i = model.axes.index(family.axis)
        travel = max(float(np.ptp(np.concatenate([r.motion[:, i] for r in inquiry.twin.records]))), 1e-9)
    return (ripple_start(ORDER * 2.0 * math.pi / travel),)


def slopes_of_hold_out(inquiry: Inquiry, null: State) -> Floats:
    """What every known number of a state does to the hold-out, (numbers, rows, channels), in floors a unit."""
    twin, floor, held = inquiry.holdout, inquiry.floor, null.held
    rows = inquiry.in_order(null)
    found = np.zeros((len(held.y), *rows.shape))
    for j in range(len(held.y)):
        y = tuple(at + STEP * (i == j) for i, at in enumerate(held.y))
        found[j] = (command_residual(twin, replace(held, y=y), floor) - rows) / STEP
    return found


def without_own(inquiry: Inquiry, null: State, family: Family) -> tuple[Fit, tuple[KnownNumber, ...]]:
    """The null fit in which the numbers that a cause moves do not float, and those numbers."""
    hypothesis, its = null.hypothesis, _own_places(inquiry.twin.model, family)
    mine = [(known.axis, known.path) in its for known in hypothesis.floating]
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


def _own_places(model: AntennaModel, family: Family) -> set[tuple[str, str]]:
    """Numbers (axis, path) that an effect moves. An axis turns what it carries too, and no motion tells whose moment of
    inertia it is: those that turn with it are the same number.
    """
    axis, paths = family.axis, [p.path for p in CATALOGUE[family.effect].parameters if p.path]
    its = {(axis, model.number_path(axis, path)) for path in paths}
    if "body.own_inertia" in paths:
        for carried in model.axes[model.axes.index(axis) + 1 :]:
            about_others = [path for path in MOMENTS if path != model.own_inertia_path(carried)]
            its |= {(carried, path) for path in about_others}
    return its


def _trace(
    inquiry: Inquiry,
    bare: Fit,
    basis: Floats,
    own: tuple[KnownNumber, ...],
    whole: _Judged,
    weighing: Weighing,
    family: Family,
    start: Start,
) -> Trace | None:
    """What a start does, and from which size on it shows; None where it does not within the catalogue's bounds."""
    columns = responses(inquiry.twin, bare.hypothesis, bare.residual, inquiry.floor, family, start)
    if columns is None:
        return None
    per_row = row_weights(bare, weighing)
    left = beside(columns * per_row[:, None], basis)[: len(columns)]
    reach = np.sqrt(
        np.mean((left / per_row[:, None]).reshape(-1, len(inquiry.twin.channels), left.shape[1]) ** 2, axis=0)
    )
    for channel, lead in zip(*np.unravel_index(np.argsort(-reach, axis=None), reach.shape), strict=True):
        as_tried = start.probes[lead] == start.base
        there = replace(start, probes=(start.probes[lead],))
        in_hold_out = responses(inquiry.holdout, *whole.held_beside(own), inquiry.floor, family, there)
        if in_hold_out is None:
            continue
        # a number of the model may be too small as well as too large
        ways = (1.0, -1.0) if CATALOGUE[family.effect].is_number and not as_tried else (1.0,)
        times = whole.shows_from(columns[:, lead], in_hold_out[:, 0], 1.0 if as_tried else _FARTHEST, ways)
        if times is None:
            continue
        times = 1.0 if as_tried else times
        shows = _smallest(inquiry, bare, family, start, int(lead), times, channel_name(inquiry, int(channel)), as_tried)
        if shows is not None:
            order = [int(lead), *(j for j in range(columns.shape[1]) if j != lead)]
            return Trace(shows, times * left[:, order])
    return None


class _Judged:
    """The verdict's own question, asked of an effect that is only imagined beside a model that is right: do known
    numbers, each no further than what is said of it lets it go, leave a gap of it beside the noise that is there?
    """

    def __init__(self, inquiry: Inquiry, null: State, weighing: Weighing) -> None:
        self.inquiry, self.null, fit = inquiry, null, null.fit
        self.wander = wander_beside(inquiry, null)
        self.slopes = slopes_of_hold_out(inquiry, null)
        self.weights = row_weights(fit, weighing) ** 2
        # from what the model says: where they stand now they may have made up for an error already
        self.low, self.high = bounds_of(fit.hypothesis, 1.0)
        prior = np.diag(prior_weights(fit.hypothesis) ** 2)
        normal = fit.jacobian.T @ (fit.jacobian * self.weights[:, None]) + prior
        self.normal = normal + np.diag(_ROUNDING * np.diag(normal))
        # what is more than a floor is no noise, and helps no other effect over the limit
        both = (fit.residual, inquiry.in_order(null))
        self.noise, self.noise_held = (rows / np.maximum(rms(rows), 1.0) for rows in both)
        self.pull = fit.jacobian.T @ (self.weights * self.noise.ravel())

    def held_beside(self, own: tuple[KnownNumber, ...]) -> tuple[Hypothesis, Floats]:
        """The hypothesis on the hold-out in which some numbers do not float, and what it leaves there."""
        held = self.null.held
        if not own:
            return held, self.inquiry.in_order(self.null)
        others = [(known, at) for known, at in zip(held.floating, held.y, strict=True) if known not in own]
        shorter = replace(held, floating=tuple(known for known, _ in others), y=tuple(at for _, at in others))
        return shorter, command_residual(self.inquiry.holdout, shorter, self.inquiry.floor)

    def shows_from(self, response: Floats, in_hold_out: Floats, most: float, ways: tuple[float, ...]) -> float | None:
        """From how many times a response, (rows * channels,) in floors, on it makes a gap in each of these ways; None
        where not at `most`.
        """
        per_time = self.null.fit.jacobian.T @ (self.weights * response)

        def in_one(times: float) -> bool:
            taken = self._taken(self.pull + times * per_time)
            moved = (times * response + self.null.fit.jacobian @ taken).reshape(self.noise.shape)
            known = np.tensordot(taken[len(taken) - len(self.slopes) :], self.slopes, 1)
            moved_held = times * in_hold_out.reshape(self.noise_held.shape) + known
            rows, held = self.noise + moved, self.noise_held + moved_held
            return is_a_gap(self.inquiry, rows, held, lambda: self._beside_wander(rows, held))

        def shows(times: float) -> bool:
            return all(in_one(way * times) for way in ways)

        if not shows(most):
            return None
        low, high = math.log(most / _SPAN), math.log(most)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if shows(math.exp(middle)) else (middle, high)
        return math.exp(high)

    def _beside_wander(self, rows: Floats, held: Floats) -> Floats:
        return np.max([one.left(part) for one, part in zip(self.wander, (rows, held), strict=True)], axis=0)

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
    moved = (abs(to - at) for knob, to, at in zip(family.knobs, x, base, strict=True) if knob.move is Move.FACTOR)
    if max(moved, default=0.0) > _LINEAR:
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
