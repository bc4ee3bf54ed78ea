"""Summarises all rows for the fit of a law: quadratics in its values at dense knots, one for each stretch of the logs.

With them a formula of a few numbers is fitted, and cross-validated on other stretches, without touching the rows again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry
from gimbal_hil.knowledge.discrepancy.laws.curve import channel_of, columns_on, seen_of
from gimbal_hil.knowledge.discrepancy.laws.knots import Knots, RangeSeen, knots_of
from gimbal_hil.knowledge.discrepancy.laws.linear import FOLDS, Normal, Solved, Straight
from gimbal_hil.knowledge.discrepancy.laws.shape import LawShape
from gimbal_hil.knowledge.discrepancy.twin import Floats

#: knots that stand for the variable, and for each of two
_DENSE, _ACROSS = 120, (44, 14)
#: knots lie at least so far apart, share of the range
_APART = 1e-4
#: of a form's own normal matrix, so that scales which say the same share what there is
_RIDGE = 1e-9


@dataclass(frozen=True)
class Saying:
    """Quadratics in the values at dense knots (both directions one after the other) and the known numbers, by fold.

    `points` are the values of each variable there, (n,) each.
    """

    shape: LawShape
    straight: Straight
    points: tuple[Floats, ...]
    #: of the first variable, closer where the law bends
    places: Floats
    folds: tuple[Normal, ...]
    #: squares of each fold without a law, and its rows, both weighed
    squares: Floats
    rows: Floats

    @classmethod
    def of(
        cls,
        inquiry: Inquiry,
        straight: Straight,
        shape: LawShape,
        there: Floats | None = None,
        drawn: Knots | None = None,
        is_dense: bool = False,
    ) -> Saying:
        """Around a state; `there` (rows,) is what a law of this shape that it has already does to its channel, drawn
        through the knots `drawn`, which may be dense enough to stand for its variables.
        """
        seen = seen_of(inquiry, shape)
        knots = drawn if drawn is not None and is_dense else _dense(inquiry, seen)
        columns, channel = columns_on(inquiry, seen, knots), channel_of(inquiry, shape.axis)
        if there is not None:
            left = straight.left.copy()
            left[:, channel] -= there
            straight = straight.around(left)
        folds = straight.normals(columns, channel)
        weighed = (straight.weight * straight.left) ** 2
        mine = [straight.fold == k for k in range(FOLDS)]
        squares = np.array([float(np.sum(weighed[rows])) for rows in mine])
        rows = np.array([float(np.sum(rows)) for rows in mine]) * straight.weight**2
        return cls(shape, straight, points_of(knots), np.array((drawn or knots)[0]), folds, squares, rows)

    def without(self, fold: int) -> Floats:
        """How often each fold counts where one is left out."""
        return np.where(np.arange(FOLDS) == fold, 0.0, 1.0)

    def reduced(self, times: Floats) -> Normal:
        """The quadratic of the values alone: known numbers follow, held by what they are known to."""
        matrix = np.asarray(sum(n * one.matrix for n, one in zip(times, self.folds, strict=True)))
        side = np.asarray(sum(n * one.side for n, one in zip(times, self.folds, strict=True)))
        count = len(side) - len(self.straight.y)
        if count == len(side):
            return Normal(matrix, side)
        prior = self.straight.prior**2
        inner, cross = matrix[count:, count:] + np.diag(prior), matrix[:count, count:]
        follows = np.linalg.solve(inner, np.column_stack([cross.T, side[count:] - prior * self.straight.y]))
        return Normal(matrix[:count, :count] - cross @ follows[:, :-1], side[:count] - cross @ follows[:, -1])

    def solved(self, columns: Floats, times: Floats) -> Solved:
        """The best scales of these columns (values, scales), and how far known numbers move beside them."""
        count = len(columns)
        size = np.array([max(float(one), 1e-300) for one in np.sqrt(np.mean(columns**2, axis=0))])
        columns = columns / size
        parts = []
        for one in self.folds:
            cross = columns.T @ one.matrix[:count, count:]
            inner = columns.T @ one.matrix[:count, :count] @ columns
            matrix = np.block([[inner, cross], [cross.T, one.matrix[count:, count:]]])
            parts.append(Normal(matrix, np.concatenate([columns.T @ one.side[:count], one.side[count:]])))
        found = self.straight.solved(tuple(parts), times)
        return Solved(found.values / size, found.moved)

    def without_a_law(self) -> float:
        """Weighed squares that known numbers leave of stretches which did not move them."""
        none, total = np.zeros((len(self.folds[0].side) - len(self.straight.y), 0)), 0.0
        for k in range(FOLDS):
            others = self.without(k)
            total += self.left(none, self.solved(none, others), 1.0 - others)
        return total

    def left(self, columns: Floats, found: Solved, times: Floats) -> float:
        """Weighed squares that a law leaves of all channels, each fold counted so often."""
        both = np.concatenate([columns @ found.values, found.moved])
        each = [
            squares + both @ one.matrix @ both - 2.0 * one.side @ both
            for squares, one in zip(self.squares, self.folds, strict=True)
        ]
        return float(times @ np.array(each))


def _dense(inquiry: Inquiry, seen: RangeSeen) -> Knots:
    """Knots that stand for the variables, over all rows that may select."""
    shape, fitted = seen.shape, len(inquiry.twin.records)
    knots = []
    for i, over in enumerate(shape.over):
        used = seen.selecting(i, fitted)
        low, high = float(min(map(np.min, used))), float(max(map(np.max, used)))
        one = len(shape.over) == 1
        knots.append(knots_of(over, low, high, _DENSE) if one else _where_it_was(used, low, high, _ACROSS[i]))
    return tuple(knots)


def _where_it_was(used: list[Floats], low: float, high: float, count: int) -> tuple[float, ...]:
    """Knots of which one half is spread evenly, and the other by where the variable was."""
    by_rows = np.quantile(np.concatenate(used), np.linspace(0.0, 1.0, count - count // 2 + 2)[1:-1])
    both = np.sort(np.concatenate([np.linspace(low, high, count // 2), by_rows]))
    apart = np.concatenate([[True], np.diff(both) > _APART * (high - low)])
    return tuple(float(at) for at in both[apart][:-1]) + (high,)


def points_of(knots: Knots) -> tuple[Floats, ...]:
    """Values of each variable at all knots, those of the second fastest, (n,) each."""
    if len(knots) == 1:
        return (np.array(knots[0]),)
    first, second = (np.array(part) for part in knots)
    return np.repeat(first, len(second)), np.tile(second, len(first))


def takes(reduced: Normal, columns: Floats) -> float:
    """Weighed squares that the best scales of these columns take."""
    inner, side = columns.T @ reduced.matrix @ columns, columns.T @ reduced.side
    size = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    inner = inner / np.outer(size, size) + _RIDGE * np.eye(len(side))
    side = side / size
    try:
        return float(side @ np.linalg.solve(inner, side))
    except np.linalg.LinAlgError:
        return 0.0


__all__ = ["Saying", "points_of", "takes"]
