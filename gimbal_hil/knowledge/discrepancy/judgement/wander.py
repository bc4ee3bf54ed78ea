"""Friction whose level wanders by a fraction of a per cent, and an offset that drifts: noise below the band, which no
floor read above it can know.

Coloured noise in the sense of a Gaussian process: the friction torque times a share that changes over some tenths of a
second, and a torque that changes over seconds. Both are estimated from what a state leaves (least squares on knots with
straight lines between them). Where they are no larger than a real joint's and take the remainder to the noise, nothing
is missing: no model can have them, and no name could be found.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import parameters_of, torque_residual
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State, rms
from gimbal_hil.knowledge.discrepancy.twin import Floats, Twin, read_number, write_number

#: knots of the friction's level and of the drift, s; and how far both wander at most (standard deviation over friction)
_LEVEL_S, _DRIFT_S, _MOST = 0.3, 2.0, 0.02
_LEVELS = ("friction.coulomb", "friction.breakaway", "friction.viscous")
_CHANGE = 0.01


def left_beside_wander(inquiry: Inquiry, state: State) -> Floats:
    """Rms per channel, in floors, of what wandering friction levels leave of a state; unchanged where they would wander
    too far.
    """
    both = ((inquiry.twin, state.hypothesis), (inquiry.holdout, state.held))
    return beside_wander(inquiry, state, *(torque_residual(twin, one, inquiry.floor) for twin, one in both))


def beside_wander(inquiry: Inquiry, state: State, fitted: Floats, held: Floats) -> Floats:
    """The same of rows of the fitted logs and of the hold-out."""
    found = []
    for twin, rows in ((inquiry.twin, fitted), (inquiry.holdout, held)):
        friction = _friction(twin, state, inquiry.floor)
        ends = np.cumsum([int(record.keep.sum()) for record in twin.records])[:-1]
        logs = zip(np.split(rows, ends), np.split(friction, ends), strict=True)
        bands = twin.records[0].bands
        left = [_beside(*log, bands.stride * bands.period_s) for log in logs]
        found.append(np.max(left, axis=0))
    return np.max(found, axis=0)


def _friction(twin: Twin, state: State, floor: Floats) -> Floats:
    """What all friction levels of all axes do per unit of their size, (rows, channels)."""
    structure, P = parameters_of(twin, state.hypothesis)
    moved = P.copy()
    for axis in twin.model.axes:
        for path in _LEVELS:
            write_number(twin.model, moved, axis, path, (1.0 + _CHANGE) * read_number(twin.model, P, axis, path))
    return np.asarray((twin.residual(structure, moved) - twin.residual(structure, P)) / (_CHANGE * floor))


def _beside(rows: Floats, friction: Floats, row_s: float) -> Floats:
    """What is left of one log, (rows, channels), per channel."""
    left = rms(rows)
    level, drift = _between_knots(len(rows), _LEVEL_S / row_s), _between_knots(len(rows), _DRIFT_S / row_s)
    for j in range(rows.shape[1]):
        size = float(np.sqrt(np.mean(friction[:, j] ** 2)))
        if size == 0.0:
            continue
        columns = np.hstack([level * friction[:, j : j + 1], drift * size])
        own = columns.T @ columns
        # in floors noise is one: a knot which hardly any row speaks of stays where its prior has it
        held = np.linalg.inv(own + np.eye(len(own)) / _MOST**2)
        shares = held @ (columns.T @ rows[:, j])
        freedom = max(len(rows) - float(np.trace(held @ own)), 1.0)
        parts = np.split(shares, [level.shape[1]])
        if max(float(np.mean(knots**2)) for knots in parts) <= _MOST**2:
            left[j] = np.sqrt(float(np.sum((rows[:, j] - columns @ shares) ** 2)) / freedom)
    return left


def _between_knots(rows: int, spacing: float) -> Floats:
    """Weights of evenly spaced knots at every row, straight lines between them, (rows, knots)."""
    at = np.arange(rows) / max(spacing, 1.0)
    first = np.floor(at).astype(int)
    weights = np.zeros((rows, int(first[-1]) + 2))
    weights[np.arange(rows), first] = 1.0 - (at - first)
    weights[np.arange(rows), first + 1] = at - first
    return weights
