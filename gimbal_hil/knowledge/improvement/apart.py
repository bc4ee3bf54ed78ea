"""How far an explanation stays from another on rows that were rehearsed, once it has done about it what it can."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import (
    Floats,
    Hypothesis,
    KnownNumber,
    Twin,
    bounds_of,
    command_residual,
    known_numbers,
    prior_weights,
    record_of,
)
from sim_backend.model import AntennaModel

#: rows of the scored residual are correlated: what one row counts for
SPREAD = 2.0


@dataclass(frozen=True)
class Apart:
    """How far a rival stays from the best explanation on a table: squares of the difference, what its coordinates do
    about it there, what all data so far hold them with, and how far they may still go either way.
    """

    squares: float
    slope: Floats
    normal: Floats
    held: Floats
    low: Floats
    high: Floats

    def beyond(self, times: int) -> float:
        """Squared floors that it leaves beyond the best on so many such tables, refitted linearly within its bounds."""
        slope, normal = times * self.slope, times * self.normal + self.held
        moved = -np.linalg.lstsq(normal, slope, rcond=1e-10)[0]
        if np.any((moved < self.low) | (moved > self.high)):
            moved = _bounded(normal, slope, self.low, self.high)
        back = -float(2.0 * slope @ moved + moved @ normal @ moved)
        return max(0.0, (times * self.squares - back) / SPREAD)


def _bounded(normal: Floats, slope: Floats, low: Floats, high: Floats) -> Floats:
    """Where x normal x / 2 + slope x is least between bounds."""
    from scipy.optimize import lsq_linear

    # each coordinate in its own unit: known numbers move by thousandths of what an effect moves by
    unit = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    roots, ways = np.linalg.eigh(normal * unit[:, None] * unit)
    there = roots > 1e-10 * roots[-1]
    sides = np.sqrt(roots[there])[:, None] * ways[:, there].T
    aim = -(ways[:, there].T @ (slope * unit)) / np.sqrt(roots[there])
    return np.asarray(unit * lsq_linear(sides, aim, (low / unit, high / unit), method="bvls").x)


def rehearsal_of(twin: Twin, table: SignalsTable) -> Twin:
    """What was rehearsed as a twin like that of the logs."""
    record = record_of(table, twin.model, twin.records[0].bands.scored_hz, "rehearsal")
    return Twin(twin.model, (record,), twin.gyro_everywhere)


@dataclass(frozen=True)
class Coordinates:
    """What the coordinates of a hypothesis do on a twin, (rows * channels, coordinates), and what all data so far hold
    them with.
    """

    columns: Floats
    held: Floats
    #: how far they may go from where they stand
    low: Floats
    high: Floats

    @classmethod
    def of(
        cls,
        twin: Twin,
        hypothesis: Hypothesis,
        before: Floats,
        floor: Floats,
        residual: Floats,
        inert: tuple[KnownNumber, ...] = (),
    ) -> Coordinates:
        """Those of a hypothesis with this residual there; `before` is its Jacobian on all data so far, to which `inert`
        numbers did nothing.
        """
        hypothesis = _with_inert(hypothesis, inert)
        columns = _jacobian(twin, hypothesis, floor, residual)
        held = np.diag((prior_weights(hypothesis) * SPREAD) ** 2)
        so_far = before.shape[1]
        held[:so_far, :so_far] += before.T @ before
        x, (low, high) = hypothesis.vector(), bounds_of(hypothesis, 1.0)
        return cls(columns, held, np.minimum(low - x, 0.0), np.maximum(high - x, 0.0))

    def beside(self, other: Coordinates) -> Coordinates:
        """These and another explanation's, which take away from the difference of the two alike."""
        zero = np.zeros((len(self.held), len(other.held)))
        return Coordinates(
            np.hstack([self.columns, -other.columns]),
            np.block([[self.held, zero], [zero.T, other.held]]),
            np.concatenate([self.low, other.low]),
            np.concatenate([self.high, other.high]),
        )

    def apart(self, rows: Floats) -> Apart:
        """How far an explanation with this difference, (rows, channels), stays; nowhere where it cannot be computed."""
        if not (np.all(np.isfinite(rows)) and np.all(np.isfinite(self.columns))):
            return Apart(0.0, np.zeros(len(self.held)), np.zeros_like(self.held), self.held, self.low, self.high)
        flat = rows.ravel()
        slope, normal = self.columns.T @ flat, self.columns.T @ self.columns
        return Apart(float(flat @ flat), slope, normal, self.held, self.low, self.high)


def inert_numbers(model: AntennaModel, null: Hypothesis) -> tuple[KnownNumber, ...]:
    """Known numbers that did nothing to the data so far, so that they do not float there."""
    there = {(known.axis, known.path) for known in null.floating}
    return tuple(known for known in known_numbers(model) if (known.axis, known.path) not in there)


def _with_inert(hypothesis: Hypothesis, inert: tuple[KnownNumber, ...]) -> Hypothesis:
    """The hypothesis with numbers that did nothing so far: on another motion they may make up for what it shows, as far
    as its others may.
    """
    room = min((known.room for known in hypothesis.floating), default=1.0)
    more = tuple(replace(known, room=max(known.room, room)) for known in inert)
    return replace(hypothesis, floating=hypothesis.floating + more, y=hypothesis.y + (0.0,) * len(more))


def _jacobian(twin: Twin, hypothesis: Hypothesis, floor: Floats, residual: Floats) -> Floats:
    x = hypothesis.vector()
    columns = np.zeros((residual.size, len(x)))
    for i in range(len(x)):
        moved = x.copy()
        moved[i] += 0.02
        trial = hypothesis.at(moved)
        change = float(trial.vector()[i] - x[i])
        if change != 0.0:
            columns[:, i] = ((command_residual(twin, trial, floor) - residual) / change).ravel()
    return columns


__all__ = ["SPREAD", "Apart", "Coordinates", "inert_numbers", "rehearsal_of"]
