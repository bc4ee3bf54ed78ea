"""The motion that settles a question, in place of an entry of the menu.

Motions are moved by direct search to where the explanations that remain would differ most in a second of antenna time.
Each trial is rehearsed by the compiled plant under the loops of the configuration, and refused where it exceeds a
budget; so is what is run in the end. The criterion is T-optimality (Atkinson and Fedorov 1975), weighted by the odds of
the explanations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from firmware_protocol.documents import yaml_text
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Result
from gimbal_hil.knowledge.executor import WorkExecutor
from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.improvement.budgets import AFTERWARDS_S, Budgets, budgets_of
from gimbal_hil.knowledge.improvement.choosing import (
    MotionQuestion,
    Option,
    Pair,
    open_pairs,
    question_of,
)
from gimbal_hil.knowledge.improvement.motion import (
    MADE,
    LapMotion,
    drawn,
    experiment_of_motion,
    plan_of,
    ranges_of,
    varied,
)
from gimbal_hil.knowledge.improvement.rehearsal import Rehearsal, rehearse
from gimbal_hil.loop.settings import DaemonSettings
from sim_backend.model import AntennaModel

#: motions that are tried first, then in each generation; generations; those that others are made from
_FIRST, _EACH, _GENERATIONS, _PARENTS = 40, 24, 9, 5
#: what shows so many times what is needed answers plainly; of less, evidence a second counts the less. And more than so
#: many times answers no better: a motion that chatters at the actuator's limits shows 1e7 times what is needed, and
#: there a twin errs by more than the noise
_PLAINLY, _PLENTY = 2.0, 1000.0
#: antenna time of a motion by itself
ANTENNA_S = 120.0


@dataclass(frozen=True)
class Design:
    """A motion, what it is expected to show and what is needed for an answer (squared floors), and how long it takes
    without the way back after it.
    """

    motion: LapMotion
    expected: float
    needed: float
    duration_s: float

    @property
    def per_second(self) -> float:
        """Squared floors a second of antenna time, with the way back after it."""
        return self.expected / (self.duration_s + AFTERWARDS_S)

    @property
    def merit(self) -> float:
        """What the search makes large: evidence a second, of which what is not enough for an answer counts less, and
        what is more than plenty does not count.
        """
        counted = min(self.expected, _PLENTY * self.needed) / (self.duration_s + AFTERWARDS_S)
        return counted * min(1.0, self.expected / (_PLAINLY * self.needed))


@dataclass(frozen=True)
class DesignTask:
    """What a motion is designed for and within what: the question, loops and limits of the antenna, time that is used
    up, and what else the antenna may be, on which the motion has to keep to the budgets too.
    """

    question: MotionQuestion
    settings: DaemonSettings
    budgets: Budgets
    used_s: float = 0.0
    may_be: tuple[AntennaModel, ...] = ()


def designed(
    task: DesignTask,
    executor: WorkExecutor,
    seed: int = 0,
    tell: Callable[[str], None] = lambda text: None,
    generations: int = _GENERATIONS,
) -> Design | None:
    """The best motion that was found; None where none shows what is needed. The same seed gives the same motion: trials
    are counted, not seconds.
    """
    rng = np.random.default_rng(seed)
    ranges, there = ranges_of(task.settings, task.budgets), executor.share(task)
    tried: list[Design] = []
    batch = [drawn(rng, ranges, k) for k in range(_FIRST)]
    for generation in range(generations + 1):
        tried += [one for one in executor.map(_tried, [there] * len(batch), batch) if one is not None]
        tried.sort(key=lambda one: -one.merit)
        if tried:
            tell(f"designing: {tried[0].per_second:.3g} squared floors a second after {generation} generations")
        parents = [one.motion for one in tried[:_PARENTS]] or [drawn(rng, ranges, k) for k in range(_PARENTS)]
        batch = [varied(rng, ranges, parents[int(rng.integers(len(parents)))]) for _ in range(_EACH)]
    whole = (_whole(task, one.motion) for one in tried[:_EACH] if one.expected >= one.needed)
    return next((one for one in whole if one is not None and one.expected >= one.needed), None)


def made_for(
    task: DesignTask,
    pair: Pair,
    now: AntennaModel,
    path: Path,
    executor: WorkExecutor,
    tell: Callable[[str], None] = lambda text: None,
) -> Option | None:
    """A motion made for a pair, its plan in a file; None where none shows what is needed, or where the model as it is
    `now` would not be allowed it.
    """
    two = " from ".join(f"{name.replace('_', ' ')} on {axis}" for name, axis in pair.names)
    return written(task, f"Made to tell {two}", pair.names[0][1], now, path, executor, tell)


def written(
    task: DesignTask,
    why: str,
    axis: str,
    now: AntennaModel,
    path: Path,
    executor: WorkExecutor,
    tell: Callable[[str], None] = lambda text: None,
) -> Option | None:
    """A motion made for a question, its plan in a file that says why; None as for `made_for`."""
    made = designed(task, executor, tell=tell)
    if made is None:
        return None
    worth = f"{made.expected:.3g} squared floors expected in {made.duration_s:.3g} s, {made.needed:.3g} needed"
    text = f"{why}: {worth}"
    experiment = experiment_of_motion(made.motion, text, task.settings, task.budgets)
    if _allowed(task, experiment, now) is None:
        return None
    path.parent.mkdir(parents=True, exist_ok=True)
    plan = plan_of(made.motion, text, task.settings, task.budgets)
    path.write_text(yaml_text(plan, leaves_in_line=True), encoding="utf-8")
    return Option(MADE, axis, made.expected, made.duration_s)


def settling_run(
    result: Result,
    settings: DaemonSettings,
    path: Path,
    executor: WorkExecutor,
    tell: Callable[[str], None] = lambda text: None,
) -> tuple[Pair, Option] | None:
    """A pair that an ambiguous verdict leaves open, and a motion made for it, its plan in a file; None where nothing is
    open, or none shows it.
    """
    budgets = budgets_of(settings, ANTENNA_S, 1, {}, {})
    for pair in open_pairs(result, ()):
        task = DesignTask(question_of(result, pair), settings, budgets)
        made = made_for(task, pair, result.model, path, executor, tell)
        if made is not None:
            return pair, made
    return None


def _tried(task: DesignTask, motion: LapMotion) -> Design | None:
    """A lap of a motion, as often as it is worth most, with what that would show; None where it is refused."""
    found = _rehearsed(task, replace(motion, laps=1))
    if found is None:
        return None
    table, first_s = found
    shown, lap_s = task.question.shown(table), sum(one.over_s for one in motion.segments)
    designs = [
        Design(replace(motion, laps=laps), shown.expected(laps), shown.needed(laps), first_s + (laps - 1) * lap_s)
        for laps in range(1, motion.most_laps + 1)
    ]
    return max(designs, key=lambda one: one.merit)


def _whole(task: DesignTask, motion: LapMotion) -> Design | None:
    """A motion with all its laps, and what it would show; None where it is refused."""
    experiment = experiment_of_motion(motion, "a trial", task.settings, task.budgets)
    found = _rehearsed(task, motion)
    if found is None or any(_allowed(task, experiment, model) is None for model in task.may_be):
        return None
    shown = task.question.shown(found[0])
    return Design(motion, shown.expected(), shown.needed(), found[1])


def _rehearsed(task: DesignTask, motion: LapMotion) -> tuple[SignalsTable, float] | None:
    """What a motion measures with the best explanation, and its seconds; None where it is refused."""
    experiment = experiment_of_motion(motion, "a trial", task.settings, task.budgets)
    rehearsal = _allowed(task, experiment, task.question.model)
    if rehearsal is None or rehearsal.table is None:
        return None
    return rehearsal.table, experiment.duration_s(task.settings.rate_hz)


def _allowed(task: DesignTask, experiment: Experiment, model: AntennaModel) -> Rehearsal | None:
    """An experiment rehearsed on a model; None where that exceeds a budget."""
    rehearsal = rehearse(experiment, task.settings, model)
    refusal = task.budgets.refusal(experiment, rehearsal, task.settings.rate_hz, task.used_s)
    return rehearsal if refusal is None else None


__all__ = ["ANTENNA_S", "Design", "DesignTask", "designed", "made_for", "settling_run", "written"]
