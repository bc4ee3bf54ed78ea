"""What the data cannot say about a named effect's law: two forms of a drag that depends on direction, and how alike
they are here.

|v| and v^2 are both even in the rate. Over the speeds of one log their torques may be the same curve twice; the name
then stands, but the law at other speeds does not follow from it.
"""

from __future__ import annotations

import math

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import STEP, Fit, Hypothesis, command_residual
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Floats, scored
from sim_backend.effects import CATALOGUE

#: canonical correlation above which two forms are the same on this data
_ALIKE = 0.95


def undetermined_form(inquiry: Inquiry, fit: Fit, index: int) -> dict[str, object] | None:
    """The forms of a named effect that the fitted data cannot tell apart, and their correlation; None where it can, or
    has one form.
    """
    effect, axis = fit.hypothesis.labels[index]
    forms = CATALOGUE[effect].forms
    if len(forms) < 2:
        return None
    column = next(j for j, c in enumerate(inquiry.twin.channels) if c.axis == axis and c.signal == TORQUE)
    i = inquiry.twin.model.axes.index(axis)
    speeds = [np.abs(record.motion[:, 2 + i]) for record in inquiry.twin.records]
    one, two = (
        np.concatenate(
            [
                scored(s[:, None] ** form.power, r.bands)[r.keep]
                for s, r in zip(speeds, inquiry.twin.records, strict=True)
            ]
        )
        for form in forms[:2]
    )
    correlation = _canonical(one, two, _beside(inquiry, fit, index, column))
    if correlation <= _ALIKE:
        return None
    return {"between": [form.text for form in forms[:2]], "canonical_correlation": round(correlation, 4)}


def _beside(inquiry: Inquiry, fit: Fit, index: int, column: int) -> Floats:
    """What everything else in the hypothesis can do on one channel, (rows, coordinates)."""
    x = fit.hypothesis.vector()
    first = sum(len(cause.x) for cause in fit.hypothesis.causes[:index])
    own = set(range(first, first + len(fit.hypothesis.causes[index].x)))
    columns = [np.ones(len(fit.residual))]
    for k in range(len(x)):
        if k not in own:
            columns.append(_moved(inquiry, fit.hypothesis, x, k)[:, column] - fit.residual[:, column])
    return np.column_stack(columns)


def _moved(inquiry: Inquiry, hypothesis: Hypothesis, x: Floats, k: int) -> Floats:
    moved = x.copy()
    moved[k] += STEP
    return command_residual(inquiry.twin, hypothesis.at(moved), inquiry.floor)


def _canonical(one: Floats, two: Floats, beside: Floats) -> float:
    """Correlation of two columns after what stands beside them has been projected out of both."""
    scale = np.linalg.norm(beside, axis=0)
    basis, _ = np.linalg.qr(beside[:, scale > 0.0] / scale[scale > 0.0])
    a, b = (c.ravel() - basis @ (basis.T @ c.ravel()) for c in (one, two))
    size = math.sqrt(float(a @ a) * float(b @ b))
    return abs(float(a @ b)) / size if size > 0.0 else 0.0
