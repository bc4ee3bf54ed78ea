"""What counts as a gap: one rule for real logs and for an effect that is only simulated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry
from gimbal_hil.knowledge.discrepancy.twin import Floats


def is_a_gap(inquiry: Inquiry, left: Floats, held_out: Floats, beside_wander: Callable[[], Floats]) -> bool:
    """Whether what is left (floors per channel; of all logs, and of the hold-out alone) is a gap that the hold-out
    repeats and friction whose level wanders does not explain, or a larger one of any log.
    """
    limit = np.hypot(1.0, inquiry.inexact)
    if np.any(left > inquiry.policy.not_repeated * limit):
        return True
    least = inquiry.policy.least_gap * limit
    return bool(np.any(held_out > least) and np.any(beside_wander() > least))
