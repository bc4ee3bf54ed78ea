"""Friction whose level wanders by a fraction of a per cent: noise below the band, which no floor read above it can
know.

The remainder is compared, block by block, with what a change of all friction levels by one per cent would do. If a
level that wanders by no more than a real joint's does takes it to the floor, nothing is missing: a name could not be
found for it, and no model can have it.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.discrepancy.evidence import torque_residual
from gimbal_hil.discrepancy.hypothesis import parameters_of
from gimbal_hil.discrepancy.inquiry import Inquiry, State, rms
from gimbal_hil.discrepancy.number_slots import read_number, write_number
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.twin import Twin

#: blocks in which a level is one number, s; and how far levels wander at most (standard deviation, share)
_BLOCK_S, _MOST = 1.0, 0.02
_LEVELS = ("friction.coulomb", "friction.breakaway", "friction.viscous")
_CHANGE = 0.01


def left_beside_wander(inquiry: Inquiry, state: State) -> Floats:
    """Rms per channel, in floors, of what wandering friction levels leave of a state; unchanged where they would wander
    too far.
    """
    found = []
    for twin in (inquiry.twin, inquiry.holdout):
        rows = torque_residual(twin, state.hypothesis, inquiry.floor)
        found.append(_beside(twin, rows, _friction(twin, state, inquiry.floor)))
    return np.max(found, axis=0)


def _friction(twin: Twin, state: State, floor: Floats) -> Floats:
    """What all friction levels of all axes do per unit of their size, (rows, channels)."""
    structure, P = parameters_of(twin, state.hypothesis)
    moved = P.copy()
    for axis in twin.model.axes:
        for path in _LEVELS:
            write_number(twin.model, moved, axis, path, (1.0 + _CHANGE) * read_number(twin.model, P, axis, path))
    return np.asarray((twin.residual(structure, moved) - twin.residual(structure, P)) / (_CHANGE * floor))


def _beside(twin: Twin, rows: Floats, friction: Floats) -> Floats:
    bands = twin.records[0].bands
    length = max(4, int(_BLOCK_S / (bands.stride * bands.period_s)))
    starts = np.arange(0, len(rows), length)
    products = np.add.reduceat(friction * rows, starts)
    power = np.maximum(np.add.reduceat(friction**2, starts), 1e-300)
    level = products / power
    left = rows - friction * np.repeat(level, np.diff([*starts, len(rows)]), axis=0)
    # blocks are known as well as friction stands above the noise in them
    sure = power > np.median(power, axis=0)
    wanders = np.array(
        [float(np.std(level[sure[:, j], j])) if np.any(sure[:, j]) else np.inf for j in range(rows.shape[1])]
    )
    return np.where(wanders <= _MOST, rms(left), rms(rows))
