"""Two explanations of a gap, and the better of them: several known numbers that are wrong at once, or single causes."""

from __future__ import annotations

from dataclasses import replace

from gimbal_hil.knowledge.discrepancy.hypotheses import Hypothesis
from gimbal_hil.knowledge.discrepancy.inquiry import (
    MOST_CAUSES,
    Inquiry,
    State,
    refitted,
    settled,
    squares_of,
    stands_out,
)
from gimbal_hil.knowledge.discrepancy.search.candidates import listen, numbers_of
from gimbal_hil.knowledge.discrepancy.search.comparing import clearly_better, same_to_a_twin
from gimbal_hil.knowledge.discrepancy.search.release import released
from gimbal_hil.knowledge.discrepancy.search.screening import Response
from gimbal_hil.knowledge.discrepancy.search.search import Path, Round, extended, pays


def explain(inquiry: Inquiry, start: State, most: int = MOST_CAUSES, heard: tuple[Response, ...] | None = None) -> Path:
    """The better of two stories: known numbers that leave their uncertainty, several at once, and whatever is missing
    beside them; or single causes from the start. Of two that the data do not tell apart it is the one with fewer
    numbers: a drive's gain that is off looks like every inertia and friction being off.

    `heard` is what the families do to the residual, where that has been listened to already.
    """
    if heard is None:
        heard = tuple(listen(inquiry, start.fit, [f for f in inquiry.families if not f.ripple]))
    numbers = released(inquiry, start) if most > 1 else None
    if numbers is None or not pays(inquiry, start, numbers):
        return extended(inquiry, start, most, heard)
    story = extended(inquiry, numbers, most, heard)
    story = replace(story, rounds=(Round(start, (numbers,), {}), *story.rounds))
    # where nothing is left to explain, one cause alone could still be plainer
    other = extended(inquiry, start, most if stands_out(inquiry, story.state) else 1, heard)
    return _better(inquiry, start, other, story)


def explain_again(inquiry: Inquiry, start: State, found: Hypothesis, heard: tuple[Response, ...]) -> Path:
    """The better of two stories under other floors than those under which a hypothesis was found: what is found from
    the start, since what paid there may not pay here; or that hypothesis and whatever is missing beside it, since a
    search from the start may miss what led to these floors.
    """
    anew = explain(inquiry, start, heard=heard)
    state = refitted(inquiry, start, _as_it_was(found, start.hypothesis))
    # once more beside what it leaves: beside the whole gap a fit is content once it explains most of it
    state = refitted(inquiry, state, state.hypothesis)
    further = extended(inquiry, state, MOST_CAUSES - len(set(found.labels)), heard)
    return _better(inquiry, start, anew, further)


def _as_it_was(found: Hypothesis, start: Hypothesis) -> Hypothesis:
    """The causes of one hypothesis, and its known numbers where those of a start may move."""
    moved = {(known.axis, known.path): y for known, y in zip(found.floating, found.y, strict=True)}
    y = (moved.get((known.axis, known.path), y) for known, y in zip(start.floating, start.y, strict=True))
    return replace(found, floating=start.floating, y=tuple(y))


def _better(inquiry: Inquiry, start: State, *paths: Path) -> Path:
    """The better of two stories, with the rounds of both; of equally many numbers the first counts as the plainer."""
    # one that is still on its way looks worse than it is
    stories = [replace(path, state=settled(inquiry, path.state)) for path in paths]
    plainer, fuller = sorted(stories, key=lambda path: _free_numbers(path.state.hypothesis))
    better = fuller if _more_is_there(inquiry, start, fuller.state, plainer.state) else plainer
    return replace(better, rounds=tuple(one for path in paths for one in path.rounds))


def _more_is_there(inquiry: Inquiry, start: State, fuller: State, plainer: State) -> bool:
    """Whether a story is better than one with fewer numbers: clearly, and where that leaves no gap by more than a twin
    is exact to.
    """
    if not clearly_better(inquiry, fuller, plainer):
        return False
    squares = (squares_of(state) for state in (fuller, plainer, start))
    return stands_out(inquiry, plainer) or not same_to_a_twin(inquiry.policy, *squares)


def _free_numbers(hypothesis: Hypothesis) -> int:
    return sum(numbers_of(cause) for cause in hypothesis.causes)
