"""What a search works on, and how well a hypothesis fits it: frozen values that each step takes and returns."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.hypotheses import (
    BROKEN,
    Family,
    Fit,
    FitRule,
    Hypothesis,
    Weighing,
    aligned,
    command_residual,
    fit,
    noise_of_motion,
)
from gimbal_hil.knowledge.discrepancy.inquiry.policy import Policy
from gimbal_hil.knowledge.discrepancy.twin import Floats, Twin
from gimbal_hil.knowledge.estimation import Paired, decorrelation_rows, paired
from gimbal_hil.knowledge.executor import WorkExecutor, open_executor
from sim_backend.effects import CATALOGUE, Variable

#: the data by what it is for, as fields of a state
PARTS = ("fitted", "selecting", "untouched")


@dataclass(frozen=True)
class Inquiry:
    """Logs that are fitted, logs that judge, their floors, what may be added, and who does the work."""

    #: the fitted logs; those of the hold-out; and the fitted logs with the rows of the hold-out that may select
    twin: Twin
    holdout: Twin
    selectable: Twin
    #: rows of the hold-out that may select; the others only judge
    selecting: NDArray[np.bool_]
    #: noise of every channel in its unit
    floor: Floats
    families: tuple[Family, ...]
    policy: Policy = field(default_factory=Policy)
    executor: WorkExecutor = field(default_factory=open_executor)
    tell: Callable[[str], None] = lambda text: None
    #: the fitted logs as they were read; and where those come from that are too short for the band
    logs: tuple[SignalsTable, ...] = ()
    left_out: tuple[str, ...] = ()
    #: Jacobian of the known numbers beside the model as it stands, (rows * channels, numbers), in floors
    known: Floats | None = None
    #: what the pipeline leaves of data that the model itself could have made, over the floors, per channel
    inexact: Floats | float = 0.0
    #: share of every floor's squares that is the encoder's error
    from_encoder: Floats | float = 0.0
    #: what stands for the fitted logs and for that Jacobian where the work is done
    twin_there: Twin | None = None
    known_there: Floats | None = None

    @property
    def row_counts(self) -> tuple[int, ...]:
        """Scored rows of every fitted log."""
        return tuple(int(record.keep.sum()) for record in self.twin.records)

    @property
    def held_counts(self) -> tuple[int, ...]:
        """Scored rows of every log of the hold-out."""
        return tuple(int(record.keep.sum()) for record in self.holdout.records)

    def in_order(self, state: State) -> Floats:
        """What a state leaves of the hold-out, rows in the order of its logs, (rows, channels)."""
        rows = np.empty((len(self.selecting), state.selecting.shape[1]))
        rows[self.selecting], rows[~self.selecting] = state.selecting, state.untouched
        return rows

    def split(self, fitted: Floats) -> list[Floats]:
        """Rows of the fitted logs, log by log."""
        return np.split(fitted, np.cumsum(self.row_counts)[:-1])

    def split_held(self, rows: Floats, selecting: bool) -> list[Floats]:
        """Rows of one half of the hold-out, log by log."""
        mask = self.selecting if selecting else ~self.selecting
        counts = [int(part.sum()) for part in np.split(mask, np.cumsum(self.held_counts)[:-1])]
        return [part for part in np.split(rows, np.cumsum(counts)[:-1]) if len(part)]


@dataclass(frozen=True, eq=False)
class State:
    """A fitted hypothesis and what it leaves, in floors, of the fitted rows and of both halves of the hold-out."""

    fit: Fit
    selecting: Floats
    untouched: Floats
    #: the hypothesis as it is put on the hold-out: with the zeros of those logs
    held: Hypothesis

    @property
    def hypothesis(self) -> Hypothesis:
        """The hypothesis at its fitted coordinates."""
        return self.fit.hypothesis

    @property
    def fitted(self) -> Floats:
        """What is left of the fitted rows."""
        return self.fit.residual

    def held_out(self) -> Floats:
        """What is left of the whole hold-out, rows in the order in which the halves lie one after the other."""
        return np.concatenate([self.selecting, self.untouched])

    def left(self) -> Floats:
        """Rms per channel in floors, the larger of fitted data and both halves of the hold-out."""
        return np.max([rms(part) for part in (self.fitted, self.selecting, self.untouched)], axis=0)


def shared(inquiry: Inquiry) -> Inquiry:
    """The inquiry with its large values put where the work is done."""
    share = inquiry.executor.share
    return replace(
        inquiry, twin_there=share(inquiry.twin), known_there=None if inquiry.known is None else share(inquiry.known)
    )


def state_of(inquiry: Inquiry, found: Fit) -> State:
    """Put a fit on the hold-out."""
    scale = tuple(float(x) for x in np.sqrt(np.maximum(found.squares, 1.0)))
    held = aligned(inquiry.holdout, found.hypothesis, inquiry.floor, scale, inquiry.selecting)
    rows = command_residual(inquiry.holdout, held, inquiry.floor)
    rows = np.nan_to_num(rows, nan=BROKEN, posinf=BROKEN, neginf=-BROKEN)
    return State(found, rows[inquiry.selecting], rows[~inquiry.selecting], held)


def stands_out(inquiry: Inquiry, state: State, best: State | None = None) -> bool:
    """Whether what a state leaves stands above the noise and what the pipeline leaves of the model itself, which is no
    more than the best explanation leaves.

    To a best explanation that adds a filter, something with a memory between command and joint, noise is what the
    state's inertia makes of the encoder's error: a filter smooths it.
    """
    if best is None:
        return _above(inquiry, state, inquiry.inexact, 1.0)
    new = set(best.hypothesis.labels) - set(state.hypothesis.labels)
    added = [CATALOGUE[effect] for effect, _ in new]
    smooths = any(one.is_before_the_joint and Variable.PAST in one.acts_through for one in added)
    noise = noise_of_motion(inquiry.twin, state.hypothesis, inquiry.from_encoder) if smooths else 1.0
    return _above(inquiry, state, np.minimum(inquiry.inexact, best.left()), noise)


def _above(inquiry: Inquiry, state: State, inexact: Floats | float, noise: Floats | float) -> bool:
    return bool(np.any(state.left() > inquiry.policy.least_gap * np.hypot(noise, inexact)))


def weighing_of(inquiry: Inquiry, state: State) -> Weighing:
    """What rows count for beside a state: what it leaves is noise to whatever else is fitted, correlated as it is."""
    squares = state.fit.squares
    times = [decorrelation_rows(part[:, j]) for part in inquiry.split(state.fitted) for j in range(part.shape[1])]
    return Weighing(tuple(float(x) for x in np.sqrt(np.maximum(squares, 1.0))), float(np.sqrt(np.median(times))))


def refitted(inquiry: Inquiry, state: State, hypothesis: Hypothesis, rounds: int = 6, leash: float = 1.0) -> State:
    """Another hypothesis, fitted from where it stands with the weights of a state."""
    known = inquiry.known if hypothesis.floating else None
    weighing = weighing_of(inquiry, state)
    return state_of(inquiry, fit(inquiry.twin, hypothesis, inquiry.floor, weighing, FitRule(rounds, leash), known))


def settled(inquiry: Inquiry, state: State) -> State:
    """The same causes fitted to the fitted logs and the selecting rows together: what one log hardly says another may
    say clearly.
    """
    weighing = weighing_of(inquiry, state)
    found = fit(inquiry.selectable, state.hypothesis, inquiry.floor, weighing, FitRule(10, enough=1e-6))
    rows = sum(inquiry.row_counts)
    channels = found.residual.shape[1]
    return state_of(
        inquiry, Fit(found.hypothesis, found.residual[:rows], found.jacobian[: rows * channels], found.cost)
    )


def gain_on(inquiry: Inquiry, before: State, after: State, where: str, unit: Floats | None = None) -> Paired:
    """Mean squares a row that `after` takes from `before`, channels each in units of what `before` leaves of the fitted
    rows, or in units of these squares.

    `where` is "fitted", "selecting" or "untouched".
    """
    scale = np.sqrt(np.maximum(before.fit.squares if unit is None else unit, 1.0))
    parts = []
    for state in (before, after):
        rows = getattr(state, where) / scale
        parts.append(inquiry.split(rows) if where == "fitted" else inquiry.split_held(rows, where == "selecting"))
    return paired(*parts)


def surely_less(inquiry: Inquiry, before: State, after: State, unit: Floats | None = None) -> float:
    """How surely a state leaves less, over fitted rows and both halves of the hold-out (Stouffer's sum of normal
    deviates).
    """
    return float(sum(gain_on(inquiry, before, after, part, unit).sure for part in PARTS) / math.sqrt(len(PARTS)))


def squares_of(state: State) -> Floats:
    """Mean square per channel of all data, in squared floors."""
    return mean_squares(np.concatenate([state.fitted, state.held_out()]))


def mean_squares(rows: Floats) -> Floats:
    """Mean square per channel of (rows, channels)."""
    return np.asarray(np.mean(rows**2, axis=0))


def rms(rows: Floats) -> Floats:
    """Root mean square per channel of (rows, channels)."""
    return np.asarray(np.sqrt(mean_squares(rows)))


def selectable(twin: Twin, holdout: Twin, selecting: NDArray[np.bool_]) -> Twin:
    """The fitted logs and the rows of the hold-out that may select, as one."""
    records, scales, first = list(twin.records), list(twin.scales or ()), 0
    for which, record in enumerate(holdout.records):
        keep = record.keep.copy()
        mine = selecting[first : first + int(keep.sum())]
        first += len(mine)
        keep[keep] = mine
        records.append(replace(record, keep=keep))
        if holdout.scales is not None:
            scales.append(holdout.scales[which][mine])
    return replace(twin, records=tuple(records), scales=tuple(scales) if scales else None)
