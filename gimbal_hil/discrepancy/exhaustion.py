"""Is the shape exhausted? Whether what an explanation leaves can still be predicted from the variables that a cause
acts through.

A generic regression (boosted trees, scikit-learn) learns the remainder of the fitted logs from position, rate,
acceleration, torque, temperature, base motion or time, and is asked for that of the hold-out, which it has not seen.
The same remainder shifted in time is its negative control. A spring that was named where a stop hardens leaves torque
over position that can be predicted; beside a true one there is nothing left to learn from position, though other things
may remain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimbal_hil.discrepancy.inquiry import Inquiry, State
from gimbal_hil.discrepancy.origin import placed
from gimbal_hil.discrepancy.record import Record
from gimbal_hil.discrepancy.smoothing import Floats
from sim_backend.effects import Variable

#: rows that a regression is taught with at most, and shares of the remainder's length by which the controls are shifted
_MOST_ROWS, _SHIFTS = 6000, (0.31, 0.57)
#: times before a row at which variables with memory are also shown, s
_MEMORY_S = (0.02, 0.05, 0.12, 0.3, 0.7)


@dataclass(frozen=True)
class Predictable:
    """Share of a channel's remainder that a group of variables predicts on the hold-out, and what it predicts of the
    control.
    """

    share: float
    control: float

    @property
    def beyond(self) -> float:
        """The share beyond the control."""
        return max(0.0, self.share - max(0.0, self.control))


def predictable(inquiry: Inquiry, state: State, column: int, variables: frozenset[Variable]) -> Predictable:
    """How much of one channel's remainder some variables predict on the whole hold-out."""
    axis = inquiry.twin.model.axes.index(inquiry.twin.channels[column].axis)
    taught = _inputs(placed(inquiry.twin.records, state.hypothesis), axis, variables)
    asked = _inputs(placed(inquiry.holdout.records, state.held), axis, variables)
    y = state.fitted[:, column]
    target = inquiry.in_order(state)[:, column]
    total = float(np.mean(target**2))
    shares = []
    for shift in (0.0, *_SHIFTS):
        learnt = _learnt(taught, np.roll(y, int(shift * len(y))), asked)
        shares.append(1.0 - float(np.mean((target - learnt) ** 2)) / max(total, 1e-300))
    return Predictable(shares[0], max(shares[1:]))


def _learnt(x: Floats, y: Floats, asked: Floats) -> Floats:
    """What is expected at rows `asked` by what has learnt y of rows x."""
    from sklearn.ensemble import HistGradientBoostingRegressor
    from threadpoolctl import threadpool_limits

    thin = max(1, len(y) // _MOST_ROWS)
    settings = dict(
        max_iter=60,
        learning_rate=0.1,
        max_leaf_nodes=16,
        min_samples_leaf=25,
        l2_regularization=1.0,
        early_stopping=False,
    )
    # the same bits whatever the number of processors, and none of them spins for another
    with threadpool_limits(1):
        learnt = HistGradientBoostingRegressor(random_state=0, **settings).fit(x[::thin], y[::thin])
        return np.asarray(learnt.predict(asked))


def _inputs(records: tuple[Record, ...], axis: int, variables: frozenset[Variable]) -> Floats:
    return np.concatenate([np.column_stack(_columns(record, axis, variables)) for record in records])


def _columns(record: Record, axis: int, variables: frozenset[Variable]) -> Sequence[Floats]:
    """The variables of one record at its scored rows."""
    motion, out = record.motion, []
    period_s = record.bands.period_s
    if Variable.POSITION in variables:
        out += [motion[:, axis]]
    if Variable.RATE in variables:
        out += [motion[:, 2 + axis]]
    if Variable.POSITION in variables:
        out += [np.sign(motion[:, 2 + axis])]
    if Variable.ACCELERATION in variables:
        out += [motion[:, 4 + axis]] + [_earlier(motion[:, 4 + axis], s, period_s) for s in _MEMORY_S]
    if Variable.TORQUE in variables:
        out += [record.torque[:, axis]] + [_earlier(record.torque[:, axis], s, period_s) for s in _MEMORY_S]
    if Variable.TEMPERATURE in variables:
        out += [record.heat[:, axis], motion[:, 2 + axis]]
    if Variable.BASE_MOTION in variables:
        out += [record.base[:, k] for k in range(9)] + [motion[:, k] for k in range(6)]
    if Variable.TIME in variables:
        out += [np.asarray(np.arange(len(motion)) * period_s, np.float64)]
    return [record.at_scored(column) for column in out]


def _earlier(column: Floats, seconds: float, period_s: float) -> Floats:
    rows = max(1, round(seconds / period_s))
    return np.concatenate([np.full(min(rows, len(column)), column[0]), column[:-rows]])[: len(column)]
