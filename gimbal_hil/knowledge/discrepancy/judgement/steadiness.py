"""Has a cause the same strength in every stretch of the logs?

A true cause is present everywhere with one strength. So each log is cut into stretches that hold equal evidence for the
cause, and its strength is estimated in each, everything else unchanged: the slope of the residual without the cause
over the response of the cause. A viscosity that jumps, grease that softens with use or stiction that grows with dwell
time can be fitted by a constant cause at some mean strength; its spread between stretches shows that it is something
else.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import BROKEN
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State
from gimbal_hil.knowledge.discrepancy.twin import Floats
from gimbal_hil.knowledge.estimation import block_sums, decorrelation_rows

#: stretches of a log; blocks of a stretch of which the error of its strength is read, at least, and correlated rows in
#: one, if so many lie there
_STRETCHES, _BLOCKS, _A_BLOCK = 6, 4, 3.0


def unevenness(inquiry: Inquiry, without: State, state: State) -> float:
    """Standard deviation of a cause's strength over stretches of all logs, beyond chance, as a share of its strength;
    of the channel on which it does most: what it takes of others may be by what gives way to it.

    `without` is the state once the cause is taken away, everything else as it stands.
    """
    logs = list(_logs(inquiry, without, state))
    if not logs:
        return 0.0
    channel = int(np.argmax(sum(np.sum(does**2, axis=0) for does, _ in logs)))
    stretches = np.vstack([np.zeros((0, 3)), *(_strengths(does[:, channel], left[:, channel]) for does, left in logs)])
    if len(stretches) < _STRETCHES:
        return 0.0
    strength, error, own = stretches.T
    weight = own / np.sum(own)
    # one over how many stretches of equal weight these are worth
    mean, few = float(weight @ strength), float(weight @ weight)
    spread = float(weight @ (strength - mean) ** 2) / max(1.0 - few, 1e-9)
    # two standard errors of a variance that is known from so many stretches
    chance = float(weight @ error) * (1.0 + 2.0 * np.sqrt(2.0 * few))
    return float(np.sqrt(max(0.0, spread - chance))) / max(abs(mean), 1e-9)


def _strengths(does: Floats, left: Floats) -> Floats:
    """(strength, its squared error, squares of what the cause does) of every stretch of one log, (stretches, 3).

    The strength is one and the slope, over what the cause does, of what is left beside it.
    """
    power = np.cumsum(does**2)
    ends = np.searchsorted(power, float(does @ does) * np.arange(1, _STRETCHES) / _STRETCHES)
    parts = [part for part in np.split(np.arange(len(does)), ends) if len(part) >= 2 * _BLOCKS]
    own = np.array([float(does[part] @ does[part]) for part in parts])
    if not len(own) or np.min(own) <= 0.0:
        return np.zeros((0, 3))
    slopes = np.array([float(does[part] @ left[part]) for part in parts]) / own
    # within a stretch what is left beside its own strength is noise, however much that is another than the mean
    noise = [does[part] * (left[part] - slope * does[part]) for part, slope in zip(parts, slopes, strict=True)]
    wanted = _A_BLOCK * decorrelation_rows(np.concatenate(noise))
    squares = 0.0
    for part in noise:
        length = int(np.clip(np.ceil(wanted), 1, len(part) // _BLOCKS))
        sums = block_sums(part, length)
        # of a block that is shorter than rows are correlated over, sums say too little; nor does the last part of one
        longer = max(1.0, wanted / length) * len(part) / (len(sums) * length)
        squares += longer * float(np.sum(sums**2)) * len(sums) / (len(sums) - 1)
    return np.column_stack([1.0 + slopes, squares / np.sum(own) / own, own])


def _logs(inquiry: Inquiry, without: State, state: State) -> Iterator[tuple[Floats, Floats]]:
    """What a cause does and what is left beside it, (rows, channels) of each log, fitted ones first; a log that the
    twin cannot carry without the cause, or with it, says nothing of its strength.
    """
    cuts = np.cumsum(inquiry.held_counts)[:-1]
    bare = [*inquiry.split(without.fitted), *np.split(inquiry.in_order(without), cuts)]
    left = [*inquiry.split(state.fitted), *np.split(inquiry.in_order(state), cuts)]
    for one, other in zip(bare, left, strict=True):
        if max(np.max(np.abs(one), initial=0.0), np.max(np.abs(other), initial=0.0)) < BROKEN:
            yield one - other, other
