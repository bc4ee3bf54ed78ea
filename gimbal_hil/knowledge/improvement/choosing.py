"""Which experiment comes next: the entry of the menu on which two explanations would differ most.

Explanation A is put in the model and rehearsed through an entry; what is measured there is put beside explanation B,
which may refit itself within what the data so far allows it (its Jacobian there). What B still leaves beyond A is the
expected difference.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from firmware_protocol.json_object import Json
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import (
    CHANCE,
    Floats,
    Hypothesis,
    Kind,
    Policy,
    Result,
    State,
    Status,
    Twin,
    all_sequences,
    command_residual,
    explained_by,
    odds_against,
    refitted,
    separating_runs,
    showing_sequences,
)
from gimbal_hil.knowledge.improvement.apart import SPREAD, Apart, Coordinates, inert_numbers, rehearsal_of
from gimbal_hil.knowledge.improvement.budgets import AFTERWARDS_S
from gimbal_hil.knowledge.improvement.journal import Diagnosed
from gimbal_hil.knowledge.improvement.motion import MADE
from sim_backend.model import AntennaModel

#: an entry is worth its time when B would leave so many squared floors beyond A over all its rows, after correlation
WORTH = 12.0
#: and shows a cause plainly at so many times that: of those the shortest will do against chance
_PLAINLY = 10.0


@dataclass(frozen=True)
class Option:
    """An entry of the menu for an axis; once it is weighed, the expected difference in squared floors and how long it
    takes.
    """

    sequence: str
    axis: str
    expected: float = 0.0
    duration_s: float = 0.0

    @property
    def is_made(self) -> bool:
        """Whether it is a motion that was made for the pair, and no sequence."""
        return self.sequence == MADE

    @property
    def per_second(self) -> float:
        """Squared floors a second of antenna time, with the way back after it."""
        return self.expected / (self.duration_s + AFTERWARDS_S)

    def as_considered(self) -> Json:
        """For the journal."""
        weighed = {"expected": round(self.expected, 1), "seconds": round(self.duration_s, 1)}
        return {"sequence": self.sequence, "axis": self.axis, **weighed}


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


def pairs_left(result: Result, diagnoses: Sequence[Diagnosed]) -> list[Pair]:
    """What a verdict leaves open after those before it: of an ambiguous one the causes that no hold-out has shown; a
    gap that nothing explains gets one more kind of motion to show itself in, not the whole menu.
    """
    if result.decision.kind is Kind.AMBIGUOUS:
        named = [effect for one in diagnoses for effect in one.effects if effect["status"] == Status.NAMED.value]
        return open_pairs(result, {(effect["name"], effect["axis"]) for effect in named})
    nameless = (Kind.UNEXPLAINED.value, Kind.DESCRIBED.value)
    if any(one.verdict in nameless and one.choice is not None for one in diagnoses):
        return []
    pair = unexplained_pair(result)
    return [] if pair is None else [pair]


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
            found.append(Pair(best, _without(result, label), (label, (CHANCE, label[1]))))
    return found


def _without(result: Result, label: tuple[str, str]) -> State:
    """The best explanation without one of its causes, refitted."""
    rest = result.best.hypothesis
    for index in reversed([k for k, one in enumerate(rest.labels) if one == label]):
        rest = rest.minus(index)
    return refitted(result.inquiry, result.best, rest)


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
    question = question_of(result, pair)
    found: list[Option] = []
    for option in options:
        table = rehearsed(option, question.model)
        if table is not None:
            expected = separation_of(question, table).expected()
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


def reason(pair: Pair, best: Option) -> str:
    """Why this option is run."""
    (one, axis), (other, other_axis) = ((name.replace("_", " "), axis) for name, axis in pair.names)
    two = f"{one} on {axis} from {other} on {other_axis}"
    if best.is_made:
        return f"made to separate {two}: {best.expected:.3g} squared floors expected in {best.duration_s:.0f} s"
    if pair.against_chance:
        return f"a hold-out that shows {one} on {axis}, which only the searched runs have shown"
    return f"separates {two}: largest expected difference of the menu"


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


class Shown(Protocol):
    """What so many tables like one say of a question: squared floors expected, and those that answer it."""

    def expected(self, times: int = 1) -> float: ...
    def needed(self, times: int = 1) -> float: ...


class MotionQuestion(Protocol):
    """What a motion is made for: the model that it is rehearsed on, and what a table of that says."""

    @property
    def model(self) -> AntennaModel: ...
    def shown(self, table: SignalsTable) -> Shown: ...


@dataclass(frozen=True)
class OpenQuestion:
    """What is open: the states beside the best one with their weights (sum 1), the best without the cause that is
    asked about, which has to be shown too; the model with the best, and what a table of it is judged by: also how much
    data there are, and what is left of them without any cause.
    """

    best: State
    rivals: tuple[State, ...]
    weights: tuple[float, ...]
    bare: State | None
    model: AntennaModel
    twin: Twin
    floor: Floats
    null: Hypothesis
    policy: Policy
    #: rows of all data so far, and squares of each channel
    rows: int
    without: Floats

    def shown(self, table: SignalsTable) -> Separation:
        """What a table that the best explanation made says."""
        return separation_of(self, table)


def question_of(result: Result, pair: Pair) -> OpenQuestion:
    """What is open between the best explanation and a rival, and what else the verdict has in the place of the same
    cause, each with the odds that the verdict gives it. Of an unexplained gap nothing has to be shown but the
    difference.
    """
    inquiry = result.inquiry
    odds = {
        rival.state: odds_against(rival, inquiry.policy)
        for one in result.told
        if one.standing.label == pair.names[0] and not pair.against_chance
        for rival in one.close
    }
    if pair.rival not in odds:
        odds = {pair.rival: 1.0}
    weights = tuple(one / sum(odds.values()) for one in odds.values())
    model = explained_by(result.model, inquiry.twin, pair.best.hypothesis)
    data = np.concatenate([result.null.fitted, result.null.held_out()])
    asked = pair.best is result.best and not pair.against_chance
    return OpenQuestion(
        pair.best,
        tuple(odds),
        weights,
        _without(result, pair.names[0]) if asked else None,
        model,
        inquiry.twin,
        inquiry.floor,
        result.null.hypothesis,
        inquiry.policy,
        len(data),
        np.sum(data**2, axis=0),
    )


@dataclass(frozen=True)
class Separation:
    """What a table says of a question, and so many like it."""

    question: OpenQuestion
    rivals: tuple[Apart, ...]
    bare: Apart | None
    rows: int
    without: Floats

    def expected(self, times: int = 1) -> float:
        """Squared floors that other explanations leave beyond the best, all refitted linearly to the tables and to all
        data so far: the best too, whose numbers are not known any better. The mean by their weights, or what known
        numbers alone leave where that is less.
        """
        rivals = float(np.dot(self.question.weights, [one.beyond(times) for one in self.rivals]))
        return rivals if self.bare is None else min(rivals, self.bare.beyond(times))

    def needed(self, times: int = 1) -> float:
        """Squared floors that tell two explanations apart on the tables and all data so far: more than a twin is exact
        to (`same_to_a_twin`), in every row, as a verdict counts it.
        """
        policy, rows = self.question.policy, self.question.rows + times * self.rows
        share = policy.same**2 * float(np.max(self.question.without + times * self.without))
        return max(WORTH, policy.least_squares * rows / SPREAD, share / SPREAD)


def separation_of(question: OpenQuestion, table: SignalsTable) -> Separation:
    """What a table that the best explanation made says."""
    floor, there = question.floor, rehearsal_of(question.twin, table)
    as_best = command_residual(there, question.best.hypothesis, floor)
    without = command_residual(there, question.null, floor)
    inert = inert_numbers(there.model, question.null)

    def coordinates(state: State, residual: Floats) -> Coordinates:
        return Coordinates.of(there, state.hypothesis, state.fit.jacobian, floor, residual, inert)

    mine = coordinates(question.best, as_best)

    def apart(rival: State) -> Apart:
        # both are of the same rows: in the difference their noise is gone, which a fit would take for evidence
        as_rival = command_residual(there, rival.hypothesis, floor)
        return coordinates(rival, as_rival).beside(mine).apart(as_rival - as_best)

    rivals, bare = tuple(map(apart, question.rivals)), None if question.bare is None else apart(question.bare)
    return Separation(question, rivals, bare, len(without), np.sum(without**2, axis=0))
