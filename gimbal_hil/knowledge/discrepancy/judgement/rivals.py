"""Rivals of a cause: another cause, or several known numbers outside their uncertainty, that could explain the same.

Two explanations are compared only after both fits have converged: an unfinished rival looks worse than it is, and the
named cause looks more certain.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses import Hypothesis, at_bound, noise_of_command, plainer_of, weighed_cost
from gimbal_hil.knowledge.discrepancy.inquiry import (
    Inquiry,
    Policy,
    State,
    refitted,
    settled,
    squares_of,
    surely_less,
    weighing_of,
)
from gimbal_hil.knowledge.discrepancy.search import (
    OUT_OF_REACH,
    Path,
    basis_of,
    extended,
    in_its_place,
    numbers_instead,
    same_to_a_twin,
)
from gimbal_hil.knowledge.discrepancy.twin import Floats


@dataclass(frozen=True)
class Rival:
    """What could stand in the place of a cause: one other, or several known numbers that leave their uncertainty;
    squares that it leaves more, as a share of what is left (a floor at least), and how surely.
    """

    state: State
    labels: tuple[tuple[str, str], ...]
    extra: float
    sure: float
    #: the two differ by less than a twin is exact to
    same: bool
    #: squared floors a row that it leaves less, on the channel where that is most
    less: float = 0.0
    #: its numbers that may go no further
    at_bound: tuple[str, ...] = ()
    #: the effect with fewer numbers that it contains, where its numbers stand
    plainer: str | None = None

    @property
    def label(self) -> tuple[str, str]:
        """(effect, axis) of the first."""
        return self.labels[0]

    @property
    def is_there(self) -> bool:
        """Whether it is a further entry of what stands in the explanation anyway."""
        return _is_there(self.state, self.label)

    @property
    def is_cause(self) -> bool:
        """Whether it is a cause of its state, not numbers that moved."""
        return self.label in self.state.hypothesis.labels

    def close(self, policy: Policy) -> bool:
        """Whether data do not tell the two apart: they are the same to a twin, or blocks do not say it so surely."""
        return self.same or self.sure < (policy.anew if self.is_there else policy.sure)


def _is_there(state: State, label: tuple[str, str]) -> bool:
    return state.hypothesis.labels.count(label) > 1


def rivals_of(
    inquiry: Inquiry, path: Path, without: State, state: State, label: tuple[str, str], missing: Floats
) -> tuple[Rival, ...]:
    """What could stand in the place of the cause with a label, beside everything else of a state, closest first.

    `without` is the state without that cause, or without the first of its entries, `path` what was tried on the way,
    and `missing` the share of what the state leaves of each channel that can be predicted.
    """
    others = ((o, o.hypothesis.labels[-1]) for o in in_its_place(inquiry, path, without, state, label))
    # of a cause with several entries another one is nothing else
    found: list[tuple[State, tuple[tuple[str, str], ...]]] = [(o, (new,)) for o, new in others if new != label]
    numbers = numbers_instead(inquiry, without, state, label)
    if numbers is not None:
        free, labels = numbers
        found.append((_with_another_order(inquiry, free), labels))
    rivals = [
        _rival(inquiry, without, state, _at_its_best(inquiry, state, other, label), labels, missing)
        for other, labels in found
    ]
    return tuple(sorted(rivals, key=lambda rival: rival.extra))


def _with_another_order(inquiry: Inquiry, state: State) -> State:
    """A state whose known numbers were let go, with one more order of the ripples that it has, where that pays. Which
    orders it has was found beside the cause, that took a part of them; and a number that is off is the plainer story.
    """
    there = set(state.hypothesis.labels)
    own = tuple(family for family in inquiry.families if family.ripple and family.label in there)
    return extended(replace(inquiry, families=own), state, 1, ()).state if own else state


def _at_its_best(inquiry: Inquiry, state: State, other: State, label: tuple[str, str]) -> State:
    """Another explanation settled as the state is, where that could bring it near.

    Where neither of the two was there, other causes may have moved to take its part, and a fit from there ends in
    another valley. So it begins from where the state has them as well.
    """
    rest = state.hypothesis.minus(state.hypothesis.labels.index(label))
    if _stand_elsewhere(rest, other.hypothesis):
        anew = refitted(inquiry, state, rest.plus(other.hypothesis.causes[-1]))
        other = anew if np.sum(squares_of(anew)) < np.sum(squares_of(other)) else other
    weighing = weighing_of(inquiry, state)
    basis, rows = basis_of(other.fit, weighing)
    reach = float(rows @ rows - np.sum((basis.T @ rows) ** 2))
    if reach > OUT_OF_REACH * weighed_cost(state.fit, weighing):
        return other
    best = settled(inquiry, other)
    return best if np.sum(squares_of(best)) < np.sum(squares_of(other)) else other


def _stand_elsewhere(rest: Hypothesis, other: Hypothesis) -> bool:
    """Whether a cause of both stands elsewhere in the other one, which has one cause more, by more than a step; of a
    ripple, which is periodic, that is not asked.
    """
    shared = other.causes[: len(rest.causes)]
    alike = len(other.causes) == len(rest.causes) + 1 and rest.labels == other.labels[:-1]
    pairs = [(one, two) for one, two in zip(rest.causes, shared, strict=False) if one.family.ripple is None]
    return alike and any(abs(x - y) > 1.0 for one, two in pairs for x, y in zip(one.x, two.x, strict=True))


def _rival(
    inquiry: Inquiry, without: State, state: State, other: State, labels: tuple[tuple[str, str], ...], missing: Floats
) -> Rival:
    """Another explanation against a state, over all data."""
    mine, theirs = squares_of(state), squares_of(other)
    scale = np.maximum(mine, 1.0)
    # a share of what is left, which is noise at least
    extra = float(np.sum((theirs - mine) / scale)) / len(scale)
    # where one leaves much of one channel and the other much of another, neither is the unit of both
    sure = surely_less(inquiry, other, state, np.minimum(other.fit.squares, state.fit.squares))
    if _is_there(other, labels[0]):
        # a new name has to be earned against more of what is there anyway: whatever is left beyond noise may be that
        missing = np.maximum(missing, 1.0 - inquiry.policy.least_gap**2 / np.maximum(mine, inquiry.policy.least_gap**2))
    noisy, noisier = (noise_of_command(inquiry.twin, one.hypothesis, inquiry.floor) for one in (state, other))
    same = same_to_a_twin(inquiry.policy, mine, theirs, squares_of(without), noisier - noisy, missing)
    found = Rival(other, labels, extra, sure, same, float(np.max(mine - theirs)))
    if not found.is_cause:
        return found
    newest = len(other.hypothesis.causes) - 1
    bound = at_bound(inquiry.twin, other.hypothesis, newest)
    return replace(found, at_bound=bound, plainer=plainer_of(inquiry.twin, other.hypothesis, newest))


__all__ = ["Rival", "rivals_of"]
