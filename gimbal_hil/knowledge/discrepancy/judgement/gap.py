"""What counts as a gap: one rule for real logs and for an effect that is only simulated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, rms
from gimbal_hil.knowledge.discrepancy.twin import Floats


def is_a_gap(inquiry: Inquiry, fitted: Floats, held: Floats, beside_wander: Callable[[], Floats]) -> bool:
    """Whether rows of the fitted logs and of the hold-out, (rows, channels) in floors and in the order of the logs, are
    a gap that the hold-out repeats and friction whose level wanders does not explain, or a larger one of any log.
    """
    limit = np.hypot(1.0, inquiry.inexact)
    parts = (fitted, held[inquiry.selecting], held[~inquiry.selecting])
    if np.any(np.max([rms(part) for part in parts], axis=0) > inquiry.policy.not_repeated * limit):
        return True
    least = inquiry.policy.least_gap * limit
    return bool(np.any(rms(held) > least) and np.any(beside_wander() > least))
