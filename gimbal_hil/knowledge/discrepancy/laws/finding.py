"""Laws where no name fits: measured curves, one after the other, until nothing is left that one of them would take."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State, refitted, rms, surely_less
from gimbal_hil.knowledge.discrepancy.laws.curve import (
    COUNTS,
    Curve,
    Tried,
    channel_of,
    columns_on,
    control_of,
    curve_from,
    seen_of,
    sharpened,
    tried,
)
from gimbal_hil.knowledge.discrepancy.laws.linear import Straight
from gimbal_hil.knowledge.discrepancy.laws.shape import crossed, shapes_of
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Floats, Twin
from sim_backend.model import AntennaModel

#: laws of one verdict; knots by which shapes are compared first, and shapes that are then looked at closely
_MOST_LAWS, _FEW, _CLOSE = 3, (12,), 4
#: a plainer shape is taken that leaves no more than so many times what the best one does, and so many squared floors
_AS_GOOD, _FLOORS = 1.15, 0.15
#: two variables are looked at where one leaves more squares than this, of which they must take this share
_BOTH, _WORTH = 2.25, 0.4
#: shifts of the negative controls; standard errors by which a law must pay, or the share of the untouched half's
#: squares above the floor
_SHIFTS, _SURE, _NEARLY_ALL = (0.13, 0.31, 0.57, 0.79), 3.0, 0.85
#: share of the squares above the floor that laws must close on the untouched half, in each channel that had a gap
_CLOSED = 0.9


@dataclass(frozen=True)
class DescribedLaw:
    """A law as it is told."""

    curve: Curve
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
    #: their curves as they were fitted, the model with them, the same logs under it, and the state there
    curves: tuple[Curve, ...]
    model: AntennaModel
    inquiry: Inquiry
    state: State

    @property
    def curve(self) -> Curve:
        """The last curve that was added."""
        return self.curves[-1]


def described(inquiry: Inquiry, null: State) -> Described | None:
    """Laws beside the model with its known numbers moved; None where none explains what is left."""
    found = Described((), (), inquiry.twin.model, inquiry, null)
    for _ in range(_MOST_LAWS):
        more = _one_more(inquiry, null, found)
        if more is None:
            break
        found = more
        if np.all(found.state.left() <= inquiry.policy.least_gap):
            break
    return found if found.laws and _explains(null, found) else None


def _explains(null: State, found: Described) -> bool:
    """Whether the untouched half holds no gap any more, or next to none of what was there."""
    before, after = (rms(state.untouched) for state in (null, found.state))
    least = found.inquiry.policy.least_gap
    closed = 1.0 - np.maximum(after**2 - 1.0, 0.0) / np.maximum(before**2 - 1.0, 1e-9)
    # a half that has no gap judges nothing
    return bool(np.any(before > least) and np.all((after <= least) | ((before > least) & (closed >= _CLOSED))))


def _one_more(inquiry: Inquiry, null: State, found: Described) -> Described | None:
    straight = Straight.of(found.inquiry, found.state)
    best = _best(found, straight)
    if best is None:
        return None
    channel = channel_of(inquiry, best.seen.shape.axis)
    curve = curve_from(found.inquiry, straight, best)
    after = _with(inquiry, found, curve)
    # a law that takes nearly all need not: a single event has no standard error
    surely = surely_less(inquiry, found.state, after.state)
    was, now = (float(np.mean(one.untouched[:, channel] ** 2)) for one in (found.state, after.state))
    control = control_of(straight, best, channel, _SHIFTS)
    inquiry.tell(f"a law of {best.seen.shape.text} takes {1.0 - now / max(was, 1e-9):.0%}")
    policy = inquiry.policy
    sure = surely > _SURE or was - now > _NEARLY_ALL * (was - 1.0)
    if not sure or control > policy.control * (was - now) or was - now < policy.least_squares:
        return None
    before = float(np.mean(null.untouched[:, channel] ** 2))
    law = DescribedLaw(after.curve, (was - now) / before, max(0.0, control) / before, *_points(after, channel))
    return replace(after, laws=(*found.laws, law))


def _best(found: Described, straight: Straight) -> Tried | None:
    """The plainest shape of those that leave least of the selecting half, on the axis with the largest gap."""
    inquiry = found.inquiry
    levels = [
        float(left) if channel.signal == TORQUE else 0.0
        for channel, left in zip(inquiry.twin.channels, found.state.left(), strict=True)
    ]
    worst = int(np.argmax(levels))
    if levels[worst] <= inquiry.policy.least_gap:
        return None
    axis = inquiry.twin.channels[worst].axis
    inquiry.tell(f"looking for a law of {axis}")
    shapes = shapes_of(inquiry.twin.model, axis, inquiry.twin.records)
    looked = [one for shape in shapes if (one := tried(inquiry, straight, seen_of(inquiry, shape), _FEW)) is not None]
    looked = sorted(looked, key=lambda one: one.leaves)[:_CLOSE]
    closely = [one for few in looked if (one := tried(inquiry, straight, few.seen, COUNTS)) is not None]
    if not closely:
        return None
    least = min(one.leaves for one in closely)
    if least > _BOTH:
        first = tuple(one.seen.shape for one in looked[:2])
        two = (tried(inquiry, straight, seen_of(inquiry, shape), COUNTS) for shape in crossed(first, shapes))
        closely += [one for one in two if one is not None and one.leaves < (1.0 - _WORTH) * least]
        least = min(one.leaves for one in closely)
    alike = [one for one in closely if one.leaves <= _AS_GOOD * least + _FLOORS]
    return sharpened(inquiry, straight, min(alike, key=lambda one: (one.seen.shape.plainness, one.leaves)))


def _with(inquiry: Inquiry, found: Described, curve: Curve) -> Described:
    """The model with one more law, its known numbers and then the law's values fitted once more beside each other."""
    once = _under(inquiry, found, curve)
    straight = Straight.of(once.inquiry, once.state)
    channel = channel_of(inquiry, curve.shape.axis)
    columns = columns_on(once.inquiry, seen_of(once.inquiry, curve.shape), curve.knots)
    more = straight.solved(straight.normals(columns, channel)).values
    twice = _under(inquiry, replace(once, curves=found.curves, model=found.model), curve.plus(more))
    left = [np.sum(one.state.fitted**2) + np.sum(one.state.selecting**2) for one in (once, twice)]
    return twice if left[1] < left[0] else once


def _under(inquiry: Inquiry, found: Described, curve: Curve) -> Described:
    model = found.model.with_law(curve.entry(found.model.is_linear))

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
    return replace(found, curves=(*found.curves, curve), model=model, inquiry=there, state=state)


def _points(found: Described, channel: int) -> tuple[Floats, Floats]:
    """Where rows of the untouched half lie over the curve's first variable, and what they say of the law there."""
    inquiry, curve = found.inquiry, found.curve
    seen = seen_of(inquiry, curve.shape)
    floor, count = float(inquiry.floor[channel]), sum(inquiry.row_counts)
    held = inquiry.holdout.records
    over = [columns[0] for columns in seen.columns[len(inquiry.twin.records) :]]
    at = np.concatenate([record.at_scored(x) for record, x in zip(held, over, strict=True)])[~inquiry.selecting]
    says = floor * (columns_on(inquiry, seen, curve.knots) @ curve.values)[count:][~inquiry.selecting]
    return at, np.asarray(says - floor * found.state.untouched[:, channel])


__all__ = ["Described", "DescribedLaw", "described"]
