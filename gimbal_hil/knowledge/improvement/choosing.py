"""Which experiment comes next: the entry of the menu on which two explanations would differ most.

Explanation A is put in the model and rehearsed through an entry; what is measured there is put beside explanation B,
which may refit itself within what the data so far allows it (its Jacobian there). What B still leaves beyond A is the
expected difference.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import (
    CHANCE,
    Floats,
    Hypothesis,
    Result,
    State,
    Status,
    Twin,
    all_sequences,
    command_residual,
    explained_by,
    prior_weights,
    record_of,
    refitted,
    separating_runs,
    showing_sequences,
)
from sim_backend.model import AntennaModel

#: an entry is worth its time when B would leave so many squared floors beyond A over all its rows, after correlation
WORTH = 12.0
#: and shows a cause plainly at so many times that: of those the shortest will do against chance
_PLAINLY = 10.0
#: rows of the scored residual are correlated: what one row counts for
_SPREAD = 2.0


@dataclass(frozen=True)
class Option:
    """An entry of the menu for an axis; once it is weighed, the expected difference in squared floors and how long it
    takes.
    """

    sequence: str
    axis: str
    expected: float = 0.0
    duration_s: float = 0.0


@dataclass(frozen=True)
class Pair:
    """Two explanations that the data leaves open: hypotheses with their fits, by the name and axis in which they
    differ.
    """

    best: State
    rival: State
    names: tuple[tuple[str, str], tuple[str, str]]

    @property
    def against_chance(self) -> bool:
        """Whether it is a cause that the searched runs alone have shown, beside the same without it."""
        return self.names[1][0] == CHANCE


def open_pairs(result: Result, shown: Collection[tuple[str, str]]) -> list[Pair]:
    """What an ambiguous verdict leaves open: a cause and the rival that does as well, or a cause and the same without
    it.

    The latter where the hold-out does not show the cause; not for those that an earlier hold-out has shown.
    """
    best, found = result.best, []
    for one in result.told:
        if one.status is Status.NAMED:
            continue
        label = one.standing.label
        if one.close and not one.standing.silent:
            found.append(Pair(best, one.close[0].state, (label, one.close[0].label)))
        elif label not in shown:
            rest = best.hypothesis
            for index in reversed(one.standing.entries):
                rest = rest.minus(index)
            found.append(Pair(best, refitted(result.inquiry, best, rest), (label, (CHANCE, label[1]))))
    return found


def unexplained_pair(result: Result) -> Pair | None:
    """Of an unexplained gap: the two attempts that come closest and differ in a cause."""
    tried = [one for made in result.path.rounds for one in made.tried]
    attempts = sorted(tried, key=lambda one: float(np.sum(one.fit.squares)))
    for rival in attempts[1:]:
        here, there = set(attempts[0].hypothesis.labels), set(rival.hypothesis.labels)
        if here != there and here - there and there - here:
            return Pair(attempts[0], rival, (sorted(here - there)[0], sorted(there - here)[0]))
    return None


def menu_of(pair: Pair, done: Sequence[tuple[str, str]]) -> list[Option]:
    """Entries made for the pair, those that fit both first, then those that show one of them. What was run already is
    left out.

    Against chance, whatever shows the cause will do: where no entry of its own is left, all of them.
    """
    (one, axis), (other, other_axis) = pair.names
    both = [run.sequence for run in separating_runs(one, other) if run.sequence is not None]
    axes = [axis] if axis == other_axis else [axis, other_axis]

    def left(names: Iterable[str]) -> list[Option]:
        return [Option(name, where) for name in dict.fromkeys(names) for where in axes if (name, where) not in done]

    own = left([*both, *showing_sequences(one, other)])
    return own or left(all_sequences()) if pair.against_chance else own


def person_needed(pair: Pair) -> str | None:
    """What a person would have to do to tell a pair apart where the antenna cannot by itself."""
    runs = separating_runs(*(name for name, _ in pair.names))
    return next((run.text for run in runs if run.sequence is None), None)


def weighed(
    result: Result,
    pair: Pair,
    options: Sequence[Option],
    rehearsed: Callable[[Option, AntennaModel], SignalsTable | None],
) -> list[Option]:
    """The options with their expected differences, largest first. `rehearsed` gives what an option would measure on a
    model.
    """
    model = explained_by(result.model, result.inquiry.twin, pair.best.hypothesis)
    found: list[Option] = []
    for option in options:
        table = rehearsed(option, model)
        if table is not None:
            expected = expected_difference(result, pair, table)
            found.append(replace(option, expected=expected, duration_s=len(table) * table.period_s))
    return sorted(found, key=lambda option: -option.expected)


def worth_running(pair: Pair, options: Sequence[Option]) -> Option | None:
    """The option to run: where the pair differs most, or the shortest that plainly shows a cause; None where none is
    worth its time.
    """
    worth = [option for option in options if option.expected >= WORTH]
    plain = [option for option in worth if option.expected >= _PLAINLY * WORTH]
    if pair.against_chance and plain:
        return min(plain, key=lambda option: option.duration_s)
    return worth[0] if worth else None


def open_end(pair: Pair, options: Sequence[Option], refused: Sequence[str], left_floors: float) -> str:
    """What stays open, why no run of the antenna's own would close it, what the model is then, and what a person could
    do.
    """
    (one, axis), (other, other_axis) = ((name.replace("_", " "), axis) for name, axis in pair.names)
    person = person_needed(pair)
    if options:
        most = options[0]
        place = f"{most.sequence.replace('_', ' ')} on {most.axis}"
        why = (
            f"of the runs left, {place} would tell them apart best, but only by {most.expected:.2g} squared noise "
            f"floors, where {WORTH:g} are needed"
        )
    elif refused:
        why = f"no run fits the budgets ({'; '.join(refused)})"
    else:
        why = "no run that the antenna can make by itself is left"
    if pair.against_chance:
        return (
            f"{one.capitalize()} on {axis} is suspected, not shown: the searched runs alone have it, and {why}."
            f" The model has it, since they need it: it leaves {left_floors:.2f} floors."
        )
    text = f"{one.capitalize()} on {axis} or {other} on {other_axis}: {why}."
    text += f" The model with {one} leaves {left_floors:.2f} floors, as it would with the other."
    return text + (f" A person could tell: {person}." if person else "")


def expected_difference(result: Result, pair: Pair, table: SignalsTable) -> float:
    """Squared floors that B leaves beyond A on a table that A made, B refitted linearly to that table and to all data
    so far.
    """
    search = result.inquiry
    hz = search.twin.records[0].bands.scored_hz
    twin = Twin(result.model, (record_of(table, result.model, hz, "rehearsal"),), search.twin.gyro_everywhere)
    as_a = command_residual(twin, pair.best.hypothesis, search.floor)
    as_b = command_residual(twin, pair.rival.hypothesis, search.floor)
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
            columns[:, i] = ((command_residual(twin, trial, floor) - residual) / change).ravel()
    return columns
