"""A hypothesis at its best coordinates: bounded least squares on the evidence, known numbers inside their stated
uncertainty.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimbal_hil.discrepancy.evidence import command_residual
from gimbal_hil.discrepancy.hypothesis import Hypothesis
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.twin import Twin
from gimbal_hil.estimation import bounded_fit

_STEP = 0.02
#: a coordinate of a cause is held this loosely, so that one without effect on these data stays near its start
_LOOSE = 1e3
#: residual, in floors, of a hypothesis that the twin cannot carry
_BROKEN = 1e6


@dataclass(frozen=True)
class Weighing:
    """What a row counts for: noise of every channel (in floors, at least one) and rows per independent one, as a root."""

    scale: tuple[float, ...]
    spread: float


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
    """One over the standard uncertainty of every coordinate: next to nothing for causes, what the model states for
    known numbers.
    """
    causes = sum(len(cause.x) for cause in hypothesis.causes)
    return np.array([1.0 / _LOOSE] * causes + [1.0 / known.trust for known in hypothesis.floating])


def fit(
    twin: Twin,
    hypothesis: Hypothesis,
    floor: Floats,
    weighing: Weighing,
    rounds: int = 6,
    known: Floats | None = None,
    leash: float = 1.0,
    enough: float = 1e-4,
) -> Fit:
    """Fit a hypothesis to a twin's logs from where it stands.

    Known numbers stay within `leash` times their uncertainty. `known` are the columns of their Jacobian where they have
    been computed before: they hardly change.
    """
    weights = prior_weights(hypothesis)
    channels = len(twin.channels)
    per_row = np.tile(1.0 / (np.array(weighing.scale) * weighing.spread), 1)
    low, high = bounds_of(hypothesis, leash)
    start = hypothesis.vector()

    def residual_at(x: Floats) -> Floats:
        rows = command_residual(twin, hypothesis.at(x), floor)
        return np.concatenate([(rows * per_row).ravel(), _pull(hypothesis, x, start) * weights])

    def jacobian_at(x: Floats, residual: Floats) -> Floats:
        rows = residual[: len(residual) - len(x)]
        own = []
        for i in range(len(x) if known is None else len(x) - known.shape[1]):
            step = _STEP if x[i] + _STEP <= high[i] or i >= len(x) - len(hypothesis.y) else -_STEP
            moved = x.copy()
            moved[i] += step
            column = ((command_residual(twin, hypothesis.at(moved), floor) * per_row).ravel() - rows) / step
            # a coordinate that breaks the twin at its next step stays where it is
            own.append(column if np.all(np.isfinite(column)) else np.zeros(len(rows)))
        columns = np.column_stack(own) if own else np.zeros((len(rows), 0))
        if known is not None:
            columns = np.hstack([columns, known * np.tile(per_row, len(rows) // channels)[:, None]])
        return np.vstack([columns, np.diag(weights)])

    found = bounded_fit(residual_at, jacobian_at, start, low, high, rounds, enough)
    here = hypothesis.at(found.x)
    n = len(found.residual) - len(start)
    unweighed = np.tile(1.0 / per_row, n // channels)
    residual = (found.residual[:n] * unweighed).reshape(-1, channels)
    if not np.all(np.isfinite(residual)):
        broken = np.full_like(residual, _BROKEN)
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
    """Low and high of every coordinate: the catalogue's for causes, the stated uncertainty for known numbers."""
    knobs = [knob for cause in hypothesis.causes for knob in cause.family.knobs]
    reach = [leash * known.trust for known in hypothesis.floating]
    low = np.array([knob.low for knob in knobs] + [-r for r in reach])
    return low, np.array([knob.high for knob in knobs] + reach)


def _pull(hypothesis: Hypothesis, x: Floats, start: Floats) -> Floats:
    """How far each coordinate is from where its prior holds it: causes from their start, known numbers from the model."""
    causes = len(x) - len(hypothesis.y)
    return np.concatenate([x[:causes] - start[:causes], x[causes:]])
