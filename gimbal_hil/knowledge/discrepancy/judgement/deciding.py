"""Which causes are reported, and how surely: the probability of a name, of its class, and of something else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.discrepancy.hypotheses import Cause, plainer_of
from gimbal_hil.knowledge.discrepancy.inquiry import MOST_CAUSES, Inquiry, Policy, State, refitted, settled, squares_of
from gimbal_hil.knowledge.discrepancy.judgement.gap import channels_with_a_gap, is_a_gap
from gimbal_hil.knowledge.discrepancy.judgement.instead import better_instead, set_of
from gimbal_hil.knowledge.discrepancy.judgement.judging import Remainder, Standing, depends_on, remainders, standings
from gimbal_hil.knowledge.discrepancy.judgement.rivals import Rival
from gimbal_hil.knowledge.discrepancy.judgement.wander import left_beside_wander
from gimbal_hil.knowledge.discrepancy.search import (
    Path,
    clearly_better,
    extended,
    given_back,
    no_worse,
)
from sim_backend.effects import CATALOGUE, Variable

#: how often the judgement may begin anew for each cause with another one: left out, replaced, or replaced once more
_TURNS = 3
#: alternatives that are told
_MOST_RIVALS = 3


class Status(Enum):
    """How a cause is told."""

    NAMED = "named"
    AMBIGUOUS = "ambiguous"


class Kind(Enum):
    """The verdicts."""

    NAMED = "named"
    AMBIGUOUS = "ambiguous"
    UNEXPLAINED = "unexplained"
    #: no name fits, and a law does
    DESCRIBED = "described"
    NO_DISCREPANCY = "no_discrepancy"
    #: no gap, in logs that would not have shown an error of the size that matters
    CANNOT_JUDGE = "cannot_judge"
    UNUSABLE_DATA = "unusable_data"


@dataclass(frozen=True)
class Denial:
    """A number that is told as off, and what `identify` says of it on the same logs: both with intervals that exclude
    each other, and the latter nearer to what the model states.
    """

    label: tuple[str, str]
    parameter: str
    stated: float
    told: float
    identified: float
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class Told:
    """A cause as it is told: its standing, what else could be in its place, how probable name and class are."""

    standing: Standing
    status: Status
    close: tuple[Rival, ...]
    #: of the name; of the name, one of those that it cannot be told from, or what acts like it beyond its bound
    probability: float
    of_class: float
    #: data that had no part in the search shows it, and its numbers are inside their bounds
    shown: bool
    #: what another method says of the same logs against a number of this axis
    denials: tuple[Denial, ...] = ()

    @property
    def of_names(self) -> float:
        """Probability of the name or one of its alternatives: what stands at its bound is as likely neither."""
        return self.of_class - (self.probability if self.standing.at_bound else 0.0)


@dataclass(frozen=True)
class Decision:
    """What is told in the end."""

    kind: Kind
    state: State
    told: tuple[Told, ...]
    remainders: tuple[Remainder, ...]
    #: where nothing is told: the variable that what is left depends on, and the share that it predicts alone
    depends_on: tuple[Variable, float] | None = None
    #: low and high of numbers that another method identifies from the same logs, by axis and name
    identified: Mapping[tuple[str, str], tuple[float, float]] = field(default_factory=dict)


def decide(
    inquiry: Inquiry, stated: State, null: State, path: Path, suspected_only: bool, by_command: bool
) -> Decision:
    """Judge the causes that a search ended with; of those that do not stand one is left out, and the others are judged
    once more without it. `stated` and `null` are the model as its file has it and with its known numbers inside their
    uncertainty. `suspected_only`: no log can confirm a name. `by_command`: none says what an actuator gave.
    """
    if path.state.hypothesis.causes and _leaves_a_gap(inquiry, null):
        state = given_back(inquiry, settled(inquiry, path.state))
        state = _as_numbers(inquiry, state) if by_command else state
        beside_a_curve: dict[tuple[str, str], Told] = {}
        in_the_set: dict[tuple[str, str], Told] = {}
        replaced: set[frozenset[tuple[str, str]]] = set()
        turns = _TURNS * len(set(state.hypothesis.labels))
        for turn in range(turns + MOST_CAUSES + 1):
            if not no_worse(null.untouched, state.untouched):
                # what leaves more than the model alone explains nothing
                break
            left = remainders(inquiry, null, state)
            found = standings(inquiry, stated, null, state, path, left)
            # what came last is judged as well: afterwards causes only go
            instead = better_instead(inquiry, state, found, replaced, path) if turn < turns else None
            if instead is not None:
                replaced.add(set_of(state))
                state = settled(inquiry, instead)
                continue
            anew = (_told(inquiry, s, found, left, suspected_only) for s in found)
            told = tuple(_by_the_set(inquiry.policy, in_the_set, _as_before(beside_a_curve, t), left) for t in anew)
            fallen = [t for t in told if t.of_class < 0.5]
            if not fallen:
                return Decision(kind_of(told), state, told, left)
            # one at a time: of two that take the same neither is missed beside the other
            first = min(fallen, key=lambda t: (t.of_class, t.standing.share))
            complete = left[first.standing.channel].after <= inquiry.policy.least_gap
            if first.standing.any_curve and complete and len(fallen) == 1:
                # that something over position explains the rest, whatever its shape, is no doubt about what acts
                # through other variables
                beside_a_curve |= {t.standing.label: t for t in told if _stands_beside_a_curve(t)}
            # the set was judged as one: what a cause that is gone leaves is no doubt about what acts through others
            others = (t for t in told if not _acts_alike(t, first))
            in_the_set = {t.standing.label: in_the_set.get(t.standing.label, t) for t in others}
            rest = _left_out(inquiry, state, first.standing)
            if not rest.hypothesis.causes:
                break
            state = settled(inquiry, rest)
    left = remainders(inquiry, null, null)
    if _only_noise(inquiry, null, left):
        return Decision(Kind.NO_DISCREPANCY, null, (), left)
    return Decision(Kind.UNEXPLAINED, null, (), left, depends_on(inquiry, null, left))


def _left_out(inquiry: Inquiry, state: State, fallen: Standing) -> State:
    """A state without a cause that does not stand, with the plainer one in its place that it contains where it stands:
    what speaks against a ripple of order one is said of no unbalance. Further orders of a ripple that is there are
    added while they pay, if the same names then explain clearly more.
    """
    rest = state.hypothesis
    contained = {index: plainer_of(inquiry.twin, rest, index) for index in fallen.entries}
    plainer = {(name, fallen.label[1]) for name in contained.values() if name is not None}
    # what stands beside an order that is something plainer is a ripple by itself, and is judged anew
    gone = [index for index, name in contained.items() if name is not None] if plainer else fallen.entries
    for index in sorted(gone, reverse=True):
        rest = rest.minus(index)
    for family in (f for f in inquiry.families if f.label in plainer.difference(rest.labels)):
        rest = rest.plus(Cause(family, (0.0,) * len(family.knobs)))
    left = refitted(inquiry, state, rest)
    there = set(left.hypothesis.labels)
    own = tuple(family for family in inquiry.families if family.ripple and family.label in there)
    if not own:
        return left
    longer = extended(replace(inquiry, families=own), left, 1, ()).state
    same = set(longer.hypothesis.labels) == there
    return longer if same and clearly_better(inquiry, longer, left) else left


def _as_before(named: dict[tuple[str, str], Told], told: Told) -> Told:
    """A cause as it was told when something over position stood beside it, with the standing that it has now; as it is
    told now where data no longer show it.
    """
    return replace(named.get(told.standing.label, told), standing=told.standing) if told.shown else told


def _by_the_set(
    policy: Policy, in_the_set: dict[tuple[str, str], Told], told: Told, left: tuple[Remainder, ...]
) -> Told:
    """A cause as it was told in the set that was found, by as much as it closes of the gap that is there beside those
    that still stand, where that is more than it is told as beside what has gone.
    """
    first = in_the_set.get(told.standing.label)
    if first is None or not told.shown:
        return told
    takes = max(0.0, float(told.standing.takes[told.standing.channel]))
    open_still = max(0.0, left[told.standing.channel].after ** 2 - 1.0)
    of_class = first.of_class * takes / max(takes + open_still, 1e-9)
    if of_class <= told.of_class:
        return told
    return rejudged(policy, replace(first, standing=told.standing, of_class=of_class), first.close)


def _acts_alike(one: Told, other: Told) -> bool:
    """Whether two causes act through the same variable, so that one could have taken a part of the other."""
    mine, others = (CATALOGUE[told.standing.label[0]].acts_through for told in (one, other))
    return bool(mine & others)


def _stands_beside_a_curve(told: Told) -> bool:
    """Whether a cause is named, alone, and through other variables than position."""
    through = CATALOGUE[told.standing.label[0]].acts_through
    return told.status is Status.NAMED and not told.close and Variable.POSITION not in through


def _as_numbers(inquiry: Inquiry, state: State) -> State:
    """The same with a number of the model in the place of what commanded torque never tells from it: either name is
    right, and a number that is off needs nothing new.
    """
    families = {family.label: family for family in inquiry.families}
    for effect, axis in dict.fromkeys(state.hypothesis.labels):
        twin = CATALOGUE[effect].same_by_command or ""
        family, labels = families.get((twin, axis)), state.hypothesis.labels
        if family is None or family.label in labels or CATALOGUE[effect].is_number or not CATALOGUE[twin].is_number:
            continue
        cause = Cause(family, (0.0,) * len(family.knobs))
        rest = state.hypothesis.minus(labels.index((effect, axis)))
        other = settled(inquiry, refitted(inquiry, state, rest.plus(cause)))
        before, after = (float(np.sum(squares_of(one))) for one in (state, other))
        if after < (1.0 + inquiry.policy.same) * before:
            state = other
    return state


def _leaves_a_gap(inquiry: Inquiry, null: State) -> bool:
    """Whether the model leaves a gap."""
    return is_a_gap(inquiry, null.fitted, inquiry.in_order(null), lambda: left_beside_wander(inquiry, null))


def beyond_noise(inquiry: Inquiry, null: State) -> NDArray[np.bool_]:
    """Channels of which the model leaves a gap that friction whose level wanders is no reason for, (channels,)."""
    gaps = channels_with_a_gap(inquiry, null.fitted, inquiry.in_order(null))
    return gaps & (left_beside_wander(inquiry, null) > inquiry.policy.not_repeated)


def _only_noise(inquiry: Inquiry, null: State, left: tuple[Remainder, ...]) -> bool:
    """Whether what a state leaves is no gap: at the floor, or small and nothing predicts it, or friction whose level
    wanders.
    """
    policy = inquiry.policy
    if not _leaves_a_gap(inquiry, null):
        return True
    most = policy.not_repeated
    small = bool(np.all(null.left() <= most)) and all(r.predictable.beyond < policy.exhausted for r in left)
    return small or bool(np.all(left_beside_wander(inquiry, null) <= most))


def _told(
    inquiry: Inquiry,
    standing: Standing,
    found: tuple[Standing, ...],
    left: tuple[Remainder, ...],
    suspected_only: bool,
) -> Told:
    policy = inquiry.policy
    # what stands at its bound is as little an equal of what does not as it would be named itself
    rivals = (rival for rival in standing.rivals if standing.at_bound or not rival.at_bound)
    close = tuple(r for r in rivals if r.close(policy))
    # what stands at its bound is not what its name says: something else takes as much
    unknown = sum(other.takes[standing.channel] for other in found if other.at_bound and other is not standing)
    of_class = class_probability(standing, left[standing.channel], policy, len(inquiry.families), unknown)
    shown = not suspected_only and not standing.silent and not standing.at_bound
    close = close[:_MOST_RIVALS]
    return rejudged(policy, Told(standing, Status.AMBIGUOUS, close, of_class, of_class, shown), close)


def rejudged(policy: Policy, one: Told, close: tuple[Rival, ...]) -> Told:
    """A cause beside these alternatives."""
    effect, axis = one.standing.label
    # the cause itself with more numbers that do not pay is nothing else
    close = tuple(rival for rival in close if not _contains(rival, one.standing, policy))
    # commanded torque alone never tells such a pair apart: either name is right
    others = [rival for rival in close if rival.label != (CATALOGUE[effect].same_by_command, axis)]
    # what stands at its bound is as likely something else that only acts like it
    odds = sum(odds_against(rival, policy) for rival in others) + bool(one.standing.at_bound)
    alone = 1.0 / (1.0 + odds)
    sure = one.shown and not one.denials and one.of_class >= policy.named and alone >= policy.alone
    return replace(
        one, close=close, probability=one.of_class * alone, status=Status.NAMED if sure else Status.AMBIGUOUS
    )


def odds_against(rival: Rival, policy: Policy) -> float:
    """Odds of a rival against the cause: even where a twin is not exact enough to tell them apart, otherwise those of
    their difference being chance.
    """
    from scipy.stats import norm

    if rival.is_there or rival.same:
        return 1.0
    return min(1.0, float(norm.cdf(-rival.sure) / norm.cdf(rival.sure)))


def _contains(rival: Rival, standing: Standing, policy: Policy) -> bool:
    """Whether a rival is the cause itself with more numbers, which do not pay as a cause must, or not surely."""
    pays = rival.sure <= -policy.anew and rival.less >= policy.least_squares
    return (rival.plainer, rival.label[1]) == standing.label and not pays


def kind_of(told: tuple[Told, ...]) -> Kind:
    """The verdict of causes that are told."""
    return Kind.NAMED if all(one.status is Status.NAMED for one in told) else Kind.AMBIGUOUS


def class_probability(
    standing: Standing, left: Remainder, policy: Policy, candidates: int, unknown: float = 0.0
) -> float:
    """Probability that the cause, or one that this data cannot tell from it, is there.

    Ten things speak against it: where it acts the model leaves no gap, or none beside the other causes; what it takes
    may be chance; any curve over position takes as much; its own variables still predict what is left; its strength is
    another from stretch to stretch; beside everything else it may as well have none; it does many times what was there,
    and others undo it; others predict so much of what is left that the cause may be a part of theirs, or what is not
    known takes as many squares of its channel (`unknown`); many times what it takes is left that nothing predicts, or
    most of what was there; and it took little.
    """
    from scipy.stats import norm

    if standing.any_curve or not standing.explains:
        return 0.0
    # that the best of so many candidates does not do so well by chance (Sidak)
    evident = float(norm.cdf(standing.sure)) ** candidates
    beside = (1.0 - standing.share) / max(standing.share, 1e-9)
    if left.after > policy.least_gap:
        # a few floors that are next to nothing beside what the cause takes are no sign of another shape
        much = max(beside / _NEXT_TO_NOTHING, (left.after / _FEW) ** 2)
        shape = 1.0 / (1.0 + (standing.exhausted.beyond * min(1.0, much) / (2.0 * policy.exhausted)) ** 3)
        missing, unknown_rms = left.predictable.beyond, left.unpredicted
    else:
        # what is no gap says nothing against what closed one, unless a cause's own variables predict as much of it as
        # was closed of the hold-out, or as the cause takes of all data where the hold-out hardly shows it
        closed = max(left.before**2 - left.after**2, float(standing.takes[standing.channel]), 1e-9)
        shape = 1.0 / (1.0 + (standing.exhausted.beyond * left.after**2 / closed) ** 4)
        missing, unknown_rms = 0.0, 0.0
    steady = 1.0 / (1.0 + (standing.uneven / policy.uneven) ** 4)
    # even odds where the interval of its strength just holds nothing; and of what causes that undo each other leave
    # over, much is no more than a twin is exact to
    inexact = policy.same * standing.does
    known = 1.0 / (1.0 + standing.error**6 + (inexact / _EXACT) ** 6)
    # what one thing through other variables does, a cause that is no part of it may take a share of
    others = missing * beside
    beyond_it = max(0.0, unknown) / max(standing.takes[standing.channel], 1e-9)
    whole = 1.0 / (1.0 + (others / _OTHERS) ** 2 + (beyond_it / _UNKNOWN) ** 2)
    # what is left beyond the noise, over what the cause takes; and beyond a small multiple of it, over what was there
    beside_it = max(0.0, unknown_rms**2 - 1.0) / max(standing.takes[standing.channel], 1e-9)
    beyond = max(0.0, unknown_rms**2 - policy.least_gap**2) / max(left.before**2, 1.0)
    size = 1.0 / (1.0 + (beside_it / _DWARFED) ** 6 + (beyond / _LARGE) ** 4)
    share = max(standing.share, left.closed if left.before > policy.least_gap else 0.0)
    taken = share / (share + _LITTLE)
    return float(np.clip(_MOST * evident * shape * steady * known * whole * size * taken, 0.0, _MOST))


#: at these something else is as likely: what is left and other variables predict, what stands at its bound takes, and
#: what no variable predicts, over what a cause takes; the share of the squares that were there that no variable
#: predicts; the share of a channel that a cause takes. And the most that is said.
_OTHERS, _UNKNOWN, _DWARFED, _LARGE, _LITTLE, _MOST = 0.25, 0.5, 8.0, 0.8, 0.02, 0.99
#: what is left over what a cause takes, squares: below this it counts by how much it is
_NEXT_TO_NOTHING = 0.05
#: where what a cause does is inexact by this share of the gap that was there, it closes it as likely by chance
_EXACT = 0.25
#: and so many floors are no longer few
_FEW = 6.0

__all__ = ["Decision", "Kind", "Status", "Told", "class_probability", "decide", "kind_of", "odds_against", "rejudged"]
