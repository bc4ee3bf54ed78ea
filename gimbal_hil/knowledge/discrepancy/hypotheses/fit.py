"""Fits a hypothesis: bounded least squares on the evidence, known numbers held inside their stated uncertainty."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gimbal_hil.knowledge.discrepancy.hypotheses.evidence import Shares, with_shares
from gimbal_hil.knowledge.discrepancy.hypotheses.hypothesis import Hypothesis, is_held
from gimbal_hil.knowledge.discrepancy.hypotheses.origin import aligned
from gimbal_hil.knowledge.discrepancy.twin import Floats, Twin
from gimbal_hil.knowledge.estimation import bounded_fit

#: step of a coordinate for its slope
STEP = 0.02
#: a coordinate of a cause is held this loosely, so that one without effect on these data stays where it does nothing
_LOOSE = 1e2
#: how far a number may go on a leash (log), unless it is known even less
_FARTHEST = 0.9
#: shares of the way from neutral at which a start that is too far is tried
_NEARER = (1.0, 0.5, 0.2, 0.05)
#: residual, in floors, of a hypothesis that the twin cannot carry
BROKEN = 1e6


@dataclass(frozen=True)
class Weighing:
    """What a row counts for: noise of every channel (in floors, at least one) and rows per independent one, as a
    root.
    """

    scale: tuple[float, ...]
    spread: float


@dataclass(frozen=True)
class FitRule:
    """How far a fit goes: rounds at most, until a round takes less than the share `enough` of the cost. Known numbers
    stay within `leash` times their uncertainty. A newest cause that stands where the cost is above `ceiling`, that of
    the state it was added to, is led back towards neutral first.
    """

    rounds: int = 6
    leash: float = 1.0
    enough: float = 1e-4
    ceiling: float | None = None


_USUAL = FitRule()


@dataclass(frozen=True)
class Fit:
    """A hypothesis at its best coordinates: residual (rows, channels) in floors, its Jacobian (rows * channels,
    coordinates).
    """

    hypothesis: Hypothesis
    residual: Floats
    jacobian: Floats
    #: what was minimised: weighed squares and how far known numbers lie from what the model states
    cost: float

    @property
    def squares(self) -> Floats:
        """Mean square per channel, in squared floors."""
        return np.asarray(np.mean(self.residual**2, axis=0))


def prior_weights(hypothesis: Hypothesis) -> Floats:
    """One over the uncertainty of every coordinate: next to nothing for causes, what the model states for
    known numbers.
    """
    free = sum(len(cause.x) for cause in hypothesis.causes) + len(hypothesis.origins)
    return np.array([1.0 / _LOOSE] * free + [1.0 / known.trust for known in hypothesis.floating])


def fit(
    twin: Twin,
    hypothesis: Hypothesis,
    floor: Floats,
    weighing: Weighing,
    rule: FitRule = _USUAL,
    known: Floats | None = None,
    earlier: Floats | None = None,
) -> Fit:
    """Fit a hypothesis to a twin's logs from where it stands.

    `known` are the columns of the known numbers' Jacobian, and `earlier` those of the first causes, where they have
    been computed before: they hardly change.
    """
    hypothesis = aligned(twin, hypothesis, floor, weighing.scale)
    weights = prior_weights(hypothesis)
    channels = len(twin.channels)
    per_row = 1.0 / (np.array(weighing.scale) * weighing.spread)
    low, high = bounds_of(hypothesis, rule.leash)
    start = hypothesis.vector()
    held_at = _held_at(hypothesis, start)
    shaping = _shaping(hypothesis)
    given = [
        None if part is None else part * np.tile(per_row, len(part) // channels)[:, None] for part in (earlier, known)
    ]
    first, last = (0 if part is None else part.shape[1] for part in given)
    #: weighed rows and shares of the command at the last point that was looked at
    seen: dict[bytes, tuple[Floats, Shares | None]] = {}

    def seen_at(x: Floats) -> tuple[Floats, Shares | None]:
        if x.tobytes() not in seen:
            seen.clear()
            rows, shares = with_shares(twin, hypothesis.at(x), floor)
            seen[x.tobytes()] = (rows * per_row).ravel(), shares
        return seen[x.tobytes()]

    def residual_at(x: Floats) -> Floats:
        return np.concatenate([seen_at(x)[0], (x - held_at) * weights])

    def jacobian_at(x: Floats, residual: Floats) -> Floats:
        (rows, here), own = seen_at(x), []
        for i in range(first, len(x) - last):
            step, moved = _one_step(twin, hypothesis, x, i, low[i], high[i])
            changed, _ = with_shares(twin, hypothesis.at(moved), floor, None if shaping[i] else here)
            column = ((changed * per_row).ravel() - rows) / step
            # a coordinate that breaks the twin at its next step stays where it is
            own.append(column if np.all(np.isfinite(column)) else np.zeros(len(rows)))
        before, after = (np.zeros((len(rows), 0)) if part is None else part for part in given)
        return np.vstack([np.column_stack([before, *own, after]), np.diag(weights)])

    if rule.ceiling is not None:
        start = _led_back(hypothesis, start, rule.ceiling, lambda x: float(np.sum(residual_at(x) ** 2)))
    found = bounded_fit(residual_at, jacobian_at, start, low, high, rule.rounds, rule.enough)
    here = hypothesis.at(found.x)
    n = len(found.residual) - len(start)
    unweighed = np.tile(1.0 / per_row, n // channels)
    residual = (found.residual[:n] * unweighed).reshape(-1, channels)
    if not np.all(np.isfinite(residual)):
        broken = np.full_like(residual, BROKEN)
        return Fit(here, broken, np.zeros((n, len(start))), float(np.sum((broken * per_row) ** 2)))
    return Fit(here, residual, found.jacobian[:n] * unweighed[:, None], found.cost)


def weighed_cost(found: Fit, weighing: Weighing) -> float:
    """What a fit would cost with other weights."""
    rows = found.residual / (np.array(weighing.scale) * weighing.spread)
    y = (
        np.array(found.hypothesis.y)
        * prior_weights(found.hypothesis)[len(found.hypothesis.vector()) - len(found.hypothesis.y) :]
    )
    return float(np.sum(rows**2) + y @ y)


def bounds_of(hypothesis: Hypothesis, leash: float) -> tuple[Floats, Floats]:
    """Low and high of every coordinate: the catalogue's for causes, the stated uncertainty (times a leash) for known
    numbers.
    """
    knobs = [knob for cause in hypothesis.causes for knob in cause.family.knobs]
    reach = [max(known.reach, min(leash * known.trust, _FARTHEST)) for known in hypothesis.floating]
    zeros = [np.inf] * len(hypothesis.origins)
    low = np.array([knob.low for knob in knobs] + [-z for z in zeros] + [-r for r in reach])
    return low, np.array([knob.high for knob in knobs] + zeros + reach)


def _one_step(twin: Twin, hypothesis: Hypothesis, x: Floats, i: int, low: float, high: float) -> tuple[float, Floats]:
    """A step along one coordinate, for a derivative, and where it leads: to the side where nothing is held, if any.
    A body at the edge of those that exist is led back with all its moments, which says nothing of one of them.
    """
    known = i >= len(x) - len(hypothesis.y)
    ways = []
    for step in (STEP, -STEP):
        moved = x.copy()
        moved[i] += step
        ways.append((step, moved))
    # known numbers go a step beyond what is said of them
    inside = [(step, moved) for step, moved in ways if known or low <= moved[i] <= high] or ways[1:]
    return next((way for way in inside if not is_held(twin, hypothesis.at(way[1]))), inside[0])


def _led_back(hypothesis: Hypothesis, start: Floats, ceiling: float, cost: Callable[[Floats], float]) -> Floats:
    """A start whose newest cause stands nearer to neutral, until it costs no more than the ceiling."""
    last = sum(len(cause.x) for cause in hypothesis.causes)
    first = last - len(hypothesis.causes[-1].x)
    neutral = np.zeros(last - first) if hypothesis.causes[-1].family.ripple is None else start[first:last].copy()
    neutral[0] = 0.0
    for nearer in _NEARER:
        x = start.copy()
        x[first:last] = neutral + nearer * (start[first:last] - neutral)
        if cost(x) <= ceiling:
            return x
    return start


def _shaping(hypothesis: Hypothesis) -> list[bool]:
    """Of every coordinate whether it belongs to a cause that cuts the command."""
    found = [cause.family.cuts_command for cause in hypothesis.causes for _ in cause.x]
    return found + [False] * (len(hypothesis.vector()) - len(found))


def _held_at(hypothesis: Hypothesis, start: Floats) -> Floats:
    """Where its prior holds each coordinate: a ripple, whose angle is any, and zeros of logs at their start, all else
    where it does nothing. Held at its start, what these data do not see would stay wherever a fit once left it.
    """
    anywhere = [cause.family.ripple is not None for cause in hypothesis.causes for _ in cause.x]
    anywhere += [True] * len(hypothesis.origins) + [False] * len(hypothesis.y)
    return np.where(anywhere, start, 0.0)
