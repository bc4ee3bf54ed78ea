"""Laws where no name fits: curves and formulas for them, added one by one while each improves the fit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.discrepancy.inquiry import NEARLY_ALL, Inquiry, State, refitted, rms, surely_less
from gimbal_hil.knowledge.discrepancy.laws.curve import (
    COUNTS,
    FEW,
    STRAIGHT,
    Curve,
    Tried,
    channel_of,
    columns_on,
    control_of,
    curve_from,
    leaves_of_its_own,
    multiplied,
    seen_of,
    sharpened,
    tried,
)
from gimbal_hil.knowledge.discrepancy.laws.formula import Formula, formula_for
from gimbal_hil.knowledge.discrepancy.laws.linear import Straight
from gimbal_hil.knowledge.discrepancy.laws.saying import Saying, points_of
from gimbal_hil.knowledge.discrepancy.laws.shape import LawShape, crossed, shapes_of
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Floats, Twin
from sim_backend.model import AntennaModel, Over

#: laws of one verdict; shapes that are looked at closely, and those that get a second variable
_MOST_LAWS, _CLOSE, _CROSSED = 3, 4, 2
#: a plainer shape is taken that leaves no more than so many times what the best one does, and so many squared floors
_AS_GOOD, _FLOORS = 1.15, 0.15
#: where one variable alone leaves a gap, two must take this share of it
_WORTH = 0.4
#: shifts of the negative controls
_SHIFTS = (0.13, 0.31, 0.57, 0.79)
#: share of the squares above the floor that laws must close on the untouched half, in each channel that had a gap
_CLOSED = 0.9


@dataclass(frozen=True)
class DescribedLaw:
    """A law as it is told."""

    curve: Curve
    #: the same as a formula, where one says as much
    formula: Formula | None
    #: squares a row of its channel that it takes of the untouched half, over those that were there
    gain: float
    control: float
    #: rows of the untouched half: its first variable there, and what the law says less what is left, in its unit
    at: Floats
    points: Floats


@dataclass(frozen=True)
class Described:
    """Laws that together explain what no name does."""

    laws: tuple[DescribedLaw, ...]
    #: the model with them, the same logs under it, and the state there
    model: AntennaModel
    inquiry: Inquiry
    state: State


def described(
    inquiry: Inquiry, null: State, lacking: NDArray[np.bool_], named: State | None = None
) -> Described | None:
    """Laws beside the model with its known numbers moved; None where none explains what is left, or none better than
    `named`, the best that names of the catalogue did. Only of channels that are `lacking` something, (channels,), is a
    law told: by the rule of the verdict the others hold nothing but noise.
    """
    found = Described((), inquiry.twin.model, inquiry, null)
    for _ in range(_MOST_LAWS):
        more = _one_more(inquiry, null, lacking, found)
        if more is None:
            break
        found = more
        if np.all(found.state.left() <= inquiry.policy.least_gap):
            break
    if not found.laws or not _explains(null, found):
        return None
    return found if named is None or _better(inquiry, named, found.state) else None


def _better(inquiry: Inquiry, named: State, found: State) -> bool:
    """Whether laws leave surely less than what names leave, or next to nothing of what that holds above the floor: a
    curve has more numbers than a name, and where names leave the floor, it cannot be better by that.
    """
    was, now = (max(float(np.max(one.left())) ** 2 - 1.0, 0.0) for one in (named, found))
    unit = np.asarray(np.mean(named.fitted**2, axis=0))
    return surely_less(inquiry, named, found, unit) > inquiry.policy.anew or now < (1.0 - NEARLY_ALL) * was


def _explains(null: State, found: Described) -> bool:
    """Whether on the channels that laws act on the untouched half holds no gap any more, or next to none of what was
    there, and no more than before on the others: what is left of another axis is no doubt about a law of this one.
    """
    before, after = (rms(state.untouched) for state in (null, found.state))
    least = found.inquiry.policy.least_gap
    closed = 1.0 - np.maximum(after**2 - 1.0, 0.0) / np.maximum(before**2 - 1.0, 1e-9)
    told = np.isin(np.arange(len(before)), [channel_of(found.inquiry, law.curve.shape.axis) for law in found.laws])
    gap = before > least
    stands = np.where(told, gap & (closed >= _CLOSED), after**2 <= _AS_GOOD * before**2) | (after <= least)
    # a half that has no gap judges nothing
    return bool(np.any(gap & told) and np.all(stands))


def _one_more(inquiry: Inquiry, null: State, lacking: NDArray[np.bool_], found: Described) -> Described | None:
    if not np.any(lacking):
        return None
    straight = Straight.of(found.inquiry, found.state)
    asked = (_asked(inquiry, null, found, straight, best) for best in _best(null, lacking, found, straight))
    return next((one for one in asked if one is not None), None)


def _asked(inquiry: Inquiry, null: State, found: Described, straight: Straight, best: Tried) -> Described | None:
    """With one more law of a shape; None where it does not stand its tests."""
    channel = channel_of(inquiry, best.seen.shape.axis)
    curve, after = _with(inquiry, found, best, curve_from(found.inquiry, straight, best))
    inquiry.tell(f"looking for a formula of {best.seen.shape.text}")
    formula, after = _as_formula(inquiry, found, best, curve, after)
    # a law that takes nearly all need not: a single event has no standard error
    surely = surely_less(inquiry, found.state, after.state)
    was, now = (float(np.mean(one.untouched[:, channel] ** 2)) for one in (found.state, after.state))
    control = control_of(straight, best, channel, _SHIFTS)
    inquiry.tell(f"a law of {best.seen.shape.text} takes {1.0 - now / max(was, 1e-9):.0%}")
    policy = inquiry.policy
    sure = surely > inquiry.policy.anew or was - now > NEARLY_ALL * (was - 1.0)
    if not sure or control > policy.control * (was - now) or was - now < policy.least_squares:
        return None
    before = float(np.mean(null.untouched[:, channel] ** 2))
    points = _points(after, curve, formula, channel)
    law = DescribedLaw(curve, formula, (was - now) / before, max(0.0, control) / before, *points)
    return replace(after, laws=(*found.laws, law))


def _as_formula(
    inquiry: Inquiry, found: Described, best: Tried, curve: Curve, after: Described
) -> tuple[Formula | None, Described]:
    """A formula in place of a curve, where the model with it leaves no more; else the curve stays."""
    straight = Straight.of(after.inquiry, after.state)
    channel = channel_of(inquiry, curve.shape.axis)
    there = columns_on(after.inquiry, seen_of(after.inquiry, curve.shape), curve.knots) @ curve.values
    formula = formula_for(
        Saying.of(after.inquiry, straight, curve.shape, there, curve.knots, is_dense=best.factor is not None)
    )
    if formula is None:
        return None, after
    written = _under(inquiry, found, formula.entry(found.model.is_linear))
    left = [_selecting_squares(one.state)[channel] for one in (after, written)]
    return (formula, written) if left[1] <= _AS_GOOD * left[0] + _FLOORS else (None, after)


def _selecting_squares(state: State) -> Floats:
    """Squares a row of every channel over rows that may select."""
    return np.asarray(np.mean(np.concatenate([state.fitted, state.selecting]) ** 2, axis=0))


def _best(null: State, lacking: NDArray[np.bool_], found: Described, straight: Straight) -> Iterator[Tried]:
    """The plainest shape of those that leave least of the selecting half, on the axis with the largest gap of those
    that lack something; then, where that is of two variables, the plainest of one.
    """
    inquiry = found.inquiry
    levels = [
        float(left) if channel.signal == TORQUE and lacks else 0.0
        for channel, left, lacks in zip(inquiry.twin.channels, found.state.left(), lacking, strict=True)
    ]
    worst = int(np.argmax(levels))
    if levels[worst] <= inquiry.policy.least_gap:
        return
    axis = inquiry.twin.channels[worst].axis
    inquiry.tell(f"looking for a law of {axis}")
    shapes = shapes_of(inquiry.twin.model, axis, inquiry.twin.records)
    looked = [one for shape in shapes if (one := tried(inquiry, straight, seen_of(inquiry, shape), (FEW,))) is not None]
    closely = [
        sharpened(inquiry, straight, one)
        for few in _of_each_kind(looked)[:_CLOSE]
        if (one := tried(inquiry, straight, few.seen, COUNTS)) is not None
    ]
    if not closely:
        return
    least = min(one.leaves for one in closely)
    # what one variable draws to its floor, or to what a twin is exact to, asks for no second one, however little some
    # stretches say of others
    exact = inquiry.policy.same * float(null.left()[worst])
    own = min([least, *(leaves_of_its_own(inquiry, straight, one.seen) for one in closely)])
    if own > max(inquiry.policy.least_gap, exact) ** 2:
        first = sorted(closely, key=lambda one: one.leaves)[:_CROSSED]
        if any(one.seen.shape.over == (Over.RATE,) for one in first):
            # the same as friction over speed, which others may have a part in
            speed = next(shape for shape in shapes if shape.over == (Over.SPEED,) and not shape.by_direction)
            same = tried(inquiry, straight, seen_of(inquiry, speed), COUNTS)
            first += [] if same is None else [sharpened(inquiry, straight, same)]
        both = _of_two(inquiry, straight, first, shapes)
        two = [one for one in both if one.leaves < (1.0 - _WORTH) * least]
        if two:
            yield sharpened(inquiry, straight, _plainest([*closely, *two]))
    best = _plainest(closely)
    if best.seen.shape.has_a_name_straight:
        line = tried(inquiry, straight, best.seen, STRAIGHT)
        if line is not None and line.leaves <= _AS_GOOD * best.leaves + _FLOORS:
            # what a straight line says is an offset, a spring, a viscosity, a gain: no law
            return
    yield best


def _of_each_kind(looked: list[Tried]) -> list[Tried]:
    """The best of shapes that differ in their memory alone, whose length is a number of theirs; best first."""
    found: dict[LawShape, Tried] = {}
    for one in sorted(looked, key=lambda one: one.leaves):
        found.setdefault(one.seen.shape.without_numbers, one)
    return list(found.values())


def _plainest(found: list[Tried]) -> Tried:
    """Of those that leave hardly more than the best."""
    least = min(one.leaves for one in found)
    alike = [one for one in found if one.leaves <= _AS_GOOD * least + _FLOORS]
    return min(alike, key=lambda one: (one.seen.shape.plainness, one.leaves))


def _of_two(inquiry: Inquiry, straight: Straight, first: list[Tried], shapes: tuple[LawShape, ...]) -> Iterator[Tried]:
    """What is over the variable of one of the first and another: any surface with few knots, once for each pair, or
    the curve times another.
    """
    met: set[LawShape] = set()
    for one in first:
        for shape in crossed(one.seen.shape, shapes):
            surface = None if shape in met else tried(inquiry, straight, seen_of(inquiry, shape), COUNTS)
            met.add(shape)
            yield from (two for two in (surface, multiplied(inquiry, straight, one, shape)) if two is not None)


def _with(inquiry: Inquiry, found: Described, best: Tried, curve: Curve) -> tuple[Curve, Described]:
    """The model with one more law, its known numbers and then the law's values fitted once more beside each other."""
    linear = found.model.is_linear
    once = _under(inquiry, found, curve.entry(linear))
    straight = Straight.of(once.inquiry, once.state)
    channel = channel_of(inquiry, curve.shape.axis)
    columns = columns_on(once.inquiry, seen_of(once.inquiry, curve.shape), curve.knots, best.factor)
    more = curve.plus(best.spread(straight.solved(straight.normals(columns, channel, best.bends)).values))
    twice = _under(inquiry, replace(once, model=found.model), more.entry(linear))
    left = [np.sum(one.state.fitted**2) + np.sum(one.state.selecting**2) for one in (once, twice)]
    return (more, twice) if left[1] < left[0] else (curve, once)


def _under(inquiry: Inquiry, found: Described, entry: dict[str, object]) -> Described:
    """With one more law in the model, and its known numbers fitted beside it."""
    model = found.model.with_law(entry)

    def under(twin: Twin) -> Twin:
        return Twin(model, twin.records, twin.gyro_everywhere, twin.scales)

    there = replace(
        inquiry,
        twin=under(inquiry.twin),
        holdout=under(inquiry.holdout),
        selectable=under(inquiry.selectable),
        known=None,
        twin_there=None,
        known_there=None,
    )
    # first with what is left as it was, then with what a row counts for once the law is there
    state = refitted(there, found.state, found.state.hypothesis, rounds=2)
    state = refitted(there, state, state.hypothesis)
    return replace(found, model=model, inquiry=there, state=state)


def _points(found: Described, curve: Curve, formula: Formula | None, channel: int) -> tuple[Floats, Floats]:
    """Where rows of the untouched half lie over the curve's first variable, and what they say of the law there."""
    inquiry = found.inquiry
    seen = seen_of(inquiry, curve.shape)
    floor, count = float(inquiry.floor[channel]), sum(inquiry.row_counts)
    held = inquiry.holdout.records
    over = [columns[0] for columns in seen.columns[len(inquiry.twin.records) :]]
    at = np.concatenate([record.at_scored(x) for record, x in zip(held, over, strict=True)])[~inquiry.selecting]
    values = curve.values if formula is None else np.concatenate(formula.at(*points_of(curve.knots)))
    says = floor * (columns_on(inquiry, seen, curve.knots) @ values)[count:][~inquiry.selecting]
    return at, np.asarray(says - floor * found.state.untouched[:, channel])


__all__ = ["Described", "DescribedLaw", "described"]
