"""Where position is zero: an incremental encoder starts every log anew, and a ripple then keeps its order and amplitude
while its phase is another one in every log.

Where nothing in the model depends on position (no gravity, no spring) the zero of an axis is a convention of each log.
There a hypothesis with a ripple has one more number for every log but the first fitted one: the shift of its position.
In a log that judges, the shift is fitted on the rows that select.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.discrepancy.hypotheses.hypothesis import Hypothesis, Origin, parameters_of
from gimbal_hil.knowledge.discrepancy.twin import Floats, Record, Twin, searched_name
from sim_backend.effects import NEUTRAL_ORDER
from sim_backend.model import position_has_a_zero

#: the record whose zero the others are measured against
_REFERENCE = searched_name(0)
#: shifts tried within a period of the highest order, and at most; halvings of the distance between them after that
_A_PERIOD, _MOST_TRIED, _HALVINGS = 8, 64, 4


def placed(records: tuple[Record, ...], hypothesis: Hypothesis) -> tuple[Record, ...]:
    """Records with their positions counted from the zero of the first."""
    shifts = {(origin.record, origin.axis): origin.shift for origin in hypothesis.origins}
    return tuple(_moved(r, [shifts.get((r.name, axis), 0.0) for axis in range(2)]) for r in records)


def aligned(
    twin: Twin,
    hypothesis: Hypothesis,
    floor: Floats,
    scale: tuple[float, ...],
    counted: NDArray[np.bool_] | None = None,
) -> Hypothesis:
    """The hypothesis with a shift for every log of a twin that needs one and has none: the best of those within a
    period of its ripple.

    `scale` are the channels' noises in floors; `counted` are the scored rows that count, (rows,), all where None.
    """
    for axis in sorted({twin.model.axes.index(c.family.axis) for c in hypothesis.causes if c.family.ripple}):
        if position_has_a_zero(twin.model, twin.model.axes[axis]):
            continue
        present = {origin.record for origin in hypothesis.origins if origin.axis == axis}
        first = 0
        for which, record in enumerate(twin.records):
            rows = int(record.keep.sum())
            mine = np.ones(rows, dtype=bool) if counted is None else counted[first : first + rows]
            first += rows
            if record.name != _REFERENCE and record.name not in present:
                hypothesis = _with_best_shift(twin, hypothesis, which, axis, floor * np.array(scale), mine)
    return hypothesis


def _with_best_shift(
    twin: Twin, hypothesis: Hypothesis, which: int, axis: int, noise: Floats, counted: NDArray[np.bool_]
) -> Hypothesis:
    orders = [abs(o) for o in _orders(hypothesis, twin.model.axes[axis]) if o != 0.0]
    if not orders:
        return hypothesis
    structure, P = parameters_of(twin, hypothesis)
    record = twin.records[which]

    def cost(shift: float) -> float:
        shifts = [shift if i == axis else 0.0 for i in range(2)]
        left = twin.evaluated(structure, P, _moved(record, shifts))
        return float(np.sum((twin.scored_rows(left, which)[counted] / noise) ** 2))

    step = 2.0 * math.pi / max(orders) / _A_PERIOD
    tried = min(_MOST_TRIED, math.ceil(2.0 * math.pi / min(orders) / step))
    step = 2.0 * math.pi / min(orders) / tried
    costs = {k * step: cost(k * step) for k in range(-(tried // 2), tried - tried // 2)}
    best = min(costs, key=lambda shift: costs[shift])
    for _ in range(_HALVINGS):
        step *= 0.5
        costs |= {shift: cost(shift) for shift in (best - step, best + step)}
        best = min(costs, key=lambda shift: costs[shift])
    return replace(hypothesis, origins=(*hypothesis.origins, Origin(record.name, axis, best, 1.0 / min(orders))))


def _orders(hypothesis: Hypothesis, axis: str) -> list[float]:
    """Orders of the ripples on an axis, 1/rad or 1/m."""
    found = []
    for cause in hypothesis.causes:
        if cause.family.ripple and cause.family.axis == axis:
            knobs = zip(cause.family.knobs, cause.x, strict=True)
            found += [knob.moved(NEUTRAL_ORDER, x) for knob, x in knobs if "order" in knob.parameters]
    return found


def _moved(record: Record, shifts: list[float]) -> Record:
    if not any(shifts):
        return record
    motion = record.motion.copy()
    motion[:, :2] += shifts
    return replace(record, motion=motion)
