"""What takes the place of a cause while the set is judged: what surely explains more, what needs nothing new, several
numbers of the model that it makes up for, and what with one cause more explains more than the set does with that cause.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import at_bound
from gimbal_hil.knowledge.discrepancy.inquiry import (
    MOST_CAUSES,
    Inquiry,
    State,
    refitted,
    settled,
    squares_of,
    stands_out,
)
from gimbal_hil.knowledge.discrepancy.judgement.judging import Standing
from gimbal_hil.knowledge.discrepancy.judgement.rivals import Rival
from gimbal_hil.knowledge.discrepancy.search import (
    OUT_OF_REACH,
    Path,
    as_causes,
    clearly_better,
    extended,
    numbers_of,
    pruned,
    surely,
    with_more_room,
)
from sim_backend.effects import CATALOGUE

#: a rival that takes a cause's place has at most so many numbers more
_MORE_NUMBERS = 1


def set_of(state: State) -> frozenset[tuple[str, str]]:
    """The causes of a state."""
    return frozenset(state.hypothesis.labels)


def better_instead(
    inquiry: Inquiry,
    state: State,
    found: tuple[Standing, ...],
    replaced: set[frozenset[tuple[str, str]]],
    path: Path,
) -> State | None:
    """The state with another cause in the place of one that it surely beats, or of one at its bound, where that is no
    longer what its name says, if it leaves little more than a cause must take to be told; or with what needs nothing
    new, where data do not tell the two apart; or with several numbers that are off. None where there is none.

    What was `replaced` comes back only where it is one cause that surely explains more, and then it stays: causes that
    take each other's place in turn are alternatives, to be judged as such.
    """
    for standing in found:
        for rival in standing.rivals:
            if rival.at_bound or not rival.state.hypothesis.causes:
                continue
            came_from = set_of(rival.state) in replaced
            if came_from and (_is_plainer(rival, standing) or set_of(state) in replaced):
                continue
            if _is_plainer(rival, standing) and rival.close(inquiry.policy):
                return rival.state
            more = rival.extra * (1.0 - standing.share)
            if standing.at_bound and more < inquiry.policy.least_share:
                return rival.state
            if _surely_beats(inquiry, state, standing, rival):
                return rival.state
    numbers = _by_numbers(inquiry, state, found, replaced)
    return numbers or _with_one_beside(inquiry, state, found, replaced, path)


def _with_one_beside(
    inquiry: Inquiry,
    state: State,
    found: tuple[Standing, ...],
    replaced: set[frozenset[tuple[str, str]]],
    path: Path,
) -> State | None:
    """Where a state leaves a gap: the state with a rival in the place of a cause and one cause more, if it surely
    explains more than the state with that same cause. None where there is none.

    A search takes first what alone explains most, and that may be a part of two causes: of a weight and of friction
    that differs by direction a spring explains more than either.
    """
    if not stands_out(inquiry, state):
        return None
    for standing in found:
        for rival in standing.rivals:
            causes = set_of(rival.state)
            if not rival.is_cause or rival.at_bound or 1.0 + rival.extra > OUT_OF_REACH or len(causes) >= MOST_CAUSES:
                continue
            inquiry.tell(f"what beside {rival.label[0].replace('_', ' ')} explains more")
            both = extended(inquiry, rival.state, 1, path.heard).state
            if not set_of(both) > causes or set_of(both) in replaced or set_of(both) >= set_of(state):
                continue
            newest = both.hypothesis.causes[-1]
            if newest.family.ripple:
                # with a few of its like it draws any curve
                continue
            both = settled(inquiry, both)
            fair = settled(inquiry, refitted(inquiry, state, state.hypothesis.plus(newest)))
            if _beats(inquiry, both, fair):
                return both
    return None


def _is_plainer(rival: Rival, standing: Standing) -> bool:
    """Whether a rival needs nothing new where the cause does: a further order of a ripple that is there, or a number of
    the model that is off and the same to a twin. What the cause contains is no alternative to it.
    """
    mine, other = CATALOGUE[standing.label[0]], CATALOGUE[rival.label[0]]
    contained = mine.plainer is not None and mine.plainer.name == other.name
    is_off = other.is_number and rival.is_cause and rival.same and not contained
    return not mine.is_number and (rival.is_there or is_off)


def _by_numbers(
    inquiry: Inquiry, state: State, found: tuple[Standing, ...], replaced: set[frozenset[tuple[str, str]]]
) -> State | None:
    """The state with several known numbers as causes, where in the place of one cause they surely and clearly explain
    more: a search that adds one cause after another first finds what makes up for many numbers at once. They are put
    beside that cause, and whatever does not pay goes. None where nothing surely better is left.
    """
    rivals = [rival for standing in found for rival in standing.rivals if not rival.is_cause]
    for rival in sorted(rivals, key=lambda rival: float(np.sum(squares_of(rival.state)))):
        if len(rival.labels) > MOST_CAUSES or not _beats(inquiry, rival.state, state):
            continue
        several, _ = pruned(inquiry, as_causes(inquiry, state, rival.labels))
        new = set_of(several) - set_of(state)
        if not new or len(set_of(several)) > MOST_CAUSES or set_of(several) in replaced:
            continue
        several = settled(inquiry, several)
        places = (i for i, label in enumerate(several.hypothesis.labels) if label in new)
        sound = not any(at_bound(inquiry.twin, several.hypothesis, i) for i in places)
        if sound and surely(inquiry, state, several) > inquiry.policy.anew:
            return several
    return None


def _beats(inquiry: Inquiry, new: State, old: State) -> bool:
    """Whether one state explains clearly and surely more than another."""
    return surely(inquiry, old, new) > inquiry.policy.anew and clearly_better(inquiry, new, old)


def _surely_beats(inquiry: Inquiry, state: State, standing: Standing, rival: Rival) -> bool:
    """Whether a rival is what should have been found: another cause, no fuller form of this one and no ripple, which
    with a few of its like draws any curve, that explains clearly and surely more, also where known numbers may leave
    their uncertainty a little beside what is there: a drive's gain makes up for all that are held back.
    """
    if not rival.is_cause or (rival.plainer, rival.label[1]) == standing.label or rival.extra >= 0.0:
        return False
    mine, other = state.hypothesis.causes[standing.entries[0]], rival.state.hypothesis.causes[-1]
    if other.family.ripple or numbers_of(other) > numbers_of(mine) + _MORE_NUMBERS:
        return False
    return _beats(inquiry, rival.state, state) and _beats(
        inquiry, rival.state, settled(inquiry, with_more_room(inquiry, state))
    )


__all__ = ["better_instead", "set_of"]
