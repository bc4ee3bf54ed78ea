"""Effects of the catalogue that these data cannot show, with the reason."""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import present_in
from gimbal_hil.knowledge.discrepancy.judgement import Result
from gimbal_hil.knowledge.discrepancy.verdict.separating import UPRIGHT, why_not_testable
from sim_backend.effects import CATALOGUE, Variable
from sim_backend.model import stands_upright

#: a response below this many floors at a generous size leaves no trace; with more starts than this, one of them may yet
_NO_TRACE, _FEW_STARTS = 0.15, 3


def not_testable(result: Result) -> list[dict[str, str]]:
    """Effects that this data cannot show, per axis."""
    inquiry, model = result.inquiry, result.model
    heard: dict[tuple[str, str], float] = {}
    for response in result.path.heard:
        size = float(np.sqrt(np.mean(response.columns**2, axis=0)).max())
        heard[response.family.label] = max(heard.get(response.family.label, 0.0), size)
    searched = {family.label: family for family in inquiry.families}
    mentioned = {label for one in result.told for label in (one.standing.label, *(rival.label for rival in one.close))}
    found = []
    for axis in model.axes:
        present = present_in(model, axis, inquiry.twin.records)
        for name, effect in CATALOGUE.items():
            if (
                (name, axis) in mentioned
                or (effect.rotary_only and model.is_linear)
                or (effect.two_axis_only and len(model.axes) < 2)
            ):
                continue
            family = searched.get((name, axis))
            if family is None and (
                name in result.request.without or (result.request.only and name not in result.request.only)
            ):
                continue
            silent = family is not None and not family.ripple and len(family.starts) <= _FEW_STARTS
            if family is None or (silent and heard.get((name, axis), 0.0) < _NO_TRACE):
                weight = Variable.ATTITUDE in effect.acts_through
                reason = UPRIGHT if weight and stands_upright(model) else why_not_testable(name, present)
                found.append({"name": name, "axis": axis, "reason": reason})
    return found
