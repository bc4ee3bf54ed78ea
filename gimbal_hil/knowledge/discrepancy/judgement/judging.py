"""Judges an explanation: the loss without each cause, its possible replacements, and whether its shape leaves a
predictable residual.

Every cause is judged by difference: with and without it, everything else refitted, on all data and on the half of the
hold-out that selected nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import at_bound
from gimbal_hil.knowledge.discrepancy.inquiry import (
    MOST_ENTRIES,
    PARTS,
    Inquiry,
    State,
    gain_on,
    mean_squares,
    refitted,
    rms,
    squares_of,
    surely_less,
)
from gimbal_hil.knowledge.discrepancy.judgement.exhaustion import Predictable, predictable
from gimbal_hil.knowledge.discrepancy.judgement.gap import channels_with_a_gap
from gimbal_hil.knowledge.discrepancy.judgement.intervals import (
    parameter_intervals,
    strength_error,
    strengths_to_their_end,
)
from gimbal_hil.knowledge.discrepancy.judgement.rivals import Rival, rivals_of
from gimbal_hil.knowledge.discrepancy.judgement.steadiness import unevenness
from gimbal_hil.knowledge.discrepancy.search import Path, control_share, curve_does_as_well, orders_make_a_series
from gimbal_hil.knowledge.discrepancy.twin import Floats
from gimbal_hil.knowledge.estimation import Paired
from sim_backend.effects import CATALOGUE, Ripple, Variable

EVERYTHING = frozenset(Variable)
#: a change of the hold-out below this share of what is left there is no trace
_NO_TRACE = 0.1
#: a variable predicts as much as another from this share of it on, and nearly as much as all together
_AS_MUCH, _NEARLY_ALL = 0.95, 0.7


@dataclass(frozen=True)
class Standing:
    """How a cause stands: entries of the hypothesis that are it, and the evidence for it."""

    entries: tuple[int, ...]
    label: tuple[str, str]
    #: what is lost without it, on the rows that selected nothing, and surely over all three parts together
    untouched: Paired
    sure: float
    #: share that it takes of what is left without it on its own channel, all data, and what its negative control takes
    share: float
    control: float
    rivals: tuple[Rival, ...]
    #: of its own channel, predicted from the variables that it acts through
    exhausted: Predictable
    at_bound: tuple[str, ...]
    silent: bool
    channel: int
    #: squared floors a row, over all channels, that it takes of the hold-out
    taken: float
    #: the same of each channel, of all data
    takes: Floats
    #: what it takes is of a channel on which the model leaves a gap, and still does beside the other causes: elsewhere
    #: there is nothing to explain
    explains: bool
    #: a smooth curve of torque over position with as many numbers leaves no more of the hold-out
    any_curve: bool
    #: by how much its strength differs from stretch to stretch, beyond chance, as a share of it
    uneven: float
    #: half width of the interval of its strength, as a share of it
    error: float
    #: rms of what it does to its own channel, everything else as it is, over what the model alone leaves there: as its
    #: file has it where the cause is a number, otherwise with its known numbers moved
    does: float


@dataclass(frozen=True)
class Remainder:
    """What an explanation leaves of one channel: before, after (floors), the closed share of squares, and what can be
    predicted of it.
    """

    before: float
    after: float
    predictable: Predictable

    @property
    def closed(self) -> float:
        """Share of the squares above the floor that is closed; one where there was nothing."""
        gap = self.before**2 - 1.0
        return 1.0 - max(self.after**2 - 1.0, 0.0) / gap if gap > 0.1 else 1.0

    @property
    def unpredicted(self) -> float:
        """Floors that no variable predicts."""
        return self.after * math.sqrt(max(0.0, 1.0 - self.predictable.beyond))


def standings(
    inquiry: Inquiry, stated: State, null: State, state: State, path: Path, left: tuple[Remainder, ...]
) -> tuple[Standing, ...]:
    """Every cause of a state by its own evidence, those that take most first; `stated` and `null` are the model alone,
    without and with its known numbers moved, `path` what was tried on the way, and `left` what the state leaves.
    """
    labels = list(dict.fromkeys(state.hypothesis.labels))
    missing = np.array([remainder.predictable.beyond for remainder in left])
    found = (_standing(inquiry, stated, null, state, path, label, missing) for label in labels)
    return tuple(sorted(found, key=lambda s: -s.share))


def _standing(
    inquiry: Inquiry,
    stated: State,
    null: State,
    state: State,
    path: Path,
    label: tuple[str, str],
    missing: Floats,
) -> Standing:
    inquiry.tell(f"what else could {label[0].replace('_', ' ')} be")
    entries = tuple(i for i, other in enumerate(state.hypothesis.labels) if other == label)
    rest = state.hypothesis
    for index in reversed(entries):
        rest = rest.minus(index)
    without = refitted(inquiry, state, rest, rounds=4)
    taken = squares_of(without) - squares_of(state)
    channel = int(np.argmax(taken / np.maximum(squares_of(without), 1.0)))
    lead = state.hypothesis.causes[entries[0]]
    bound = _at_bound(inquiry, state, entries)
    # of several entries the one that was found first, which took most, stands for all; a ripple of torque is the
    # plainest of what is locked to position, and needs no rival for its further orders where it is one
    is_asked = len(entries) == 1 or lead.family.ripple is not Ripple.TORQUE or bool(bound)
    bereft = without if len(entries) == 1 else refitted(inquiry, state, state.hypothesis.minus(entries[0]), rounds=4)
    rivals = rivals_of(inquiry, path, bereft, state, label, missing) if is_asked else ()
    late = gain_on(inquiry, without, state, "untouched")
    bare = refitted(inquiry, state, rest, rounds=0)
    # of a number that is off, the same number within its uncertainty took a part before
    there = stated if CATALOGUE[label[0]].is_number else null
    return Standing(
        entries, label, late, surely_less(inquiry, without, state),
        float(taken[channel] / max(squares_of(without)[channel], 1e-300)), control_share(inquiry, without, lead),
        rivals,
        predictable(inquiry, state, channel, _own_variables(label[0])),
        bound, _unseen(inquiry, state, bare), channel,
        float(np.sum(mean_squares(without.held_out()) - mean_squares(state.held_out()))), taken,
        _explains(inquiry, null, without, taken),
        _any_curve(inquiry, without, state, entries), unevenness(inquiry, bare, state),
        min(strength_error(inquiry, state, i) for i in entries),
        float((rms(_rows(bare) - _rows(state)) / np.maximum(rms(_rows(there)), 1.0))[channel]),
    )  # fmt: skip


def _explains(inquiry: Inquiry, null: State, without: State, taken: Floats) -> bool:
    """Whether a cause takes something of a channel on which the model alone leaves a gap, and the other causes do."""
    alone, beside = (channels_with_a_gap(inquiry, one.fitted, inquiry.in_order(one)) for one in (null, without))
    return bool(np.any(taken[alone & beside] >= inquiry.policy.least_squares))


def _rows(state: State) -> Floats:
    """What a state leaves of all data."""
    return np.concatenate([state.fitted, state.held_out()])


def _own_variables(effect: str) -> frozenset[Variable]:
    """What an effect acts through: with what these were a moment ago, but not all that a joint ever did."""
    own = CATALOGUE[effect].acts_through
    return own - {Variable.PAST} or own


def _at_bound(inquiry: Inquiry, state: State, entries: tuple[int, ...]) -> tuple[str, ...]:
    """What of a cause may go no further: numbers, strengths of which no end is known, or how many orders a ripple has,
    of which enough draw any curve.
    """
    many = ("number of orders",) if len(entries) >= MOST_ENTRIES else ()
    found = at_bound(inquiry.twin, state.hypothesis, entries[0])
    stuck = (name for name in _beyond_its_end(inquiry, state, entries[0]) if name not in found)
    return (*found, *stuck, *many)


def _beyond_its_end(inquiry: Inquiry, state: State, index: int) -> tuple[str, ...]:
    """Strengths of a cause whose interval reaches the end up to which they were sought, and friction levels whose
    interval reaches the largest torque of the motor: that says no more than that it is no less.
    """
    sought = strengths_to_their_end(inquiry, state, index)
    model, (effect, axis) = inquiry.twin.model, state.hypothesis.labels[index]
    limit = model.number(axis, "actuator.limit")
    levels = [
        p.name for p in CATALOGUE[effect].parameters if p.unit == "N m" and (p.path or "").startswith("friction.")
    ]
    if not limit or not levels:
        return sought
    reach = parameter_intervals(inquiry, state, index)
    return (*sought, *(name for name in levels if name not in sought and reach[name][1] >= limit))


def _any_curve(inquiry: Inquiry, without: State, state: State, entries: tuple[int, ...]) -> bool:
    """Whether a smooth curve of torque does as well as the strongest order of a ripple, or all orders together are
    one.
    """
    lead = max((state.hypothesis.causes[i] for i in entries), key=lambda cause: abs(cause.x[0]))
    if lead.family.ripple is None:
        return False
    if lead.family.ripple is Ripple.TORQUE and orders_make_a_series(inquiry, state, entries):
        return True
    return curve_does_as_well(inquiry, without, refitted(inquiry, state, without.hypothesis.plus(lead), rounds=3))


def _unseen(inquiry: Inquiry, state: State, bare: State) -> bool:
    """Whether the hold-out has no trace of a cause: taken away, everything else as it is, next to nothing changes
    there.
    """
    changes = [rms(getattr(bare, part) - getattr(state, part)) for part in PARTS[1:]]
    levels = [np.maximum(rms(getattr(state, part)), 1.0) for part in PARTS[1:]]
    return all(bool(np.all(change < _NO_TRACE * level)) for change, level in zip(changes, levels, strict=True))


def depends_on(inquiry: Inquiry, state: State, left: tuple[Remainder, ...]) -> tuple[Variable, float] | None:
    """The variable that alone predicts most of what a state leaves of its worst channel, and the share; None where
    none predicts nearly as much as all together.
    """
    column = max(range(len(left)), key=lambda j: left[j].after)
    together = left[column].predictable.beyond
    if together < inquiry.policy.exhausted:
        return None
    said = [one for one in Variable if one not in _unsaid(inquiry)]
    shares = {one: predictable(inquiry, state, column, frozenset({one})).beyond for one in said}
    # of two that say as much the one that comes first: what a law is written over before what only goes with it
    best = next(one for one, share in shares.items() if share >= _AS_MUCH * max(shares.values()))
    return (best, shares[best]) if shares[best] > _NEARLY_ALL * together else None


def _unsaid(inquiry: Inquiry) -> set[Variable]:
    """Variables of which these logs say nothing: what goes with them here is the joint's own motion."""
    records = (*inquiry.twin.records, *inquiry.holdout.records)
    base = set() if any(r.moving_base for r in records) else {Variable.BASE_MOTION, Variable.ATTITUDE}
    return base | (set() if any(r.has_temperature for r in records) else {Variable.TEMPERATURE})


def remainders(inquiry: Inquiry, null: State, state: State) -> tuple[Remainder, ...]:
    """What is left of every channel on the hold-out."""
    found = []
    for j in range(len(inquiry.twin.channels)):
        before, after = (float(rms(s.held_out())[j]) for s in (null, state))
        is_gap = after > inquiry.policy.least_gap
        shape = predictable(inquiry, state, j, EVERYTHING) if is_gap else Predictable(0.0, 0.0)
        found.append(Remainder(before, after, shape))
    return tuple(found)
