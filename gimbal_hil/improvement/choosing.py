"""Which experiment comes next: the entry of the menu on which two explanations would differ most.

Explanation A is put in the model and rehearsed through an entry; what is measured there is put beside explanation B, which may
refit itself within what the data so far allows it (its Jacobian there). What B still leaves beyond A is the expected difference.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.discrepancy import Diagnosis, corrected_model
from gimbal_hil.discrepancy.fit import prior_weights, residual_of
from gimbal_hil.discrepancy.hypothesis import Hypothesis
from gimbal_hil.discrepancy.record import record_of
from gimbal_hil.discrepancy.search import Scored
from gimbal_hil.discrepancy.separating import CHANCE, all_sequences, separating_runs, showing_sequences
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.twin import Twin
from gimbal_hil.signals import SignalsTable
from sim_backend.model import AntennaModel

#: an entry is worth its time when B would leave so many squared floors beyond A over all its rows, after correlation
WORTH = 12.0
#: rows of the scored residual are correlated: what one row counts for
_SPREAD = 2.0


@dataclass(frozen=True)
class Option:
    """An entry of the menu for an axis, and the expected difference in squared floors; None where it could not be worked out."""

    sequence: str
    axis: str
    expected: float | None


@dataclass(frozen=True)
class Pair:
    """Two explanations that the data leaves open: hypotheses with their fits, by the name and axis in which they differ."""

    best: Scored
    rival: Scored
    names: tuple[tuple[str, str], tuple[str, str]]

    @property
    def against_chance(self) -> bool:
        """Whether it is a cause that the searched runs alone have shown, beside the same without it."""
        return self.names[1][0] == CHANCE


def open_pair(diagnosis: Diagnosis, separates: Sequence[str]) -> Pair | None:
    """The pair of an ambiguous verdict: the cause and the rival that its `next_experiment` separates."""
    best, search = diagnosis.best, diagnosis.search
    for index, label in enumerate(best.hypothesis.labels):
        if list(separates) == [label[0], CHANCE] and not search.heard_on_holdout(best, index):
            return Pair(best, search.refitted(best.hypothesis.minus(index)), (label, (CHANCE, label[1])))
        if separates and label[0] == separates[0] and index < len(diagnosis.rivals):
            for rival in diagnosis.rivals[index]:
                other = rival.hypothesis.labels[-1]
                if other[0] == separates[-1] and other != label:
                    return Pair(best, rival, (label, other))
    return None


def unexplained_pair(diagnosis: Diagnosis) -> Pair | None:
    """Of an unexplained gap: the two attempts that come closest and differ in a cause."""
    search = diagnosis.search
    tried = [one for made in diagnosis.rounds for one in made.tried]
    # floors fall while a search goes on: attempts of different rounds are put beside one another under those that hold in the end
    again = [search.scored(replace(one.fit, residual=residual_of(search.twin, one.hypothesis, search.floor))) for one in tried]
    attempts = sorted((one for one in again if np.isfinite(one.cost)), key=lambda one: one.cost)
    for rival in attempts[1:]:
        here, there = set(attempts[0].hypothesis.labels), set(rival.hypothesis.labels)
        if here != there and here - there and there - here:
            return Pair(attempts[0], rival, (sorted(here - there)[0], sorted(there - here)[0]))
    return None


def menu_of(pair: Pair, done: Sequence[tuple[str, str]]) -> list[Option]:
    """Entries made for the pair, those that fit both first, then those that show one of them. What was run already is left out.

    Against chance, whatever shows the cause will do: where it has no entry of its own, all of them.
    """
    (one, axis), (other, other_axis) = pair.names
    both = [run.sequence for run in separating_runs(one, other) if run.sequence is not None]
    names = tuple(dict.fromkeys([*both, *showing_sequences(one, other)]))
    if pair.against_chance:
        names = names or all_sequences()
    axes = [axis] if axis == other_axis else [axis, other_axis]
    return [Option(name, where, None) for name in names for where in axes if (name, where) not in done]


def person_needed(pair: Pair) -> str | None:
    """What a person would have to do to tell a pair apart where the antenna cannot by itself."""
    runs = separating_runs(*(name for name, _ in pair.names))
    return next((run.text for run in runs if run.sequence is None), None)


def weighed(
    diagnosis: Diagnosis, pair: Pair, options: Sequence[Option], rehearsed: Callable[[Option, AntennaModel], SignalsTable | None]
) -> list[Option]:
    """The options with their expected differences, largest first. `rehearsed` gives what an option would measure on a model."""
    model = corrected_model(replace(diagnosis, best=pair.best, complete=True)) or diagnosis.model
    found = []
    for option in options:
        table = rehearsed(option, model)
        found.append(option if table is None else replace(option, expected=expected_difference(diagnosis, pair, table)))
    return sorted(found, key=lambda o: -1.0 if o.expected is None else -o.expected)


def expected_difference(diagnosis: Diagnosis, pair: Pair, table: SignalsTable) -> float:
    """Squared floors that B leaves beyond A on a table that A made, B refitted linearly to that table and to all data so far."""
    search = diagnosis.search
    hz = search.twin.records[0].bands.scored_hz
    twin = Twin(diagnosis.model, (record_of(table, diagnosis.model, hz, "rehearsal"),), search.twin.gyro_everywhere)
    as_a = residual_of(twin, pair.best.hypothesis, search.floor)
    as_b = residual_of(twin, pair.rival.hypothesis, search.floor)
    if not np.all(np.isfinite(as_b)):
        return 0.0
    columns = _jacobian(twin, pair.rival.hypothesis, search.floor, as_b)
    held = pair.rival.fit.jacobian
    weights = prior_weights(pair.rival.hypothesis) * _SPREAD
    normal = columns.T @ columns + np.diag(weights**2)
    if held.shape[1] == columns.shape[1]:
        normal = normal + held.T @ held
    slope = columns.T @ as_b.ravel()
    left = float(np.sum(as_b**2)) - float(slope @ np.linalg.lstsq(normal, slope, rcond=1e-10)[0])
    return max(0.0, (left - float(np.sum(as_a**2))) / _SPREAD)


def _jacobian(twin: Twin, hypothesis: Hypothesis, floor: Floats, residual: Floats) -> Floats:
    x = hypothesis.vector()
    columns = np.zeros((residual.size, len(x)))
    for i in range(len(x)):
        moved = x.copy()
        moved[i] += 0.02
        trial = hypothesis.at(moved)
        change = float(trial.vector()[i] - x[i])
        if change != 0.0:
            columns[:, i] = ((residual_of(twin, trial, floor) - residual) / change).ravel()
    return columns
