"""Is the shape exhausted? Whether what an explanation leaves can still be predicted from the variables that a cause
acts through.

Two generic regressions (scikit-learn: boosted trees, and a penalised line) learn the remainder of the fitted logs from
position, rate, acceleration, torque, temperature, base motion, time, the past or the other axis' torque, and are asked
for that of the hold-out, which they have not seen; the better one counts. The same remainder shifted in time is their
negative control. A spring that was named where a stop hardens leaves torque over position that can be predicted, and
friction of grease that was worked leaves torque that goes with recent motion; beside a true cause there is nothing left
to learn from its variables, though other things may remain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import placed
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State
from gimbal_hil.knowledge.discrepancy.twin import Floats, Record
from sim_backend.effects import Variable

#: rows that a regression is taught with at most, and shares of the remainder's length by which the controls are shifted
_MOST_ROWS, _SHIFTS = 6000, (0.31, 0.57)
#: times before a row at which variables with memory are also shown, s
_MEMORY_S = (0.02, 0.05, 0.12, 0.3, 0.7)
#: what the past is shown as: slacks, shares of the travel, and times over which recent motion is averaged, s
_SLACKS, _RECENT_S = (0.003, 0.01, 0.03, 0.1, 0.3), (1.0, 5.0, 20.0)
#: penalties of the line, parts of the fitted logs that choose among them, rows below which it is none, and rows that a
#: slack is followed over
_PENALTIES, _FOLDS, _FEW_ROWS, _FOLLOWED = np.logspace(0.0, 5.0, 6), 3, 30, 20000


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
    fitted, held = placed(inquiry.twin.records, state.hypothesis), placed(inquiry.holdout.records, state.held)
    # a slack is the same one in every log
    travel = max(float(np.ptp(record.motion[:, axis])) for record in fitted)
    taught, asked = (_inputs(records, axis, variables, travel) for records in (fitted, held))
    if not taught.shape[1]:
        # nothing here says that of a log: one axis has no other
        return Predictable(0.0, 0.0)
    y = state.fitted[:, column]
    target = inquiry.in_order(state)[:, column]
    total = float(np.mean(target**2))
    shares = []
    for shift in (0.0, *_SHIFTS):
        rolled = np.roll(y, int(shift * len(y)))
        both = (learn(taught, rolled, asked) for learn in (_by_trees, _by_a_line))
        shares.append(max(1.0 - float(np.mean((target - learnt) ** 2)) / max(total, 1e-300) for learnt in both))
    return Predictable(shares[0], max(shares[1:]))


def _by_trees(x: Floats, y: Floats, asked: Floats) -> Floats:
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


def _by_a_line(x: Floats, y: Floats, asked: Floats) -> Floats:
    """The same by a line in the variables, penalised as far as blocks of the fitted logs ask for."""
    from sklearn.linear_model import RidgeCV
    from sklearn.model_selection import KFold
    from threadpoolctl import threadpool_limits

    mean, spread = np.mean(x, axis=0), np.std(x, axis=0)
    moves = spread > 1e-9 * np.maximum(np.max(np.abs(x), axis=0), np.max(np.abs(asked), axis=0))
    if not np.any(moves) or len(y) < _FEW_ROWS:
        return np.full(len(asked), float(np.mean(y)))
    x, asked = ((one[:, moves] - mean[moves]) / spread[moves] for one in (x, asked))
    thin = max(1, len(y) // _MOST_ROWS)
    with threadpool_limits(1):
        learnt = RidgeCV(_PENALTIES, cv=KFold(_FOLDS)).fit(x[::thin], y[::thin])
        return np.asarray(learnt.predict(asked))


def _inputs(records: tuple[Record, ...], axis: int, variables: frozenset[Variable], travel: float) -> Floats:
    """The variables of all scored rows, (rows, columns)."""
    logs = [_columns(record, axis, variables, travel) for record in records]
    return np.concatenate([np.column_stack(columns) if columns else np.zeros((0, 0)) for columns in logs])


def _columns(record: Record, axis: int, variables: frozenset[Variable], travel: float) -> Sequence[Floats]:
    """The variables of one record at its scored rows; `travel` is that of all fitted logs."""
    motion, out = record.motion, []
    period_s = record.bands.period_s
    if Variable.POSITION in variables:
        out += [motion[:, axis]]
    if Variable.RATE in variables:
        out += [motion[:, 2 + axis]]
    if variables & {Variable.POSITION, Variable.DIRECTION}:
        out += [np.sign(motion[:, 2 + axis])]
    if Variable.ACCELERATION in variables:
        out += [motion[:, 4 + axis]] + [_earlier(motion[:, 4 + axis], s, period_s) for s in _MEMORY_S]
    if Variable.TORQUE in variables:
        out += [record.torque[:, axis]] + [_earlier(record.torque[:, axis], s, period_s) for s in _MEMORY_S]
    if Variable.TEMPERATURE in variables:
        out += [record.heat[:, axis], motion[:, 2 + axis]]
    if Variable.BASE_MOTION in variables:
        out += [record.base[:, k] for k in range(9)] + [motion[:, k] for k in range(6)]
    if Variable.OTHER_TORQUE in variables:
        out += [torque for k, torque in enumerate(record.torque.T) if k != axis]
    if Variable.PAST in variables:
        out += _past(motion[:, axis], motion[:, 2 + axis], period_s, travel)
    if Variable.TIME in variables:
        out += [np.asarray(np.arange(len(motion)) * period_s, np.float64)]
    return [record.at_scored(column) for column in out]


def _earlier(column: Floats, seconds: float, period_s: float) -> Floats:
    rows = max(1, round(seconds / period_s))
    return np.concatenate([np.full(min(rows, len(column)), column[0]), column[:-rows]])[: len(column)]


def _past(position: Floats, rate: Floats, period_s: float, travel: float) -> list[Floats]:
    """How far what is dragged along with slack hangs back, which is the memory of every hysteresis; and how much a
    joint moved of late, which works or warms what it moves in, by itself and times rate and direction.
    """
    from scipy.signal import lfilter

    found = [_hanging_back(position, share * travel) for share in _SLACKS]
    for seconds in _RECENT_S:
        forgets = float(np.exp(-period_s / seconds))
        recent = np.asarray(lfilter([1.0 - forgets], [1.0, -forgets], np.abs(rate)))
        found += [recent, recent * rate, recent * np.sign(rate)]
    return found


def _hanging_back(position: Floats, slack: float) -> Floats:
    """How far something hangs back that is dragged along with slack on either side."""
    thin = max(1, len(position) // _FOLLOWED)
    found, at = [], float(position[0])
    for now in position[::thin].tolist():
        at = min(max(at, now - slack), now + slack)
        found.append(now - at)
    return np.repeat(found, thin)[: len(position)]
