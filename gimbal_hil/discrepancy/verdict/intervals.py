"""Intervals of parameters: blockwise sandwich covariance, so that correlated rows and repeatable misfit widen them."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from gimbal_hil.discrepancy.hypotheses import fit, prior_weights, values_of
from gimbal_hil.discrepancy.inquiry import Inquiry, State, weighing_of
from gimbal_hil.discrepancy.twin import Floats
from gimbal_hil.estimation import block_sums
from sim_backend.effects import CATALOGUE, Move

_BLOCK_S = 2.0
#: nominal 95 % and a margin for what blocks do not see (twin and plant differ in the integrator)
_REACH = 2.6
_LEAST_SHARE = 0.004
#: of states that somebody still has: every interval asks for it
_found: WeakKeyDictionary[State, Floats] = WeakKeyDictionary()


def covariance(inquiry: Inquiry, state: State) -> Floats:
    """Covariance of a state's coordinates from blocks of the fitted logs and the selecting rows, on which it was
    settled.
    """
    if state not in _found:
        _found[state] = _covariance(inquiry, state)
    return _found[state]


def _covariance(inquiry: Inquiry, state: State) -> Floats:
    weighing = weighing_of(inquiry, state)
    found = fit(inquiry.selectable, state.hypothesis, inquiry.floor, weighing, rounds=1)
    per_row = np.tile(1.0 / (np.array(weighing.scale) * weighing.spread), len(found.residual))
    jacobian, residual = found.jacobian * per_row[:, None], found.residual.ravel() * per_row
    channels, k = found.residual.shape[1], jacobian.shape[1]
    # a number of its own scale each: a coordinate that the data hardly move must not drown in one that they move much
    prior = prior_weights(found.hypothesis) ** 2
    normal = jacobian.T @ jacobian + np.diag(prior)
    size = np.sqrt(np.diag(normal))
    inverse = np.linalg.pinv(normal / np.outer(size, size), rcond=1e-12, hermitian=True) / np.outer(size, size)
    bands = inquiry.twin.records[0].bands
    length = min(max(2, int(_BLOCK_S / (bands.stride * bands.period_s))), max(2, len(found.residual) // 8)) * channels
    scores = block_sums(jacobian * residual[:, None], length)
    scores = scores - scores.mean(axis=0)
    assert scores.shape[1] == k
    # what the prior says of a number is as unsure as the prior; numbers that the data gave were taken from the blocks
    given = float(np.sum(1.0 - prior * np.diag(inverse)))
    blocks = len(scores)
    scatter = scores.T @ scores * blocks / max(blocks - given, 1.0)
    return np.asarray(inverse @ (scatter + np.diag(prior)) @ inverse)


def number_intervals(inquiry: Inquiry, state: State) -> list[tuple[float, float]]:
    """Low and high of every floating known number's coordinate."""
    if not state.hypothesis.floating:
        return []
    spread = _REACH * np.sqrt(np.maximum(np.diag(covariance(inquiry, state)), 0.0))[-len(state.hypothesis.y) :]
    return [(y - s, y + s) for y, s in zip(state.hypothesis.y, spread, strict=True)]


def parameter_intervals(inquiry: Inquiry, state: State, index: int) -> dict[str, tuple[float, float]]:
    """Low and high of every parameter of one cause, within the catalogue's bounds. A number that moves by factors has a
    skewed interval.
    """
    spread = np.sqrt(np.maximum(np.diag(covariance(inquiry, state)), 0.0))
    first = sum(len(cause.x) for cause in state.hypothesis.causes[:index])
    cause = state.hypothesis.causes[index]
    model = inquiry.twin.model
    centre = values_of(model, inquiry.twin, state.hypothesis, index)
    below, above = dict.fromkeys(centre, 0.0), dict.fromkeys(centre, 0.0)
    angles = {p.name for p in CATALOGUE[cause.family.effect].parameters if p.periodic}
    x = state.hypothesis.vector()
    for j, knob in enumerate(cause.family.knobs):
        # along a factor the whole reach is walked; a size is linear, and a phase must not come round
        walked, stretched = (_REACH, 1.0) if knob.move is not Move.ADD else (1.0, _REACH)
        for side in (-1.0, 1.0):
            moved = x.copy()
            moved[first + j] += side * walked * max(spread[first + j], 1e-9)
            shifted = values_of(model, inquiry.twin, state.hypothesis.at(moved), index)
            for name in centre:
                change = shifted[name][0] - centre[name][0]
                if name in angles:
                    change = (change + np.pi) % (2.0 * np.pi) - np.pi
                half = above if change > 0.0 else below
                half[name] = float(np.hypot(half[name], stretched * change))
    out = {}
    for name, (value, _) in centre.items():
        least = _LEAST_SHARE * abs(value) if below[name] + above[name] > 0.0 else 0.0
        out[name] = (value - below[name] - least, value + above[name] + least)
    return _within_bounds(cause.family.effect, out)


def _within_bounds(effect: str, found: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Intervals cut off where a parameter ends by definition, never short of the value itself."""
    ends = {p.name: (p.low, p.high) for p in CATALOGUE[effect].parameters if not p.periodic}
    cut = {}
    for name, (low, high) in found.items():
        first, last = ends.get(name, (-np.inf, np.inf))
        cut[name] = (max(low, min(first, high)), min(high, max(last, low)))
    return cut
