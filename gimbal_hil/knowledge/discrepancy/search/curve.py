"""Is it a ripple, or any curve over position? A ripple is accepted only if it explains more than a smooth curve does.

Several orders together can imitate any curve over a limited travel, such as a stop that hardens or rails that are not
straight. So the gain of a ripple's strongest order is computed once more beside a smooth curve over the travel (a
cosine series) with as many free numbers, fitted on the same rows and judged on the same hold-out. A curve that exists
beside a true ripple does not lower that gain. Orders as closely spaced as the terms of a series over the travel count
as such a series, except two of which one is a multiple of the other.

The curve is one of torque. Friction that changes along the travel has a name of its own, whatever its curve; a curve of
torque imitates it only if the joint moves one way.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import placed
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State, mean_squares
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Floats, Record
from sim_backend.effects import NEUTRAL_ORDER

#: free numbers of one order: amplitude, order and phase
_NUMBERS = 3
#: a ripple stands beside a curve where that alone leaves more by this share of what the ripple takes by itself, or so
#: many times as much
_CLEARLY, _TIMES = 0.4, 2.5
#: a series over the travel that ends with an order of n periods has n orders; a ripple has at most this share of them
_OF_A_SERIES = 0.5
#: a harmonic is a multiple of its ripple's order; the ratio of two orders is known to this much
_A_MULTIPLE = 0.1


def curve_does_as_well(inquiry: Inquiry, without: State, state: State) -> bool:
    """Whether a smooth curve of torque over position leaves nothing to explain for the newest cause of a state, where
    that is a ripple, on the channel of torque where it takes most.
    """
    family = state.hypothesis.causes[-1].family
    before, after = (mean_squares(s.held_out()) for s in (without, state))
    channel = int(np.argmax((before - after) / np.maximum(before, 1.0)))
    if family.ripple is None or inquiry.twin.channels[channel].signal != TORQUE:
        return False
    alone, beside = (_left_by_a_curve(inquiry, one, state, channel) for one in (without, state))
    takes = float(before[channel] - after[channel])
    return alone < min(beside + _CLEARLY * takes, _TIMES * max(beside, 1.0))


def orders_make_a_series(inquiry: Inquiry, state: State, entries: tuple[int, ...]) -> bool:
    """Whether orders of one ripple are a series over the travel: more than half as many as periods of the highest one
    lie there, unless they are two, a ripple and its harmonic; or of none a whole period lies there.
    """
    twin, causes = inquiry.twin, [state.hypothesis.causes[index] for index in entries]
    axis = twin.model.axes.index(causes[0].family.axis)
    taught = placed(twin.records, state.hypothesis)
    ends = [end(record.motion[:, axis]) for record in taught for end in (np.min, np.max)]
    orders = sorted(NEUTRAL_ORDER + cause.x[1] for cause in causes)
    periods = orders[-1] * float(max(ends) - min(ends)) / (2.0 * np.pi)
    if len(orders) == 1 or (len(orders) == 2 and _is_a_multiple(orders[1] / orders[0])):
        return periods < 1.0
    return len(orders) > _OF_A_SERIES * periods


def _is_a_multiple(ratio: float) -> bool:
    return round(ratio) > 1 and abs(ratio - round(ratio)) < _A_MULTIPLE


def _left_by_a_curve(inquiry: Inquiry, state: State, placing: State, channel: int) -> float:
    """Mean square of a channel of the hold-out, in squared floors, that a curve with the numbers of one order leaves of
    a state; positions as `placing` has them.
    """
    axis = inquiry.twin.model.axes.index(inquiry.twin.channels[channel].axis)
    taught, asked = placed(inquiry.twin.records, placing.hypothesis), placed(inquiry.holdout.records, placing.held)
    position = np.concatenate([record.at_scored(record.motion[:, axis]) for record in taught])
    low, high = float(position.min()), float(position.max())
    terms = 1 + _NUMBERS
    columns, held = (np.concatenate([_terms(r, axis, low, high, terms) for r in logs]) for logs in (taught, asked))
    weights = np.linalg.lstsq(columns, state.fitted[:, channel], rcond=None)[0]
    return float(np.mean((inquiry.in_order(state)[:, channel] - held @ weights) ** 2))


def _terms(record: Record, axis: int, low: float, high: float, terms: int) -> Floats:
    """Cosines over the travel, (rows, terms); beyond the travel that was taught the curve stays where it ended."""
    position = record.at_scored(record.motion[:, axis])
    along = np.clip((position - low) / max(high - low, 1e-300), 0.0, 1.0)
    return np.asarray(np.cos(np.pi * np.outer(along, np.arange(terms))))
