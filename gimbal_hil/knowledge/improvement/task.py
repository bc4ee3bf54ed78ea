"""What an improvement is given, what it decides on the way, and what it leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

from gimbal_hil.knowledge.discrepancy import Kind
from gimbal_hil.knowledge.experiments.sequences import SURVEY_S
from gimbal_hil.knowledge.improvement.budgets import Budgets
from gimbal_hil.knowledge.improvement.journal import Diagnosed
from gimbal_hil.loop.settings import DaemonSettings
from sim_backend.model import AntennaModel


class Ending(Enum):
    """Why the loop ended."""

    AT_THE_FLOOR = "the model is at the noise floor"
    AMBIGUOUS = "two explanations cannot be told apart by what the antenna can do by itself"
    SUSPECTED = "a cause is suspected that no run which is left would show again"
    UNEXPLAINED = "something is left that nothing in the catalogue explains"
    ROUNDS_USED_UP = "the rounds allowed are used up"
    TIME_USED_UP = "the antenna time allowed is used up"

    @property
    def word(self) -> str:
        """How the journal calls it."""
        return self.name.lower()


class NextStep(Enum):
    """What the loop makes of a diagnosis."""

    AT_THE_FLOOR = "at the floor"
    CHECK = "take the model over and check it on another motion"
    AGAIN = "search the same runs again beside what was learned of the numbers"
    SEPARATE = "run what separates the explanations"
    SHOW = "run a hold-out that shows what only the searched runs have shown"
    SUSPECT = "nothing more can be done, and a cause is suspected only"
    GIVE_UP = "nothing more can be done"


@dataclass(frozen=True)
class Improvement:
    """What the loop leaves: the model as improved, why it ended, the diagnoses of every round, antenna time used."""

    model: AntennaModel
    ending: Ending
    #: the ending in a sentence or two, with what is left and what a person could do
    text: str
    diagnoses: tuple[Diagnosed, ...]
    antenna_s: float


@dataclass(frozen=True)
class Task:
    """What an improvement is given."""

    settings: DaemonSettings
    start: AntennaModel
    out: Path
    budgets: Budgets
    #: length of one survey motion, s
    survey_s: float = SURVEY_S
    workers: int = 2
    #: address of a Dask cluster that scores candidates instead
    dask: str | None = None


def session_of(task: Task) -> dict[str, Any]:
    """What a stopped improvement must go on with, as plain values; budgets and workers may change."""
    return {
        "configuration": task.settings.model_dump(mode="json", by_alias=True),
        "model": task.start.document,
        "survey_s": task.survey_s,
    }


def ending_text(ending: Ending, diagnoses: Sequence[Diagnosed], left: str) -> tuple[str, str]:
    """An ending in a sentence, and what is left."""
    worst = worst_gap(diagnoses[-1]) if diagnoses else None
    said = ending.value[0].upper() + ending.value[1:]
    if ending is Ending.AT_THE_FLOOR and worst is not None:
        said = f"{said}: its largest gap is {worst:.2f} floors on a motion that it had not seen"
        unjudged = []
        if leaves_unjudged(diagnoses[-1]):
            # the answer of the diagnosis says no more than this
            said += ", but these logs cannot judge it"
            unjudged = [diagnoses[-1].more]
        return f"{said}.", " ".join([*unjudged, *(one.remark for one in diagnoses if one.remark)])
    if ending is Ending.TIME_USED_UP:
        return f"{said}: {left or 'the next experiment does not fit'}.", ""
    last = diagnoses[-1]
    return f"{said}.", last.remark or f"{last.text} {last.more}".strip()


def leaves_unjudged(diagnosed: Diagnosed) -> bool:
    """Whether a diagnosis finds no gap, but says that its logs would not have shown large errors of some numbers."""
    return diagnosed.verdict == Kind.CANNOT_JUDGE.value


def worst_gap(diagnosed: Diagnosed, key: str = "before") -> float:
    """Largest gap of a diagnosis over its channels, in floors, before or after what it proposes."""
    return max((gap[key] / gap["noise_floor"] for gap in diagnosed.gaps), default=0.0)
