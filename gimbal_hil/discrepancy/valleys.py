"""Numbers of one cause that trade against each other (a gap and its rotor): followed along their valley, which is bent and bumpy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimbal_hil.discrepancy.hypothesis import Hypothesis
from gimbal_hil.discrepancy.search import Scored, Search

#: steps of the last refit
_POLISHING = 30
#: most steps along a valley, each with a refit; how many of them in a row may lead nowhere, and what is lower
_ALONG_VALLEY, _BUMPS, _LOWER = 8, 2, 0.998
#: what is no worse: a gap that is never crossed has no size, and the smallest that will do is told
_NO_WORSE = 1.002


def polished(search: Search, state: Scored) -> Scored:
    """A state at the bottom of its valleys: numbers that act together get there in small steps only."""
    best = search.refitted(state.hypothesis, _POLISHING, 1e-6)
    for index, cause in enumerate(state.hypothesis.causes):
        if cause.family.valley:
            best = _least_gap(search, _bottom(search, best, index), index)
    return best


def further(search: Search, state: Scored, index: int, step: float) -> Scored:
    """A state so many steps along the valley of one cause, its other numbers and the other causes refitted."""
    return search.refitted(_along(state.hypothesis, index, step), rounds=2)


def _bottom(search: Search, best: Scored, index: int) -> Scored:
    """The lowest place along the valley; its floor is bumpy, since impacts come and go."""
    for side in (1.0, -1.0):
        here, since = best, 0
        for _ in range(_ALONG_VALLEY):
            here = search.refitted(_along(here.hypothesis, index, side))
            best, since = (here, 0) if here.cost < _LOWER * best.cost else (best, since + 1)
            if since == _BUMPS:
                break
    return best


def _least_gap(search: Search, best: Scored, index: int) -> Scored:
    """The smallest of the family's starting gaps that does as well."""
    cause = best.hypothesis.causes[index]
    for gap in sorted({start.base[0] for start in cause.family.starts if start.base[0] < cause.x[0]}):
        smaller = replace(cause, x=(gap, *cause.x[1:]))
        causes = tuple(smaller if i == index else other for i, other in enumerate(best.hypothesis.causes))
        tried = search.refitted(replace(best.hypothesis, causes=causes))
        if tried.cost < _NO_WORSE * best.cost:
            return tried
    return best


def _along(hypothesis: Hypothesis, index: int, step: float) -> Hypothesis:
    """A hypothesis with one cause so many steps further along its valley."""
    vector, first = hypothesis.vector(), sum(len(cause.x) for cause in hypothesis.causes[:index])
    valley = hypothesis.causes[index].family.valley
    vector[first : first + len(valley)] += step * np.array(valley)
    return hypothesis.at(vector)
