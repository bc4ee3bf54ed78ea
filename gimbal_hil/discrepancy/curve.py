"""Is it a ripple, or some curve over position? A name has to beat a function that knows nothing.

Several orders together can draw any curve over a limited travel, such as a stop that hardens or rails that are not
straight. So the strongest order of a ripple is compared with a smooth curve over the travel that has as many free
numbers (a cosine series), fitted on the same rows and judged on the same hold-out.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.discrepancy.inquiry import Inquiry, State, mean_squares
from gimbal_hil.discrepancy.origin import placed
from gimbal_hil.discrepancy.record import TORQUE, Record
from gimbal_hil.discrepancy.smoothing import Floats
from sim_backend.effects import Ripple

#: free numbers of one order: amplitude, order and phase
_NUMBERS = 3
#: a curve does as well unless it leaves more than a ripple by this share of what that takes, or so many times as much:
#: where other things are left too, or where nothing else is
_CLEARLY, _TIMES = 0.4, 2.5


def curve_does_as_well(inquiry: Inquiry, without: State, state: State) -> bool:
    """Whether a smooth curve over position takes as much as the newest cause of a state, where that is a ripple of
    torque, on the channel where it takes most.
    """
    family = state.hypothesis.causes[-1].family
    before, after = (mean_squares(s.held_out()) for s in (without, state))
    channel = int(np.argmax((before - after) / np.maximum(before, 1.0)))
    if family.ripple is None or inquiry.twin.channels[channel].signal != TORQUE:
        return False
    left = _left_by_a_curve(inquiry, without, state, channel, family.ripple)
    had, has = float(before[channel]), float(after[channel])
    return left < min(has + _CLEARLY * (had - has), _TIMES * max(has, 1.0))


def _left_by_a_curve(inquiry: Inquiry, without: State, state: State, channel: int, over: Ripple) -> float:
    """Mean square of a channel of the hold-out, in squared floors, that a curve with the numbers of one order leaves of
    `without`; positions as `state` places them.
    """
    axis = inquiry.twin.model.axes.index(inquiry.twin.channels[channel].axis)
    taught, asked = placed(inquiry.twin.records, state.hypothesis), placed(inquiry.holdout.records, state.held)
    position = np.concatenate([record.at_scored(record.motion[:, axis]) for record in taught])
    low, high = float(position.min()), float(position.max())
    terms = 1 + _NUMBERS
    columns, held = (
        np.concatenate([_terms(r, axis, low, high, terms, over) for r in logs]) for logs in (taught, asked)
    )
    weights = np.linalg.lstsq(columns, without.fitted[:, channel], rcond=None)[0]
    return float(np.mean((inquiry.in_order(without)[:, channel] - held @ weights) ** 2))


def _terms(record: Record, axis: int, low: float, high: float, terms: int, over: Ripple) -> Floats:
    """Cosines over the travel, (rows, terms); beyond the travel that was taught the curve stays where it ended."""
    position, rate = (record.at_scored(record.motion[:, k]) for k in (axis, 2 + axis))
    along = np.clip((position - low) / max(high - low, 1e-300), 0.0, 1.0)
    found = np.cos(np.pi * np.outer(along, np.arange(terms)))
    return np.asarray(found * np.sign(rate)[:, None] if over is Ripple.FRICTION else found)
