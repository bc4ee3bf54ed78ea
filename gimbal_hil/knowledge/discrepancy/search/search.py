"""The search, step by step, each a function from state to state: add a cause, try every slot again, drop what does not
pay.

A step takes an inquiry (what is searched) and a state (a fitted hypothesis), and gives another state, or the same one
where nothing pays. What pays is decided by one score: squares that a cause takes, paired row by row with what is left
without it, on rows of the hold-out that select, in units of the remainder, with the standard error of its blocks.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import Cause, Hypothesis, at_bound, plainer_of
from gimbal_hil.knowledge.discrepancy.inquiry import (
    NEARLY_ALL,
    Inquiry,
    State,
    gain_on,
    mean_squares,
    refitted,
    stands_out,
    weighing_of,
)
from gimbal_hil.knowledge.discrepancy.search.candidates import ASKED, candidates, numbers_of
from gimbal_hil.knowledge.discrepancy.search.comparing import OUT_OF_REACH, clearly_better, no_worse, surely
from gimbal_hil.knowledge.discrepancy.search.curve import curve_does_as_well
from gimbal_hil.knowledge.discrepancy.search.release import released
from gimbal_hil.knowledge.discrepancy.search.screening import Response, basis_of, control_gain, responses, row_weights
from gimbal_hil.knowledge.discrepancy.twin import Floats
from sim_backend.effects import Start

#: where no cause pays alone, so many of them are tried with another one
_FIRST_OF_TWO = 2
#: how often the search is begun again where a slot was filled anew
_PASSES = 3
#: length of the blocks whose signs a negative control draws, s
_SIGN_S = 0.7


@dataclass(frozen=True)
class Round:
    """What one round tried beside the state that it started from."""

    before: State
    tried: tuple[State, ...]
    #: (effect, axis) -> share of what is left that the negative control of that candidate takes of the fitted rows
    controls: dict[tuple[str, str], float]


@dataclass(frozen=True)
class Path:
    """A state, the rounds that led to it, and responses that need not be heard again."""

    state: State
    rounds: tuple[Round, ...]
    heard: tuple[Response, ...]
    #: how many of the rounds, the first ones, were tried over other floors
    over_others: int = 0


def extended(inquiry: Inquiry, start: State, most: int, heard: tuple[Response, ...]) -> Path:
    """Add up to `most` causes to a start while they pay, drop what does not pay beside the others, try every slot
    again; once more where that changed anything.
    """
    path = Path(start, (), heard)
    for _ in range(_PASSES):
        while (room := most + _causes(start.hypothesis) - _causes(path.state.hypothesis)) > 0:
            if not stands_out(inquiry, path.state):
                break
            inquiry.tell(f"searching for cause {len(path.state.hypothesis.causes) + 1}")
            # beside the start numbers have been let go of already
            longer = one_more(inquiry, path, path.state is not start, room)
            ended, path = longer.state is path.state, longer
            if ended:
                break
        kept, without = pruned(inquiry, path.state)
        again = slots_again(inquiry, replace(path, state=kept), without)
        ended, path = again.state is kept, again
        if ended:
            break
    return path


def one_more(inquiry: Inquiry, path: Path, release: bool, room: int) -> Path:
    """The state with one more cause, that which pays best; or, where `release` lets them, with several numbers that
    leave their uncertainty; or, where none pays and there is room, with two; or the same state.
    """
    before = path.state
    tried = candidates(inquiry, before, path.heard)
    asked = tried[:ASKED]
    controls = {s.hypothesis.labels[-1]: control_share(inquiry, before, s.hypothesis.causes[-1]) for s in asked}
    paying = [s for s in asked if pays(inquiry, before, s, controls[s.hypothesis.labels[-1]])]
    sound = _sound(inquiry, before, paying)
    found = plainest(inquiry, before, sound or paying) if paying else before
    if found is not before:
        found = _rather_plainer(inquiry, path, found, [(state, state.hypothesis.labels[-1]) for state in sound])
    if found is not before and before.hypothesis.causes:
        found = refitted(inquiry, before, found.hypothesis)
    several = released(inquiry, before) if release else None
    if several is not None and _takes_over(inquiry, before, found, several):
        several, _ = pruned(inquiry, several)
        # of what paid together, what is left may be what was there before
        if _takes_over(inquiry, before, found, several):
            tried, found = [*tried, several], several
    path = replace(path, state=found, rounds=(*path.rounds, Round(before, tuple(tried), controls)))
    if found is not before or room < 2:
        return path
    return _two_at_once(inquiry, path, [s for s in asked if _is_no_chance(inquiry, before, s, controls)])


def _is_no_chance(inquiry: Inquiry, before: State, after: State, controls: dict[tuple[str, str], float]) -> bool:
    """Whether a cause takes enough of the fitted rows, and more than its negative control."""
    fitted = gain_on(inquiry, before, after, "fitted").mean
    beyond = controls[after.hypothesis.labels[-1]] <= inquiry.policy.control * fitted
    return beyond and _enough(inquiry, before.fitted, after.fitted)


def _two_at_once(inquiry: Inquiry, path: Path, tried: list[State]) -> Path:
    """The state with two causes of which neither pays alone, since in a part of the data they act against each other,
    if both together explain as good as all that is left; or the same state.
    """
    before = path.state
    for first in tried[:_FIRST_OF_TWO]:
        both = candidates(inquiry, first, path.heard)
        path = replace(path, rounds=(*path.rounds, Round(first, tuple(both), {})))
        for state in _sound(inquiry, first, [s for s in both[:ASKED] if _as_good_as_all(inquiry, before, s)]):
            control = control_share(inquiry, first, state.hypothesis.causes[-1])
            if pays(inquiry, first, state, control) and pays(inquiry, before, state):
                return replace(path, state=refitted(inquiry, before, state.hypothesis))
    return path


def _as_good_as_all(inquiry: Inquiry, before: State, after: State) -> bool:
    """Whether what is new in a state leaves no gap, or of the squares above the floor of all channels, in the fitted
    rows and in those that select, no more than the share that a cause must take to pay.
    """
    if not stands_out(inquiry, after):
        return True
    gaps = [
        [float(np.sum(np.maximum(mean_squares(rows) - 1.0, 0.0))) for rows in (state.fitted, state.selecting)]
        for state in (before, after)
    ]
    return all(left <= inquiry.policy.least_share * was for was, left in zip(*gaps, strict=True))


def _rather_plainer(inquiry: Inquiry, path: Path, found: State, plain: list[tuple[State, tuple[str, str]]]) -> State:
    """The state with the plainer form of another one's newest cause, where it leaves no gap, or explains as much with
    one cause beside it that pays: what the fuller form takes more may be that cause.

    `plain` are states, each with the label of the cause that may be the plainer form.
    """
    effect, axis = found.hypothesis.labels[-1]
    contained = (plainer_of(inquiry.twin, found.hypothesis, len(found.hypothesis.causes) - 1), axis)
    for state in (s for s, label in plain if label == contained):
        if np.sum(state.fit.squares) > OUT_OF_REACH * np.sum(np.maximum(found.fit.squares, 1.0)):
            continue
        if not stands_out(inquiry, state):
            return state
        beside = [s for s in candidates(inquiry, state, path.heard) if s.hypothesis.labels[-1] != (effect, axis)]
        if beside and pays(inquiry, state, beside[0]) and not clearly_better(inquiry, found, beside[0]):
            return state
    return found


def _takes_over(inquiry: Inquiry, before: State, found: State, several: State) -> bool:
    """Whether several numbers that leave their uncertainty pay beside the best single cause."""
    return pays(inquiry, found, several) and clearly_better(inquiry, several, found)


def plainest(inquiry: Inquiry, before: State, paying: list[State]) -> State:
    """Of states that pay, best first, the plainest one that the best does not clearly beat: another order of a ripple
    that is there, then the cause with fewest numbers.
    """

    def is_new(state: State) -> bool:
        return state.hypothesis.labels[-1] not in before.hypothesis.labels

    def plainness(state: State) -> tuple[bool, int]:
        return is_new(state), numbers_of(state.hypothesis.causes[-1])

    best = paying[0]
    for other in sorted(paying[1:], key=plainness):
        if plainness(other) < plainness(best):
            beaten = clearly_better(inquiry, best, other)
            if is_new(best) and not is_new(other):
                beaten = beaten and surely(inquiry, other, best) > inquiry.policy.anew
            if not beaten:
                return other
    return best


def _sound(inquiry: Inquiry, before: State, states: list[State]) -> list[State]:
    """Those whose newest cause stands inside its bounds and is no curve that several ripples could draw: at the edge of
    what it may be it is hardly that cause.
    """
    inside = [state for state in states if not _newest_at_bound(inquiry, state)]
    return [state for state in inside if not curve_does_as_well(inquiry, before, state)]


def _newest_at_bound(inquiry: Inquiry, state: State) -> bool:
    return bool(at_bound(inquiry.twin, state.hypothesis, len(state.hypothesis.causes) - 1))


def in_its_place(inquiry: Inquiry, path: Path, without: State, state: State, label: tuple[str, str]) -> list[State]:
    """States with another cause in the place of the one with a label, beside the others of a state: what was tried on
    the way, and what does most of what that cause does.
    """
    others, on_the_way = sorted(without.hypothesis.labels), []
    for one in reversed(path.rounds[path.over_others :]):
        if (
            sorted(one.before.hypothesis.labels) == others
            and one.before.hypothesis.floating == without.hypothesis.floating
        ):
            alone = (state for state in one.tried if sorted(state.hypothesis.labels[:-1]) == others)
            on_the_way = [state for state in alone if state.hypothesis.labels[-1] != label]
            break
    tried = frozenset(other.hypothesis.labels[-1] for other in on_the_way)
    return [*on_the_way, *candidates(inquiry, without, path.heard, state, tried)]


def pays(inquiry: Inquiry, before: State, after: State, control: float = 0.0) -> bool:
    """Whether what is new in a state pays: there was something to explain, and it takes of it surely and enough, on
    fitted data and on data that were not, and more than its negative control.

    What the hold-out hardly shows pays where it takes nearly all that is left of the fitted logs.
    """
    policy = inquiry.policy
    if not stands_out(inquiry, before, after):
        return False
    fitted = gain_on(inquiry, before, after, "fitted")
    taken = float(np.sum(before.fit.squares - after.fit.squares))
    # one event in a log has no blocks to be sure by, but what takes nearly all of a gap needs none
    nearly_all = taken > NEARLY_ALL * float(np.sum(np.maximum(before.fit.squares - 1.0, 0.0)))
    if control > policy.control * fitted.mean or not _enough(inquiry, before.fitted, after.fitted):
        return False
    if fitted.sure < 0.5 * policy.sure and not nearly_all:
        return False
    if shown(inquiry, before, after):
        return nearly_all or surely(inquiry, before, after) > policy.sure
    return nearly_all and no_worse(before.selecting, after.selecting)


def shown(inquiry: Inquiry, before: State, after: State) -> bool:
    """Whether the half of the hold-out that selects shows what is new in a state."""
    held = gain_on(inquiry, before, after, "selecting")
    return held.sure > 0.5 * inquiry.policy.sure and _enough(inquiry, before.selecting, after.selecting)


def _enough(inquiry: Inquiry, before: Floats, after: Floats) -> bool:
    """Whether the squares taken are a share of what was left, on the channel where it shows most, and more than a floor
    is known to.
    """
    squares = np.mean(before**2, axis=0)
    taken = squares - np.mean(after**2, axis=0)
    policy = inquiry.policy
    return bool(np.any((taken > policy.least_share * squares) & (taken > policy.least_squares)))


def control_share(inquiry: Inquiry, before: State, cause: Cause) -> float:
    """Share that the negative control of a cause takes of the fitted rows beside a state: its own response,
    scrambled.
    """
    start = Start((cause.x,), cause.x)
    columns = responses(inquiry.twin, before.hypothesis, before.fitted, inquiry.floor, cause.family, start)
    if columns is None:
        return 0.0
    weighing = weighing_of(inquiry, before)
    basis, residual = basis_of(before.fit, weighing)
    residual = residual - basis @ (basis.T @ residual)
    columns = columns * row_weights(before.fit, weighing)[:, None]
    bands = inquiry.twin.records[0].bands
    block = 0 if cause.family.ripple else max(2, int(_SIGN_S / (bands.stride * bands.period_s)))
    gain = control_gain(columns, residual, basis, list(inquiry.row_counts), len(inquiry.twin.channels), block, seed=3)
    return gain * weighing.spread**2 / len(before.fitted)


def slots_again(inquiry: Inquiry, path: Path, without_each: Mapping[int, State]) -> Path:
    """Replace each cause by a better one given the others; the only one was found beside nothing else.

    `without_each` are the states without one of the causes, refitted, where they are known.
    """
    began = path.state
    for index in range(len(began.hypothesis.causes)):
        state = path.state
        if len(set(state.hypothesis.labels)) == 1 or state.hypothesis.labels.count(state.hypothesis.labels[index]) > 1:
            # entries of one ripple do not stand in each other's place
            continue
        without = without_each.get(index) if state is began else None
        without = without or refitted(inquiry, state, state.hypothesis.minus(index))
        tried = candidates(inquiry, without, path.heard, state)
        path = replace(path, rounds=(*path.rounds, Round(without, tuple(tried), {})))
        tried = _sound(inquiry, without, tried)
        if tried and clearly_better(inquiry, tried[0], state):
            best, here = plainest(inquiry, without, tried), (state, state.hypothesis.labels[index])
            path = replace(path, state=_rather_plainer(inquiry, path, best, [here]))
    return path


def pruned(inquiry: Inquiry, state: State) -> tuple[State, dict[int, State]]:
    """Drop every cause that does not pay beside the others, the least first; answers what stays, and by index the
    states without one of its causes that were looked at last. What paid beside more causes is taken to pay beside
    fewer: what could take its part is gone.
    """
    asked: Collection[int] = range(len(state.hypothesis.causes))
    while True:
        without = {i: refitted(inquiry, state, state.hypothesis.minus(i)) for i in asked}
        losses = {
            i: gain_on(inquiry, one, state, "fitted").mean
            for i, one in without.items()
            if not pays(inquiry, one, state)
        }
        if not losses:
            return state, without
        least = min(losses, key=lambda i: losses[i])
        state, asked = without[least], [i - (i > least) for i in losses if i != least]


def _causes(hypothesis: Hypothesis) -> int:
    return len(set(hypothesis.labels))
