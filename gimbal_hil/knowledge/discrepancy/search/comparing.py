"""Which of two explanations fits better, on the fitted logs and on the half of the hold-out that selects."""

from __future__ import annotations

import math

import numpy as np

from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, Policy, State, gain_on, mean_squares
from gimbal_hil.knowledge.discrepancy.twin import Floats

#: a state is no worse than another that leaves at most so many times as much
_NO_WORSE = 1.1
#: what leaves, or by its slopes would leave, more squares than so many times those of the best is out of the race
OUT_OF_REACH = 2.0
#: share of what a cause takes that a rival may leave, however much is missing beside both
_PART = 0.25


def advantage(inquiry: Inquiry, before: State, after: State) -> float:
    """Squares that a state takes, of fitted rows and of those that select alike: one log may say clearly what the other
    hardly shows.
    """
    return gain_on(inquiry, before, after, "fitted").mean + gain_on(inquiry, before, after, "selecting").mean


def surely(inquiry: Inquiry, old: State, new: State) -> float:
    """Standard errors by which one state leaves less than another, on fitted rows and those that select together."""
    return sum(gain_on(inquiry, old, new, part).sure for part in ("fitted", "selecting")) / math.sqrt(2.0)


def clearly_better(inquiry: Inquiry, new: State, old: State) -> bool:
    """Whether one state leaves less than another by the share of what that leaves, noise at least, that a cause must
    take.

    Where one leaves much of one channel and the other much of another, neither is the unit of both.
    """
    unit = np.maximum(np.minimum(new.fit.squares, old.fit.squares), 1.0)
    left = sum(float(np.sum(np.maximum(mean_squares(rows), 1.0) / unit)) for rows in (old.fitted, old.selecting))
    fitted, selecting = (gain_on(inquiry, old, new, part, unit) for part in ("fitted", "selecting"))
    return fitted.mean + selecting.mean > inquiry.policy.least_share * left and selecting.sure > 0.0


def no_worse(before: Floats, after: Floats) -> bool:
    """Whether rows (rows, channels) hold hardly more after than before, which is noise at least."""
    return bool(np.sum(mean_squares(after)) <= _NO_WORSE * np.sum(np.maximum(mean_squares(before), 1.0)))


def same_to_a_twin(
    policy: Policy,
    mine: Floats,
    theirs: Floats,
    without: Floats,
    noisier: Floats | float = 0.0,
    missing: Floats | float = 0.0,
) -> bool:
    """Whether two explanations that leave these squares per channel, and without which so much would be left, differ
    by less than a twin is exact to: a share of what is left, that share of the size of what the cause takes, or what a
    floor itself is known to.

    `noisier` is by how much more, in floors, noise counts in the other one (`evidence.noise_of_command`). What noise
    explains up to one floor is no difference either. `missing` is the share of what is left that can be predicted:
    something else is missing there, and what one of the two takes more of may be a part of that, up to a quarter of
    what the cause takes.
    """
    left = np.maximum(mine, 1.0)
    noise = np.clip(noisier, 0.0, 1.0) * np.minimum(mine, 1.0)
    shares = np.maximum(policy.same * left, policy.same**2 * without)
    exact = np.maximum.reduce(
        [
            shares,
            np.full_like(shares, policy.least_squares),
            noise,
            np.minimum(missing * theirs, _PART * (without - mine)),
        ]
    )
    # below its floor a channel refutes nothing; and all channels count together, since of one an explanation may leave
    # more and of the next less
    return bool(np.sum((np.maximum(theirs, 1.0) - left) / exact) < 1.0)
