"""Rounds of survey, diagnosis and correction on the antenna that a configuration names.

Each round runs two different survey motions, searches on the first and judges on the second, and takes over what was named. It ends
when nothing is missing, when the antenna cannot be told apart from two explanations, when something is left that nothing explains,
or when the rounds or the antenna time are used up.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

from gimbal_hil.discrepancy import corrected_model, diagnose, discrepancy_page, verdict_of
from gimbal_hil.experiments.conducting import conduct, embedded_model_of
from gimbal_hil.experiments.runner import ProgressSink, Silent
from gimbal_hil.experiments.sequences import SequenceOptions, build_experiment
from gimbal_hil.settings import DaemonSettings
from gimbal_hil.signals import SignalsTable, read_signals
from sim_backend.model import AntennaModel

SURVEYS = ("survey", "survey_holdout")


class Ending(Enum):
    """Why the loop ended."""

    AT_THE_FLOOR = "the model is at the noise floor"
    AMBIGUOUS = "two explanations cannot be told apart on these motions"
    UNEXPLAINED = "something is left that nothing in the catalogue explains"
    ROUNDS_USED_UP = "the rounds allowed are used up"
    TIME_USED_UP = "the antenna time allowed is used up"


@dataclass(frozen=True)
class Improvement:
    """What the loop leaves: the model as improved, why it ended, the verdict of every round, antenna time used."""

    model: AntennaModel
    ending: Ending
    verdicts: tuple[dict[str, Any], ...]
    antenna_s: float


def improve(
    settings: DaemonSettings,
    start: AntennaModel,
    out: Path,
    *,
    rounds: int = 4,
    budget_s: float = 600.0,
    short: bool = False,
    workers: int = 2,
    dask: str | None = None,
    progress: ProgressSink | None = None,
    say: Callable[[str], None] = lambda line: None,
) -> Improvement:
    """Improve `start` on the virtual antenna that `settings` name, without looking at the model it was made from."""
    progress = progress or Silent()
    antenna, seed = embedded_model_of(settings)
    model, used_s = start, 0.0
    verdicts: list[dict[str, Any]] = []
    for number in range(1, rounds + 1):
        folder = out / f"round_{number}"
        tables: list[SignalsTable] = []
        for name in SURVEYS:
            experiment = build_experiment(name, SequenceOptions(settings.rate_hz, short=short))
            used_s += experiment.duration_s(settings.rate_hz)
            if used_s > budget_s:
                return Improvement(model, Ending.TIME_USED_UP, tuple(verdicts), used_s)
            # every round is another measurement: its noise has another seed
            conduct(experiment, settings, antenna, seed + number, folder / name, force=True, progress=progress)
            tables.append(_surveyed(read_signals(folder / name, start.axes), experiment.duration_s(settings.rate_hz)))
        progress.begin(f"round {number}: diagnosis", 1.0, 0.0)
        tell = lambda text: progress.at(text, 0.0)  # noqa: E731 - one word for the search's progress
        diagnosis = diagnose(model, (tables[0],), (tables[1],), workers=workers, dask=dask, progress=tell)
        verdict = verdict_of(diagnosis)
        verdicts.append(verdict)
        corrected = corrected_model(diagnosis)
        discrepancy_page(diagnosis, verdict, corrected, [str(folder / name) for name in SURVEYS]).write(folder / "report.html")
        say(f"round {number}: {verdict['verdict'].replace('_', ' ')}: {verdict['text']}")
        if verdict["verdict"] == "no_discrepancy":
            return Improvement(model, Ending.AT_THE_FLOOR, tuple(verdicts), used_s)
        if corrected is None:
            return Improvement(model, Ending.UNEXPLAINED, tuple(verdicts), used_s)
        if verdict["verdict"] == "ambiguous":
            return Improvement(corrected, Ending.AMBIGUOUS, tuple(verdicts), used_s)
        model = corrected
    return Improvement(model, Ending.ROUNDS_USED_UP, tuple(verdicts), used_s)


def _surveyed(table: SignalsTable, duration_s: float) -> SignalsTable:
    """Rows of the survey itself: not the fall before the host takes over, nor the hold of the teardown."""
    first = round(1.0 / table.period_s)
    return table.rows(first, min(len(table), round(duration_s / table.period_s)))
