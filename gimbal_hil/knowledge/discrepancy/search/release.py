"""Frees all known numbers at once, to see which of them leave their stated uncertainty.

Several wrong numbers can look like a few effects, found one after another. So each round has one candidate more beside
the single causes: all numbers that leave their uncertainty when all are free, as the catalogue's causes for them.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import (
    PLAUSIBLE,
    Cause,
    Family,
    Hypothesis,
    KnownNumber,
    is_tied,
    known_numbers,
    prior_weights,
    values_of,
)
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State, refitted, settled, squares_of, weighing_of
from gimbal_hil.knowledge.discrepancy.search.screening import row_weights
from sim_backend.effects import CATALOGUE

#: how far numbers may go when they are let go, in units of their uncertainty
_LEASH = 25.0


def released(inquiry: Inquiry, state: State) -> State | None:
    """A state with every cause that numbers which leave their uncertainty ask for; None where fewer than two do."""
    hypothesis = state.hypothesis
    if len(hypothesis.pressing) < 2:
        return None
    free = refitted(inquiry, state, hypothesis, rounds=3, leash=_LEASH).hypothesis
    wanted = hypothesis
    for family in _covering(inquiry, _beyond_stated(free), set(hypothesis.labels)):
        wanted = wanted.plus(Cause(family, (0.0,) * len(family.knobs)))
    if len(wanted.causes) - len(hypothesis.causes) < 2:
        return None
    found = refitted(inquiry, state, wanted, rounds=8)
    # beside the whole gap a fit is content once it explains most of it, and far from the model numbers do other things
    return refitted(replace(inquiry, known=None), found, found.hypothesis, rounds=8)


def _beyond_stated(hypothesis: Hypothesis) -> set[KnownNumber]:
    """Known numbers that left their uncertainty."""
    return {known for known, y in zip(hypothesis.floating, hypothesis.y, strict=True) if abs(y) > known.trust}


def with_more_room(inquiry: Inquiry, state: State, but: Collection[tuple[str, str]] = ()) -> State:
    """A state whose known numbers may leave their uncertainty as far as is plausible, all but some (axis, path)."""
    return refitted(inquiry, state, _with_room(state.hypothesis, but))


def _with_room(hypothesis: Hypothesis, but: Collection[tuple[str, str]]) -> Hypothesis:
    wider = tuple(k if (k.axis, k.path) in but else replace(k, room=PLAUSIBLE) for k in hypothesis.floating)
    return replace(hypothesis, floating=wider)


def numbers_instead(
    inquiry: Inquiry, without: State, state: State, label: tuple[str, str]
) -> tuple[State, tuple[tuple[str, str], ...]] | None:
    """A state without a cause in which known numbers may leave their uncertainty a little, all but the cause's own; and
    the effects that those which do are told as. None where none does.

    Looked for from where the others stand `without` the cause, and from where they go as the cause of a `state` gives
    way to them: a gain that several numbers and a limit make up for is left on no other way.
    """
    model, hypothesis = inquiry.twin.model, without.hypothesis
    if not hypothesis.floating:
        return None
    own = {(label[1], model.number_path(label[1], p.path)) for p in CATALOGUE[label[0]].parameters if p.path}
    led = _with_room(_giving_way(inquiry, state, label), own)
    ways = with_more_room(inquiry, without, own), refitted(replace(inquiry, known=None), state, led)
    free = min(ways, key=lambda one: float(np.sum(squares_of(one))))
    far = _beyond_stated(free.hypothesis)
    found = tuple(family.label for family in _covering(inquiry, far, set(hypothesis.labels)))
    return (free, found) if found else None


def as_causes(inquiry: Inquiry, state: State, labels: Collection[tuple[str, str]]) -> State:
    """A state with the causes that known numbers are told as (`numbers_instead`), refitted."""
    wanted = state.hypothesis
    for family in (family for family in inquiry.families if family.label in labels):
        wanted = wanted.plus(Cause(family, (0.0,) * len(family.knobs)))
    return refitted(replace(inquiry, known=None), state, wanted, rounds=8)


def _giving_way(inquiry: Inquiry, state: State, label: tuple[str, str]) -> Hypothesis:
    """A hypothesis without a cause, everything else as far along as, by the slopes, makes up for the cause best."""
    hypothesis, x = state.hypothesis, state.hypothesis.vector()
    goes = [cause.family.label == label for cause in hypothesis.causes for _ in cause.x]
    mine = np.array(goes + [False] * (len(x) - len(goes)))
    rows = state.fit.jacobian * row_weights(state.fit, weighing_of(inquiry, state))[:, None]
    held = np.diag(prior_weights(hypothesis))
    both, wanted = np.vstack([rows, held])[:, ~mine], np.vstack([rows, held])[:, mine] @ x[mine]
    x[~mine] += np.linalg.lstsq(both, wanted, rcond=None)[0]
    x[mine] = 0.0
    led = hypothesis.at(x)
    for index in reversed([i for i, other in enumerate(hypothesis.labels) if other == label]):
        led = led.minus(index)
    return led


def given_back(inquiry: Inquiry, state: State) -> State:
    """A state without causes whose every number lies within what the model says of it: no number has left its
    uncertainty there, so they move as known numbers do, unless that leaves more.
    """
    for label in dict.fromkeys(state.hypothesis.labels):
        lighter = _as_known(inquiry, state.hypothesis, state.hypothesis.labels.index(label))
        if lighter is not None:
            other = settled(inquiry, refitted(inquiry, state, lighter, rounds=0))
            before, after = (float(np.sum(squares_of(one))) for one in (state, other))
            state = other if after < (1.0 + inquiry.policy.same) * before else state
    return state


def _as_known(inquiry: Inquiry, hypothesis: Hypothesis, index: int) -> Hypothesis | None:
    """The hypothesis with the numbers of one cause as known numbers; None where one of them is beyond what the model
    says of it, or where the cause is more than numbers.
    """
    model = inquiry.twin.model
    effect, axis = hypothesis.labels[index]
    if not CATALOGUE[effect].is_number:
        return None
    stated = {(known.axis, known.path): known for known in known_numbers(model)}
    found: dict[KnownNumber, float] = {}
    values = values_of(model, inquiry.twin, hypothesis, index)
    for parameter in CATALOGUE[effect].parameters:
        (value, nominal), path = values[parameter.name], model.number_path(axis, parameter.path or "")
        if is_tied(model, axis, path):
            continue
        known = stated.get((axis, path))
        y = None if known is None else known.coordinate(nominal or 0.0, value)
        if known is None or y is None or abs(y) > known.trust:
            return None
        found[known] = y
    rest = hypothesis.minus(index)
    return replace(rest, y=tuple(found.get(known, y) for known, y in zip(rest.floating, rest.y, strict=True)))


def _covering(inquiry: Inquiry, far: set[KnownNumber], present: set[tuple[str, str]]) -> list[Family]:
    """Effects that are nothing but numbers being wrong, each taken for those of its numbers that are far; the fullest
    first.
    """
    model = inquiry.twin.model
    left = {(known.axis, known.path) for known in far}
    found: list[Family] = []
    numbers = [f for f in inquiry.families if CATALOGUE[f.effect].is_number and f.label not in present]
    paths = {
        f.label: {(f.axis, model.number_path(f.axis, p.path)) for p in CATALOGUE[f.effect].parameters if p.path}
        for f in numbers
    }
    while left and numbers:
        shares = [len(paths[f.label] & left) / len(paths[f.label]) for f in numbers]
        best = int(np.argmax(shares))
        if shares[best] == 0.0:
            break
        family = numbers.pop(best)
        left -= paths[family.label]
        found.append(family)
    return found
