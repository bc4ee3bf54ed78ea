"""Friction whose level wanders by a fraction of a per cent, and an offset that drifts: noise below the band, which no
floor read above it can know.

Coloured noise in the sense of a Gaussian process: the friction torque times a share that changes over some tenths of a
second, and a torque that changes over seconds. Both are estimated from what a state leaves (least squares on knots with
straight lines between them). Where they are no larger than a real joint's and take the remainder to the noise, nothing
is missing: no model can have them, and no name could be found.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.discrepancy.hypotheses import Hypothesis, parameters_of, torque_residual
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State
from gimbal_hil.knowledge.discrepancy.twin import Floats, Twin, read_number, write_number

if TYPE_CHECKING:
    from scipy.sparse import csr_array

#: knots of the friction's level and of the drift, s; and how far both wander at most (standard deviation over friction)
_LEVEL_S, _DRIFT_S, _MOST = 0.3, 2.0, 0.02
_LEVELS = ("friction.coulomb", "friction.breakaway", "friction.viscous")
_CHANGE = 0.01
#: of states that somebody still has, with the logs and floors that it was asked of: every gap asks for it
_found: WeakKeyDictionary[State, tuple[tuple[object, ...], tuple[Wander, Wander]]] = WeakKeyDictionary()


def left_beside_wander(inquiry: Inquiry, state: State) -> Floats:
    """Rms per channel, in floors, of what wandering friction levels leave of a state; unchanged where they would wander
    too far.
    """
    both = ((inquiry.twin, state.hypothesis), (inquiry.holdout, state.held))
    return beside_wander(inquiry, state, *(torque_residual(twin, one, inquiry.floor) for twin, one in both))


def beside_wander(inquiry: Inquiry, state: State, fitted: Floats, held: Floats) -> Floats:
    """The same of rows of the fitted logs and of the hold-out."""
    both = zip(wander_beside(inquiry, state), (fitted, held), strict=True)
    return np.max([wander.left(rows) for wander, rows in both], axis=0)


@dataclass(frozen=True)
class _Knots:
    """Least squares on the knots of one channel of one log: what they do, (rows, knots), two of each kind in a row; the
    inverse normal matrix, (knots, knots); how many of them are levels of friction, and the freedom that is left.
    """

    columns: csr_array
    inverse: Floats
    levels: int
    freedom: float


@dataclass(frozen=True)
class Wander:
    """What friction levels that wander could do to the logs of a twin, for any rows that it leaves."""

    #: rows of every log but the last, added up
    ends: NDArray[np.int64]
    #: by log and channel; None where friction does nothing
    knots: tuple[tuple[_Knots | None, ...], ...]

    def left(self, rows: Floats) -> Floats:
        """Rms per channel, in floors, of what is left of rows, (rows, channels): the largest over the logs."""
        logs = zip(np.split(rows, self.ends), self.knots, strict=True)
        return np.max([[_left(part[:, j], one) for j, one in enumerate(knots)] for part, knots in logs], axis=0)


def wander_of(twin: Twin, hypothesis: Hypothesis, floor: Floats) -> Wander:
    """What friction levels of a hypothesis that wander could do."""
    ends = np.cumsum([int(record.keep.sum()) for record in twin.records])[:-1]
    bands = twin.records[0].bands
    row_s = bands.stride * bands.period_s
    logs = np.split(_friction(twin, hypothesis, floor), ends)
    return Wander(ends, tuple(tuple(_knots(log[:, j], row_s) for j in range(log.shape[1])) for log in logs))


def wander_beside(inquiry: Inquiry, state: State) -> tuple[Wander, Wander]:
    """The same of a state, on the fitted logs and on the hold-out."""
    twins, floor = (inquiry.twin, inquiry.holdout), inquiry.floor
    logs = *twins, floor
    found = _found.get(state)
    if found is None or any(one is not other for one, other in zip(found[0], logs, strict=True)):
        fitted, held = (wander_of(twin, state.hypothesis, floor) for twin in twins)
        found = _found[state] = logs, (fitted, held)
    return found[1]


def _friction(twin: Twin, hypothesis: Hypothesis, floor: Floats) -> Floats:
    """What all friction levels of all axes do per unit of their size, (rows, channels)."""
    structure, P = parameters_of(twin, hypothesis)
    moved = P.copy()
    for axis in twin.model.axes:
        for path in _LEVELS:
            write_number(twin.model, moved, axis, path, (1.0 + _CHANGE) * read_number(twin.model, P, axis, path))
    return np.asarray((twin.residual(structure, moved) - twin.residual(structure, P)) / (_CHANGE * floor))


def _knots(friction: Floats, row_s: float) -> _Knots | None:
    size = float(np.sqrt(np.mean(friction**2)))
    if size == 0.0:
        return None
    from scipy.sparse import hstack

    rows = len(friction)
    level = _between_knots(friction, _LEVEL_S / row_s)
    columns = hstack([level, _between_knots(np.full(rows, size), _DRIFT_S / row_s)], format="csr")
    own = (columns.T @ columns).toarray()
    # in floors noise is one: a knot which hardly any row speaks of stays where its prior has it
    inverse = np.linalg.inv(own + np.eye(len(own)) / _MOST**2)
    freedom = max(rows - float(np.sum(inverse * own)), 1.0)
    return _Knots(columns, inverse, level.shape[1], freedom)


def _left(rows: Floats, knots: _Knots | None) -> float:
    """What is left of one channel of one log, (rows,)."""
    if knots is not None:
        shares = knots.inverse @ (knots.columns.T @ rows)
        parts = np.split(shares, [knots.levels])
        if max(float(np.mean(part**2)) for part in parts) <= _MOST**2:
            return float(np.sqrt(np.sum((rows - knots.columns @ shares) ** 2) / knots.freedom))
    return float(np.sqrt(np.mean(rows**2)))


def _between_knots(size: Floats, spacing: float) -> csr_array:
    """Weights of evenly spaced knots at every row, straight lines between them, times what they are of, (rows,);
    (rows, knots).
    """
    from scipy.sparse import csr_array

    rows = np.arange(len(size))
    at = rows / max(spacing, 1.0)
    first = np.floor(at).astype(int)
    weights = np.concatenate([(1.0 - (at - first)) * size, (at - first) * size])
    places = np.concatenate([rows, rows]), np.concatenate([first, first + 1])
    return csr_array((weights, places), shape=(len(size), int(first[-1]) + 2))
