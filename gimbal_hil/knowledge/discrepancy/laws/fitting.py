"""Fits a formula's numbers: its best places, widths and waves; and the penalty for its length."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.knowledge.discrepancy.laws.forms import FormNumber, FormTerm, NumberRole
from gimbal_hil.knowledge.discrepancy.laws.linear import FOLDS, Solved
from gimbal_hil.knowledge.discrepancy.laws.saying import Saying, takes
from gimbal_hil.knowledge.discrepancy.twin import Floats

#: shares of the knots at which places are first looked for, and of the range widths, and waves over the range
_PLACES = (0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.98)
_WIDTHS = (0.003, 0.01, 0.03, 0.07, 0.15, 0.25, 0.35, 0.5, 0.8)
_WAVES = tuple(0.5 * 1.25**k for k in range(18))
#: steps of the simplex for each number that is moved, at first and once more
_STEPS, _AGAIN = 90, 45
#: first size of the simplex: of a place, a share of the range; of a width and a wave, of its logarithm
_SIZE = {NumberRole.PLACE: 0.03, NumberRole.WIDTH: 0.3, NumberRole.WAVE: 0.1}
#: widths are no narrower than this share of the range, and no wider than so many ranges
_NARROWEST, _WIDEST = 1e-4, 4.0
_ALL = np.ones(FOLDS)


@dataclass(frozen=True)
class Written:
    """Terms with their inner numbers, plain parts beside them, and how well stretches without a part in it foretell."""

    terms: tuple[FormTerm, ...]
    inner: tuple[Floats, ...]
    #: weighed squares that it takes of all rows, and that it leaves of stretches which did not give its numbers
    takes: float
    leaves: float = np.inf

    @property
    def numbers(self) -> int:
        """How many numbers it has."""
        return sum(len(term.form.numbers) for term in self.terms)

    def columns(self, saying: Saying) -> Floats:
        """What each of its scales multiplies, (values, scales)."""
        return _columns(saying, self.terms, self.inner)

    def nats(self, saying: Saying, unit: float) -> float:
        """Length of what is left and of its numbers, in nats; `unit` is a squared floor of what is noise to it."""
        return 0.5 * self.leaves / unit + 0.5 * self.numbers * float(np.log(np.sum(saying.rows)))


def _columns(saying: Saying, terms: tuple[FormTerm, ...], inner: tuple[Floats, ...]) -> Floats:
    by_direction = saying.shape.by_direction
    return np.hstack([t.columns(saying.points, at, by_direction) for t, at in zip(terms, inner, strict=True)])


def scanned(saying: Saying, term: FormTerm, others: Written | None, beside: tuple[FormTerm, ...]) -> Written:
    """A term where it takes most at coarse places, beside terms that keep theirs."""
    reduced = saying.reduced(_ALL)
    terms = (*(others.terms if others else ()), *beside)
    inner = (*(others.inner if others else ()), *(np.zeros(0) for _ in beside))
    fixed = _columns(saying, terms, inner) if terms else np.zeros((len(reduced.side), 0))
    best, at = -np.inf, np.zeros(0)
    for values in itertools.product(*(_coarse(saying, number, term.odd) for number in term.form.inner)):
        here = np.array(values)
        columns = term.columns(saying.points, here, saying.shape.by_direction)
        if np.any(np.ptp(columns, axis=0) <= 0.0):
            continue
        found = takes(reduced, np.hstack([columns, fixed]))
        if found > best:
            best, at = found, here
    return Written((term, *terms), (at, *inner), best)


def _coarse(saying: Saying, number: FormNumber, odd: bool) -> tuple[float, ...]:
    low, high = _range(saying, number, odd)
    span = high - low
    # of two variables every other start will do
    every = len(saying.points)
    if number.role is NumberRole.PLACE:
        return tuple(np.quantile(np.abs(saying.places) if odd else saying.places, _PLACES))
    if number.role is NumberRole.WIDTH:
        return tuple(span * share for share in _WIDTHS[::every])
    return tuple(2.0 * np.pi * turns / span for turns in _WAVES)


def _range(saying: Saying, number: FormNumber, odd: bool = False) -> tuple[float, float]:
    values = saying.points[number.of]
    return (0.0, float(np.max(np.abs(values)))) if odd else (float(np.min(values)), float(np.max(values)))


def polished(saying: Saying, one: Written, times: Floats = _ALL, again: bool = False) -> Written:
    """Its inner numbers moved to where it takes most of the folds that count."""
    from scipy.optimize import minimize

    reduced = saying.reduced(times)
    moved = [number for term in one.terms for number in term.form.inner]
    if not moved:
        return replace(one, takes=takes(reduced, one.columns(saying)))
    ranges = [_range(saying, number) for number in moved]

    def unpacked(y: Floats) -> tuple[Floats, ...]:
        values = [
            low + (high - low) * v if number.role is NumberRole.PLACE else float(np.exp(v))
            for number, (low, high), v in zip(moved, ranges, y, strict=True)
        ]
        cuts = np.cumsum([len(term.form.inner) for term in one.terms])[:-1]
        return tuple(np.split(np.array(values), cuts))

    def cost(y: Floats) -> float:
        for number, (low, high), v in zip(moved, ranges, y, strict=True):
            if number.role is NumberRole.PLACE and not -0.3 <= v <= 1.3:
                return np.inf
            if number.role is NumberRole.WIDTH and not _NARROWEST * (high - low) <= np.exp(v) <= _WIDEST * (high - low):
                return np.inf
        return -takes(reduced, _columns(saying, one.terms, unpacked(y)))

    y0 = np.array(
        [
            (v - low) / (high - low) if number.role is NumberRole.PLACE else np.log(max(v, _NARROWEST * (high - low)))
            for number, (low, high), v in zip(moved, ranges, np.concatenate(one.inner), strict=True)
        ]
    )
    simplex = np.vstack(
        [y0, *(y0 + _SIZE[number.role] * unit for number, unit in zip(moved, np.eye(len(y0)), strict=True))]
    )
    options = {
        "initial_simplex": simplex,
        "maxfev": (_AGAIN if again else _STEPS) * len(y0),
        "xatol": 1e-5,
        "fatol": 1e-7 * max(one.takes, 1e-9),
    }
    found = minimize(cost, y0, method="Nelder-Mead", options=options)
    return replace(one, inner=unpacked(found.x), takes=-float(found.fun))


def foretold(saying: Saying, one: Written) -> Written:
    """With what it leaves of stretches that did not give its numbers."""
    total = 0.0
    for k in range(FOLDS):
        others = saying.without(k)
        there = polished(saying, one, others, again=True)
        columns = there.columns(saying)
        total += saying.left(columns, saying.solved(columns, others), 1.0 - others)
    return replace(one, leaves=total)


def scales_of(saying: Saying, one: Written, times: Floats = _ALL) -> Solved:
    """Its scales, and how far the known numbers move beside it."""
    return saying.solved(one.columns(saying), times)


__all__ = ["Written", "foretold", "polished", "scales_of", "scanned"]
