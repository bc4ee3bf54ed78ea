"""The motion in which numbers would show that the logs say nothing of: half or twice the right inertia, friction, gain.

A log can leave no gap and still say nothing of an axis that hardly moved. What is asked of a motion then is how much an
error of each such number would leave of it, once the other known numbers have taken what they can. The criterion is
A-optimality, the sum of the variances of these numbers, each in units of the error that should show (Kiefer 1959).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import (
    Floats,
    NumberError,
    Result,
    Twin,
    command_residual,
    explained_by,
    number_errors,
)
from gimbal_hil.knowledge.executor import WorkExecutor
from gimbal_hil.knowledge.improvement.apart import SPREAD, Apart, Coordinates, rehearsal_of
from gimbal_hil.knowledge.improvement.budgets import budgets_of
from gimbal_hil.knowledge.improvement.choosing import Option
from gimbal_hil.knowledge.improvement.design import ANTENNA_S, DesignTask, designed, written
from gimbal_hil.loop.settings import DaemonSettings
from sim_backend.model import AntennaModel


@dataclass(frozen=True)
class HiddenNumbers:
    """Errors that should show, the model, and what its logs are judged by; fewer floors than `least_gap` are no gap."""

    errors: tuple[NumberError, ...]
    model: AntennaModel
    twin: Twin
    floor: Floats
    least_gap: float

    def only(self, labels: Collection[tuple[str, str]]) -> HiddenNumbers:
        """The same of these numbers alone."""
        return replace(self, errors=tuple(error for error in self.errors if error.label in labels))

    def shown(self, table: SignalsTable) -> HiddenShown:
        """What a table of the model says."""
        there = rehearsal_of(self.twin, table)
        # half and twice of a number leave the same others
        others = {error.label: self._coordinates(there, error) for error in self.errors}
        each = tuple(others[error.label].apart(error.on(there, self.floor)) for error in self.errors)
        return HiddenShown(each, int(there.records[0].keep.sum()) * len(there.channels), self.least_gap)

    def _coordinates(self, there: Twin, error: NumberError) -> Coordinates:
        """The other known numbers, held by the logs so far."""
        known = error.bare.hypothesis
        residual = command_residual(there, known, self.floor)
        return Coordinates.of(there, known, error.bare.jacobian, self.floor, residual)


@dataclass(frozen=True)
class HiddenShown:
    """What every error leaves of a table, its scored rows times channels, and the floors that are no gap."""

    errors: tuple[Apart, ...]
    rows: int
    least_gap: float

    def expected(self, times: int = 1) -> float:
        """Squared floors: one over the sum of the variances, which is no more than the least that an error leaves."""
        left = np.array([one.beyond(times) for one in self.errors])
        return 0.0 if np.any(left <= 0.0) else float(1.0 / np.sum(1.0 / left))

    def needed(self, times: int = 1) -> float:
        """Squared floors of a gap on every channel, in the rows of so many such tables by themselves."""
        return self.least_gap**2 * times * self.rows / SPREAD


def _may_be(model: AntennaModel, twin: Twin, errors: tuple[NumberError, ...]) -> Iterator[AntennaModel]:
    """The model with each of the errors, as far as a body can have it: nobody knows which of them the antenna is."""
    for error in errors:
        with suppress(BadInputError):
            yield explained_by(model, twin, error.off)


@dataclass(frozen=True)
class ShowingRun:
    """A motion, the numbers (effect, axis) that it shows, and those that it does not: no motion shows them, or none
    that shows the others.
    """

    shows: tuple[tuple[str, str], ...]
    not_shown: tuple[tuple[str, str], ...]
    option: Option


def showing_run(
    result: Result,
    settings: DaemonSettings,
    path: Path,
    executor: WorkExecutor,
    tell: Callable[[str], None] = lambda text: None,
) -> ShowingRun | None:
    """A motion that shows numbers which the logs say nothing of, its plan in a file; None where nothing is hidden, or
    no motion shows any of it.
    """
    inquiry, now = result.inquiry, result.model
    errors = number_errors(inquiry, result.null, result.hidden)
    if not errors:
        return None
    question = HiddenNumbers(errors, now, replace(inquiry.twin, scales=None), inquiry.floor, inquiry.policy.least_gap)
    budgets = budgets_of(settings, ANTENNA_S, 1, {}, {})
    task = DesignTask(question, settings, budgets, may_be=tuple(_may_be(now, inquiry.twin, errors)))
    return shown_by_one(task, question, path, executor, tell)


def shown_by_one(
    task: DesignTask,
    question: HiddenNumbers,
    path: Path,
    executor: WorkExecutor,
    tell: Callable[[str], None] = lambda text: None,
) -> ShowingRun | None:
    """One motion for all numbers of the question; where none shows all, for as many of them as one shows."""
    every = tuple(dict.fromkeys(error.label for error in question.errors))
    for labels in _together(task, question, executor, tell):
        words = ", ".join(f"{name.replace('_', ' ')} of {axis}" for name, axis in labels)
        asked = replace(task, question=question.only(labels))
        made = written(asked, f"Made to show {words}", labels[0][1], question.model, path, executor, tell)
        if made is not None:
            return ShowingRun(labels, tuple(label for label in every if label not in labels), made)
    return None


def _together(
    task: DesignTask, question: HiddenNumbers, executor: WorkExecutor, tell: Callable[[str], None]
) -> Iterator[tuple[tuple[str, str], ...]]:
    """Numbers that one motion may show: all; then those that a motion shows by itself, without the one that shows
    least, and so on.
    """
    every = tuple(dict.fromkeys(error.label for error in question.errors))
    yield every
    if len(every) == 1:
        return
    tell("designing: no motion shows all of these numbers; looking for one that shows some")
    alone = {one: designed(replace(task, question=question.only((one,))), executor) for one in every}
    merits = {one: design.merit for one, design in alone.items() if design is not None}
    able = sorted(merits, key=lambda one: -merits[one])
    for count in range(min(len(able), len(every) - 1), 0, -1):
        yield tuple(able[:count])


__all__ = ["HiddenNumbers", "HiddenShown", "ShowingRun", "showing_run", "shown_by_one"]
