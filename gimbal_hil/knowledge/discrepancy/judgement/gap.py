"""What counts as a gap: one rule for real logs and for an effect that is only simulated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, rms
from gimbal_hil.knowledge.discrepancy.twin import Floats


def is_a_gap(inquiry: Inquiry, fitted: Floats, held: Floats, beside_wander: Callable[[], Floats]) -> bool:
    """Whether rows of the fitted logs and of the hold-out, (rows, channels) in floors and in the order of the logs, are
    a gap that the hold-out repeats and friction whose level wanders does not explain, or a larger one of any log.
    """
    least, larger = _over(inquiry, fitted, held)
    return bool(np.any(larger)) or bool(np.any(least) and np.any(beside_wander() > _least(inquiry)))


def channels_with_a_gap(inquiry: Inquiry, fitted: Floats, held: Floats) -> NDArray[np.bool_]:
    """The channels that have such a gap, (channels,): on the others there is nothing that a cause could explain."""
    least, larger = _over(inquiry, fitted, held)
    return least | larger


def _over(inquiry: Inquiry, fitted: Floats, held: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Channels where the hold-out is over the least gap; and where any part is over what need not be repeated."""
    parts = (fitted, held[inquiry.selecting], held[~inquiry.selecting])
    larger = np.max([rms(part) for part in parts], axis=0) > inquiry.policy.not_repeated * _limit(inquiry)
    return rms(held) > _least(inquiry), larger


def _least(inquiry: Inquiry) -> Floats | float:
    return inquiry.policy.least_gap * _limit(inquiry)


def _limit(inquiry: Inquiry) -> Floats | float:
    """One floor, with what the twin itself is not exact to."""
    return np.hypot(1.0, inquiry.inexact)
