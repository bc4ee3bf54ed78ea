"""Candidates for the next cause: effects are screened against the residual, the best refitted with all others."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import repeat

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import (
    Cause,
    Family,
    Fit,
    FitRule,
    Hypothesis,
    Weighing,
    fit,
    weighed_cost,
)
from gimbal_hil.knowledge.discrepancy.inquiry import MOST_ENTRIES, Inquiry, State, refitted, state_of, weighing_of
from gimbal_hil.knowledge.discrepancy.search.comparing import OUT_OF_REACH, advantage
from gimbal_hil.knowledge.discrepancy.search.screening import Proposal, Response, propose, respond
from sim_backend.effects import CATALOGUE

#: families refined per round, after screening; in the place of a cause
_REFINED, _IN_PLACE = 6, 3
#: rounds of a first fit, and of those that are still in the race
_FIRST, _RACING = 1, 5
#: and that took this share of the least that a cause must take in their first step
_PROMISE = 0.3
#: candidates that are compared closely, and asked for their negative control
ASKED = 4
#: where the best one leaves at most this share of the squares of a channel, noise at least in both, fits are looked at
#: again
_MUCH_LESS = 0.1
#: where the numbers of friction stand in a model, and the one without which it has no bristle
_FRICTION, _BRISTLE = "friction.", "friction.sigma0"
#: a family of more coordinates than this is refined from more than two of its starts
_VALLEYS = 3


def candidates(
    inquiry: Inquiry,
    before: State,
    heard: tuple[Response, ...],
    instead_of: State | None = None,
    tried: frozenset[tuple[str, str]] | None = None,
) -> list[State]:
    """The most promising families beside a state, refitted with everything that is there; best first.

    `instead_of` is a state with one cause more, whose place is looked at: that cause needs no second fit, and another
    one has to come near it. With what has been `tried` there, those count that do most of what that cause does: what
    else is left, in this channel or another, has no say in what the data tell it from.
    """
    weighing = weighing_of(inquiry, before)
    taken = set() if instead_of is None else set(instead_of.hypothesis.labels) - set(before.hypothesis.labels)
    allowed = [f for f in addable(before.hypothesis, inquiry.families) if f.label not in taken]
    labels = {f.label for f in allowed}
    wanted = before.fit
    if instead_of is not None and tried is not None:
        wanted = replace(wanted, residual=wanted.residual - instead_of.fit.residual)
    again = _acts_otherwise(inquiry, before.hypothesis)
    known = [r for r in heard if r.family.label in labels - again]
    known += listen(inquiry, wanted, [f for f in allowed if f.ripple or f.label in again])
    best: dict[tuple[str, str], list[Proposal]] = {}
    for proposal in propose(wanted, known, weighing):
        best.setdefault(proposal.family.label, []).append(proposal)
    ranked = sorted(best.values(), key=lambda found: -found[0].gain)
    ranked = ranked[: _REFINED if instead_of is None else _IN_PLACE]
    starts = [
        before.hypothesis.plus(Cause(p.family, p.x))
        for found in ranked
        for p in found[: _starts_refined(found[0].family)]
        if tried is None or p.family.label not in tried
    ]
    kept: dict[tuple[str, str], Fit] = {}
    to_beat = math.inf if instead_of is None else weighed_cost(instead_of.fit, weighing)
    for one in _refined(inquiry, before, starts, weighing, to_beat):
        label = one.hypothesis.labels[-1]
        if label not in kept or one.cost < kept[label].cost:
            kept[label] = one
    # a fit that contains the state that it began from and ends above it has failed
    ceiling = weighed_cost(before.fit, weighing)
    states = [state_of(inquiry, one) for one in kept.values() if one.cost <= ceiling]
    return _beside_the_best(inquiry, before, sorted(states, key=lambda state: -advantage(inquiry, before, state)))


def _acts_otherwise(inquiry: Inquiry, hypothesis: Hypothesis) -> set[tuple[str, str]]:
    """Families that move numbers of a friction to which a cause gave the bristle that the model lacks: what was heard
    beside the model alone is not what they do there.
    """
    axes = {cause.family.axis for cause in hypothesis.causes if _BRISTLE in _paths(cause.family)}
    gained = {axis for axis in axes if inquiry.twin.model.number(axis, _BRISTLE) <= 0.0}
    mine = (family for family in inquiry.families if family.axis in gained)
    return {family.label for family in mine if any(path.startswith(_FRICTION) for path in _paths(family))}


def _paths(family: Family) -> list[str]:
    """Places in the model file of the numbers that a family moves."""
    return [p.path for p in CATALOGUE[family.effect].parameters if p.path]


def _beside_the_best(inquiry: Inquiry, before: State, states: list[State]) -> list[State]:
    """The same, the first few fitted once more beside what the best of them leaves: beside a gap that is many times as
    large, fits are content as soon as they explain most of it, and which of them comes nearest is chance.
    """
    if not states:
        return states
    was, left = (np.maximum(state.fit.squares, 1.0) for state in (before, states[0]))
    if np.all(left > _MUCH_LESS * was):
        return states
    first = [refitted(inquiry, states[0], state.hypothesis) for state in states[:ASKED]]
    return sorted(first, key=lambda state: -advantage(inquiry, states[0], state)) + states[ASKED:]


def listen(inquiry: Inquiry, beside: Fit, families: list[Family]) -> list[Response]:
    """What each of some families does to the residual of a fit, at each of its starts."""
    bare = replace(beside, jacobian=np.zeros((0, 0)))
    # those with most starts first: they take longest
    order = sorted(families, key=lambda f: -len(f.starts) - (50 if f.ripple else 0))
    found = inquiry.executor.map(
        respond, repeat(inquiry.twin_there or inquiry.twin), repeat(bare), repeat(inquiry.floor), order
    )
    return [response for family in found for response in family]


def addable(hypothesis: Hypothesis, families: tuple[Family, ...]) -> list[Family]:
    """Families that may be added: what is not there yet, and further orders of a ripple that is."""
    counts = {label: hypothesis.labels.count(label) for label in hypothesis.labels}
    return [f for f in families if counts.get(f.label, 0) < (MOST_ENTRIES if f.ripple else 1)]


def numbers_of(cause: Cause) -> int:
    """Numbers of a cause that the data must give."""
    return sum(not knob.nuisance for knob in cause.family.knobs)


def _starts_refined(family: Family) -> int:
    """From how many of its starts a family is refined: one number has one valley, a gap and its rotor have several."""
    return 2 if family.ripple or 1 < len(family.knobs) <= _VALLEYS else len(family.knobs) // 2 + 1


def _promises(inquiry: Inquiry, before: Fit, one: Fit) -> bool:
    """Whether a first step takes a part of what a cause must take to pay."""
    policy = inquiry.policy
    taken = before.squares - one.squares
    return bool(np.any(taken > _PROMISE * np.maximum(policy.least_share * before.squares, policy.least_squares)))


def _refined(
    inquiry: Inquiry, before: State, hypotheses: list[Hypothesis], weighing: Weighing, to_beat: float
) -> list[Fit]:
    """One step for all, more for those that are still in the race with the best of them and with a cost to beat."""

    # what is there already hardly changes what it does when something is added
    earlier = before.fit.jacobian[:, : sum(len(cause.x) for cause in before.hypothesis.causes)]

    def fitted(chosen: list[Hypothesis], rounds: int) -> list[Fit]:
        known = [
            (inquiry.known if inquiry.known_there is None else inquiry.known_there) if h.floating else None
            for h in chosen
        ]
        work = (
            repeat(inquiry.twin_there or inquiry.twin),
            chosen,
            repeat(inquiry.floor),
            repeat(weighing),
            repeat(FitRule(rounds, ceiling=ceiling if rounds == _FIRST else None)),
            known,
            repeat(earlier),
        )
        return list(inquiry.executor.map(fit, *work))

    ceiling = weighed_cost(before.fit, weighing)
    fits = fitted(hypotheses, _FIRST)
    if not fits:
        return []
    least = min(to_beat, *(one.cost for one in fits))
    racing = [
        i for i, one in enumerate(fits) if one.cost <= OUT_OF_REACH * least and _promises(inquiry, before.fit, one)
    ]
    for i, one in zip(racing, fitted([fits[i].hypothesis for i in racing], _RACING), strict=True):
        fits[i] = one
    return fits
