"""Intervals of parameters: blockwise sandwich covariance, so that correlated rows and repeatable misfit widen them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import FitRule, Hypothesis, fit, prior_weights, values_of
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State, weighing_of
from gimbal_hil.knowledge.discrepancy.twin import Floats
from gimbal_hil.knowledge.estimation import block_sums
from sim_backend.effects import CATALOGUE, Move

_BLOCK_S = 2.0
#: nominal 95 % and a margin for what blocks do not see (twin and plant differ in the integrator)
_REACH = 2.6
_LEAST_SHARE = 0.004
#: of a coordinate, for derivatives; and a spread that is none
_STEP, _NOTHING = 1e-4, 1e-300
#: the largest share that is told of a strength of which nothing is known
_ALL = 1e3
#: of states that somebody still has: every interval asks for it
_found: WeakKeyDictionary[State, Floats] = WeakKeyDictionary()
_let_go: WeakKeyDictionary[State, Hypothesis] = WeakKeyDictionary()
#: times its uncertainty that a number may go on that presses against the end of that
_LET_GO = 4.0


def covariance(inquiry: Inquiry, state: State) -> Floats:
    """Covariance of a state's coordinates from blocks of the fitted logs and the selecting rows, on which it was
    settled.
    """
    if state not in _found:
        _found[state] = _covariance(inquiry, state)
    return _found[state]


def _covariance(inquiry: Inquiry, state: State) -> Floats:
    weighing = weighing_of(inquiry, state)
    found = fit(inquiry.selectable, state.hypothesis, inquiry.floor, weighing, FitRule(1))
    hypothesis = state.hypothesis
    per_row = np.tile(1.0 / (np.array(weighing.scale) * weighing.spread), len(found.residual))
    jacobian, residual = found.jacobian * per_row[:, None], found.residual.ravel() * per_row
    channels = found.residual.shape[1]
    bands = inquiry.twin.records[0].bands
    length = min(max(2, int(_BLOCK_S / (bands.stride * bands.period_s))), max(2, len(found.residual) // 8)) * channels
    scores = block_sums(jacobian * residual[:, None], length)
    scores = scores - scores.mean(axis=0)
    prior = prior_weights(hypothesis) ** 2
    inverse = _inverse(jacobian.T @ jacobian + np.diag(prior))
    # what the prior says of a number is as unsure as the prior, also where the number stands at its end; numbers that
    # the data gave were taken from the blocks
    given = float(np.sum(1.0 - prior * np.diag(inverse)))
    blocks = len(scores)
    scatter = scores.T @ scores * blocks / max(blocks - given, 1.0)
    return np.asarray(inverse @ (scatter + np.diag(prior)) @ inverse)


def _inverse(normal: Floats) -> Floats:
    """Inverse of a normal matrix, on a scale of its own for each number: a coordinate that the data hardly move must
    not drown in one that they move much.
    """
    size = np.sqrt(np.diag(normal))
    return np.asarray(np.linalg.pinv(normal / np.outer(size, size), rcond=1e-12, hermitian=True) / np.outer(size, size))


def number_intervals(inquiry: Inquiry, state: State) -> list[tuple[float, float]]:
    """Low and high of every floating known number's coordinate."""
    if not state.hypothesis.floating:
        return []
    spread = _REACH * np.sqrt(np.maximum(np.diag(covariance(inquiry, state)), 0.0))[-len(state.hypothesis.y) :]
    return [(y - s, y + s) for y, s in zip(state.hypothesis.y, spread, strict=True)]


@dataclass(frozen=True)
class _Moves:
    """How the parameters of one cause move with the coordinates of a state."""

    effect: str
    #: values and what the model has, at the state's coordinates; changes of the values with a step of them, as if there
    #: were no bounds
    values: dict[str, tuple[float, float | None]]
    changes: Callable[[Floats], dict[str, float]]
    #: derivatives of the same
    slopes: dict[str, Floats]
    angles: frozenset[str]


def parameter_intervals(inquiry: Inquiry, state: State, index: int) -> dict[str, tuple[float, float]]:
    """Low and high of every parameter of one cause, within the catalogue's bounds. A number that moves by factors has a
    skewed interval.

    All coordinates count that move the parameter: a number of the model that is a cause also floats within its
    uncertainty, and data tell the two together far better than either.
    """
    moves, spread = _moves(inquiry, state, index), covariance(inquiry, state)
    let_go = _where_nothing_presses(inquiry, state)
    elsewhere = values_of(inquiry.twin.model, inquiry.twin, let_go, index, held=False) if let_go else moves.values
    knobs = state.hypothesis.causes[index].family.knobs
    factors = {name for knob in knobs for name in knob.parameters if knob.move is Move.FACTOR}
    out = {}
    for name, (value, _) in moves.values.items():
        slope = moves.slopes[name]
        # where the other coordinates most probably go as the parameter moves
        along = spread @ slope / max(_error(slope, spread), _NOTHING)
        # along a factor the whole reach is walked; a size is linear, and a phase must not come round
        walked, stretched = (_REACH, 1.0) if name in factors else (1.0, _REACH)
        ends = [stretched * moves.changes(side * walked * along)[name] for side in (-1.0, 1.0)]
        further = _the_short_way(moves, name, elsewhere[name][0] - value)
        below, above = min(0.0, *ends) + min(0.0, further), max(0.0, *ends) + max(0.0, further)
        least = _LEAST_SHARE * abs(value) if above > below else 0.0
        out[name] = (value + below - least, value + above + least)
    return _within_bounds(moves.effect, out)


def _where_nothing_presses(inquiry: Inquiry, state: State) -> Hypothesis | None:
    """The hypothesis fitted once more where known numbers that press against the end of their uncertainty may go on:
    what the model says of them is not what the logs ask for, and whatever goes with them goes on too. None where none
    does.
    """
    here = state.hypothesis
    if not here.pressing:
        return None
    if state not in _let_go:
        floating = tuple(
            replace(known, trust=_LET_GO * known.trust) if i in here.pressing else known
            for i, known in enumerate(here.floating)
        )
        free = replace(here, floating=floating)
        found = fit(inquiry.selectable, free, inquiry.floor, weighing_of(inquiry, state), FitRule(10, enough=1e-6))
        _let_go[state] = found.hypothesis
    return _let_go[state]


def _the_short_way(moves: _Moves, name: str, by: float) -> float:
    return (by + np.pi) % (2.0 * np.pi) - np.pi if name in moves.angles else by


def strength_error(inquiry: Inquiry, state: State, index: int) -> float:
    """Half width of the interval of a cause's strength, as a share of the strength, everything else free: of those of
    its numbers that carry what it does, the one that is known best. From one on, it may as well not be there.
    """
    moves, spread = _moves(inquiry, state, index), covariance(inquiry, state)
    of = {p.name for p in CATALOGUE[moves.effect].strengths}
    shares = [
        _REACH * _error(moves.slopes[name], spread) / max(abs(value - (nominal or 0.0)), _NOTHING)
        for name, (value, nominal) in moves.values.items()
        if name in of
    ]
    return min(*shares, _ALL) if shares else 0.0


def strengths_to_their_end(inquiry: Inquiry, state: State, index: int) -> tuple[str, ...]:
    """Strengths of a cause whose interval reaches an end up to which they were sought, where that is not nothing. Of
    numbers of the model it is not asked: all of them are strengths there, also the speed of a bump.
    """
    causes = state.hypothesis.causes
    cause, effect = causes[index], CATALOGUE[causes[index].family.effect]
    if effect.is_number:
        return ()
    first = sum(len(other.x) for other in causes[:index])
    variances = np.diag(covariance(inquiry, state))[first : first + len(cause.x)]
    strengths, found = {parameter.name for parameter in effect.strengths}, []
    for knob, x, reach in zip(cause.family.knobs, cause.x, _REACH * np.sqrt(np.maximum(variances, 0.0)), strict=True):
        ends = [end for end in knob.telling_ends if knob.move is not Move.ADD or end != knob.nothing]
        if any(abs(x - end) <= reach for end in ends):
            found += [name for name in knob.parameters if name in strengths]
    return tuple(found)


def _error(slope: Floats, spread: Floats) -> float:
    return float(np.sqrt(max(float(slope @ spread @ slope), 0.0)))


def _moves(inquiry: Inquiry, state: State, index: int) -> _Moves:
    model, twin, x = inquiry.twin.model, inquiry.twin, state.hypothesis.vector()
    effect = state.hypothesis.causes[index].family.effect
    angles = frozenset(p.name for p in CATALOGUE[effect].parameters if p.periodic)
    values, centre = (values_of(model, twin, state.hypothesis, index, held) for held in (True, False))

    def changes(step: Floats) -> dict[str, float]:
        found = values_of(model, twin, state.hypothesis.at(x + step), index, held=False)
        by = {name: value - centre[name][0] for name, (value, _) in found.items()}
        # angles the short way round
        return {n: (d + np.pi) % (2.0 * np.pi) - np.pi if n in angles else d for n, d in by.items()}

    both = [(changes(_STEP * unit), changes(-_STEP * unit)) for unit in np.eye(len(x))]
    # a coordinate at its own bound moves on the other side only
    slopes = {
        name: np.array([max(up[name], -down[name], key=lambda by: abs(by)) / _STEP for up, down in both])
        for name in centre
    }
    return _Moves(effect, values, changes, slopes, angles)


def _within_bounds(effect: str, found: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Intervals cut off where a parameter ends by definition, never short of the value itself."""
    ends = {p.name: (p.low, p.high) for p in CATALOGUE[effect].parameters if not p.periodic}
    cut = {}
    for name, (low, high) in found.items():
        first, last = ends.get(name, (-np.inf, np.inf))
        cut[name] = (max(low, min(first, high)), min(high, max(last, low)))
    return cut
