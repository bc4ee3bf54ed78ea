"""What is fitted together with a curve: the known numbers of the model, as far as they act in a straight line.

Curve and numbers are one least-squares problem, in which the numbers keep the prior that the model states. Its normal
matrices are summed by folds, stretches of all logs, so that what each stretch says of a curve that the others gave
costs one small solution more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.knowledge.discrepancy.hypotheses import STEP, Hypothesis, command_residual, prior_weights
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, State, weighing_of
from gimbal_hil.knowledge.discrepancy.twin import Floats, Twin

#: of a curve's own normal matrix, so that it can be solved
_RIDGE = 1e-11
#: and what a bend may cost, of the same: as much as foretells best, so that knots of which few rows speak lie straight
#: on from the others and narrow shapes bend
_STIFF = (1e-5, 1e-3, 1e-1)
#: parts of which each is asked what the others say, stretches of each in every log, so that all parts see the same
#: range; and the rows that only judge
FOLDS, _STRETCHES, JUDGES = 4, 5, -1
#: how often numbers that would leave their uncertainty are put at its end
_TURNS = 3


class Normal(NamedTuple):
    """A normal matrix and its right side."""

    matrix: Floats
    side: Floats


@dataclass(frozen=True)
class Solved:
    """Values of a curve in the unit of its channel, and by how much each known number moves beside it."""

    values: Floats
    moved: Floats


class Foretold(NamedTuple):
    """Squares a row that a curve leaves of stretches which did not give it, in squared floors; and what its bends cost
    there, as `Straight.normals` takes it.
    """

    leaves: float
    bends: Floats


@dataclass(frozen=True)
class Straight:
    """What a state leaves of all data in floors, (rows, channels), rows of the fitted logs and then of the hold-out;
    what its known numbers do there, (rows, channels, numbers); where they stand, and what holds them.
    """

    left: Floats
    numbers: Floats
    y: Floats
    prior: Floats
    #: how far each may go to either side
    reach: Floats
    #: stretch of each row, `JUDGES` for rows of the untouched half
    fold: NDArray[np.int64]
    #: what a row counts for
    weight: float
    #: of the known numbers alone, by fold
    known: tuple[Normal, ...]

    @classmethod
    def of(cls, inquiry: Inquiry, state: State) -> Straight:
        """Around a state."""
        sides = ((inquiry.twin, state.hypothesis), (inquiry.holdout, state.held))
        numbers = np.concatenate([_slopes(twin, hypothesis, inquiry.floor) for twin, hypothesis in sides])
        left = np.concatenate([state.fitted, inquiry.in_order(state)])
        y, x = np.array(state.hypothesis.y), state.hypothesis.vector()
        prior = prior_weights(state.hypothesis)[len(x) - len(y) :]
        fold = np.concatenate([_stretches(n) for n in (*inquiry.row_counts, *inquiry.held_counts)])
        fold[len(state.fitted) :][~inquiry.selecting] = JUDGES
        weight = 1.0 / weighing_of(inquiry, state).spread
        known = []
        for k in range(FOLDS):
            J = numbers[fold == k].reshape(-1, len(y))
            known.append(Normal(weight**2 * J.T @ J, -(weight**2) * J.T @ left[fold == k].ravel()))
        reach = np.array([number.reach for number in state.hypothesis.floating])
        return cls(left, numbers, y, prior, reach, fold, weight, tuple(known))

    def around(self, left: Floats) -> Straight:
        """The same where the state leaves something else, (rows, channels)."""
        side = [
            -(self.weight**2) * self.numbers[self.fold == k].reshape(-1, len(self.y)).T @ left[self.fold == k].ravel()
            for k in range(FOLDS)
        ]
        known = tuple(Normal(one.matrix, each) for one, each in zip(self.known, side, strict=True))
        return replace(self, left=left, known=known)

    @property
    def judging(self) -> NDArray[np.bool_]:
        """Rows of the untouched half."""
        return self.fold == JUDGES

    def normals(self, columns: Floats, channel: int, bends: Floats | None = None) -> tuple[Normal, ...]:
        """Of curve and known numbers, by fold; `columns` (rows, values) are what the curve does to its channel, and
        `bends` (places, values) by how much it bends where, times the root of what that costs.
        """
        found = []
        for k, known in enumerate(self.known):
            mine = self.fold == k
            B = self.weight * columns[mine]
            cross = B.T @ (self.weight * self.numbers[mine][:, channel, :])
            matrix = np.block([[B.T @ B, cross], [cross.T, known.matrix]])
            found.append(Normal(matrix, np.concatenate([-B.T @ (self.weight * self.left[mine, channel]), known.side])))
        return self._stiffened(tuple(found), columns, bends)

    def _stiffened(self, normals: tuple[Normal, ...], columns: Floats, bends: Floats | None) -> tuple[Normal, ...]:
        """With what bends cost, a part of it in each fold."""
        if bends is None or not bends.size:
            return normals
        count = columns.shape[1]
        size = np.sum((self.weight * columns[~self.judging]) ** 2) / count
        stiff = np.zeros_like(normals[0].matrix)
        stiff[:count, :count] = size / len(normals) * bends.T @ bends
        return tuple(Normal(one.matrix + stiff, one.side) for one in normals)

    def solved(self, normals: tuple[Normal, ...], times: Floats | None = None) -> Solved:
        """The best of them together, each counted so many times."""
        times = np.ones(len(normals)) if times is None else times
        matrix = np.asarray(sum(n * one.matrix for n, one in zip(times, normals, strict=True)))
        side = np.asarray(sum(n * one.side for n, one in zip(times, normals, strict=True)))
        count = len(side) - len(self.y)
        held = np.full(len(side), _RIDGE * max(float(np.trace(matrix[:count, :count])) / max(count, 1), 1e-12))
        held[count:] = self.prior**2
        side[count:] -= self.prior**2 * self.y
        matrix = matrix + np.diag(held)
        both, free = np.zeros(len(side)), np.ones(len(side), dtype=bool)
        # what would leave its uncertainty stays at its end, and the rest is solved once more
        for _ in range(_TURNS):
            known = side[free] - matrix[np.ix_(free, ~free)] @ both[~free]
            both[free] = np.linalg.solve(matrix[np.ix_(free, free)], known)
            moved = np.clip(both[count:], -self.reach - self.y, self.reach - self.y)
            beyond = np.concatenate([np.zeros(count, dtype=bool), moved != both[count:]])
            both[count:] = moved
            if not beyond.any():
                break
            free &= ~beyond
        return Solved(both[:count], both[count:])

    def after(self, columns: Floats, channel: int, found: Solved) -> Floats:
        """What is left of a channel once a curve is there, (rows,)."""
        moved = self.numbers[:, channel, :] @ found.moved
        return np.asarray(self.left[:, channel] + moved + columns @ found.values)

    def foretold(self, columns: Floats, channel: int, bends: Floats) -> Foretold:
        """What a curve leaves of stretches which did not give it, as stiff as leaves least there."""
        found, soft = [], self.normals(columns, channel)
        for cost in _STIFF:
            normals = self._stiffened(soft, columns, np.sqrt(cost) * bends)
            total = 0.0
            for k in range(FOLDS):
                there = self.solved(normals, np.where(np.arange(FOLDS) == k, 0.0, 1.0))
                total += float(np.sum(self.after(columns, channel, there)[self.fold == k] ** 2))
            found.append(Foretold(total / int(np.sum(self.fold != JUDGES)), np.sqrt(cost) * bends))
        return min(found, key=lambda one: one.leaves)


def softest(bends: Floats) -> Floats:
    """Bends that cost as little as they may."""
    return np.asarray(np.sqrt(_STIFF[0]) * bends)


def _stretches(rows: int) -> NDArray[np.int64]:
    """Which stretch each row of a log belongs to."""
    return (np.arange(rows) * (FOLDS * _STRETCHES) // max(rows, 1)) % FOLDS


def _slopes(twin: Twin, hypothesis: Hypothesis, floor: Floats) -> Floats:
    """What each known number does to the residual, (rows, channels, numbers)."""
    here = command_residual(twin, hypothesis, floor)
    x, count = hypothesis.vector(), len(hypothesis.y)
    found = np.zeros((*here.shape, count))
    for k in range(count):
        moved, at = x.copy(), len(x) - count + k
        step = -STEP if x[at] > 0.0 else STEP
        moved[at] += step
        found[:, :, k] = (command_residual(twin, hypothesis.at(moved), floor) - here) / step
    return np.nan_to_num(found)
