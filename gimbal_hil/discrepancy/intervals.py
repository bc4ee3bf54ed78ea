"""Intervals of parameters: blockwise sandwich covariance, so that correlated rows and repeatable misfit widen them.

Numbers that trade against each other (a gap and its rotor) are followed along their valley as far as the data cannot tell.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.discrepancy.fit import prior_weights, refit
from gimbal_hil.discrepancy.hypothesis import Hypothesis, values_of
from gimbal_hil.discrepancy.rivals import compare
from gimbal_hil.discrepancy.search import Scored, Search
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.valleys import further
from sim_backend.effects import CATALOGUE, Move

_BLOCK_S = 2.0
#: nominal 95 % and a margin for what blocks do not see (twin and plant differ in the integrator)
_REACH = 2.6
_LEAST_SHARE = 0.004
#: steps along a valley, and how far each goes
_STEPS, _STEP = 10, 1.0


def covariance(search: Search, state: Scored) -> Floats:
    """Covariance of a state's coordinates from blocks of the fitted data."""
    fit = refit(search.twin, state.hypothesis, search.floor, rounds=1, spread=search.spread)
    channels, k = fit.residual.shape[1], fit.jacobian.shape[1]
    weights = prior_weights(fit.hypothesis) * search.spread
    normal = fit.jacobian.T @ fit.jacobian + np.diag(weights**2)
    # a valley is followed as it bends; what is asked here is how far the numbers scatter across it
    for valley in _valleys(fit.hypothesis):
        normal += valley[:, None] * valley * float(np.trace(normal)) / float(valley @ valley)
    inverse = np.linalg.pinv(normal, rcond=1e-12, hermitian=True)
    bands = search.twin.records[0].bands
    length = max(2, int(_BLOCK_S / (bands.stride * bands.period_s))) * channels
    n = len(fit.residual) * channels // length * length
    scores = (fit.jacobian[:n] * fit.residual.ravel()[:n, None]).reshape(-1, length, k).sum(axis=1)
    scores = scores - scores.mean(axis=0)
    return np.asarray(inverse @ (scores.T @ scores) @ inverse)


def _valleys(hypothesis: Hypothesis) -> list[Floats]:
    """Directions in a hypothesis' coordinates along which numbers of one cause trade against each other."""
    found, first = [], 0
    for cause in hypothesis.causes:
        if cause.family.valley:
            found.append(np.zeros(len(hypothesis.vector())))
            found[-1][first : first + len(cause.x)] = cause.family.valley
        first += len(cause.x)
    return found


def parameter_intervals(search: Search, state: Scored, index: int) -> dict[str, tuple[float, float]]:
    """Low and high of every parameter of one cause, within the catalogue's bounds. A number that moves by factors has a skewed interval."""
    spread = np.sqrt(np.maximum(np.diag(covariance(search, state)), 0.0))
    first = sum(len(cause.x) for cause in state.hypothesis.causes[:index])
    cause = state.hypothesis.causes[index]
    model = search.twin.model
    centre = values_of(model, search.twin, state.hypothesis, index)
    below, above = dict.fromkeys(centre, 0.0), dict.fromkeys(centre, 0.0)
    angles = {p.name for p in CATALOGUE[cause.family.effect].parameters if p.periodic}
    x = state.hypothesis.vector()
    for j, knob in enumerate(cause.family.knobs):
        # along a factor the whole reach is walked; a size is linear, and a phase must not come round
        walked, stretched = (_REACH, 1.0) if knob.move is not Move.ADD else (1.0, _REACH)
        for side in (-1.0, 1.0):
            moved = x.copy()
            moved[first + j] += side * walked * max(spread[first + j], 1e-9)
            shifted = values_of(model, search.twin, state.hypothesis.at(moved), index)
            for name in centre:
                change = shifted[name][0] - centre[name][0]
                if name in angles:
                    change = (change + np.pi) % (2.0 * np.pi) - np.pi
                half = above if change > 0.0 else below
                half[name] = float(np.hypot(half[name], stretched * change))
    for hypothesis in _as_good(search, state, index):
        for name, (value, _) in values_of(model, search.twin, hypothesis, index).items():
            change = value - centre[name][0]
            half = above if change > 0.0 else below
            half[name] = max(half[name], abs(change))
    out = {}
    for name, (value, _) in centre.items():
        least = _LEAST_SHARE * abs(value) if below[name] + above[name] > 0.0 else 0.0
        out[name] = (value - below[name] - least, value + above[name] + least)
    return _within_bounds(cause.family.effect, out)


def _as_good(search: Search, state: Scored, index: int) -> list[Hypothesis]:
    """Places along the valley of one cause, on both sides, that explain the data as well, or no worse than the twin repeats itself."""
    found: list[Hypothesis] = []
    if not state.hypothesis.causes[index].family.valley:
        return found
    unrepeated = search.unrepeated(state)
    for step in (_STEP, -_STEP):
        here = state
        for _ in range(_STEPS):
            here = further(search, here, index, step)
            if not compare(search, state, here).close and here.cost - state.cost > unrepeated:
                break
            found.append(here.hypothesis)
    return found


def _within_bounds(effect: str, found: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Intervals cut off where a parameter ends by definition, never short of the value itself."""
    ends = {p.name: (p.low, p.high) for p in CATALOGUE[effect].parameters if not p.periodic}
    cut = {}
    for name, (low, high) in found.items():
        first, last = ends.get(name, (-np.inf, np.inf))
        cut[name] = (max(low, min(first, high)), min(high, max(last, low)))
    return cut
