"""Improvements in this process, for tests: a task on a virtual antenna, with a journal, and a site that can be made to
stop.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from gimbal_hil.knowledge.experiments.experiment import Experiment
from gimbal_hil.knowledge.experiments.runner import ProgressSink
from gimbal_hil.knowledge.experiments.sequences.survey import SHORT_SURVEY_S
from gimbal_hil.knowledge.improvement import (
    Improvement,
    Journal,
    Site,
    Started,
    Task,
    VirtualSite,
    budgets_of,
    improve,
    session_of,
)
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.model import AntennaModel, shipped_model


@dataclass
class CountingSite:
    """A site that counts its runs, and is interrupted before one of them."""

    inner: Site
    interrupted_before: int = 0
    runs: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """Where."""
        return self.inner.text

    def run(self, experiment: Experiment, folder: Path, number: int, progress: ProgressSink) -> None:
        """Run, or be interrupted."""
        if len(self.runs) + 1 == self.interrupted_before:
            raise KeyboardInterrupt
        self.runs.append(experiment.name)
        self.inner.run(experiment, folder, number, progress)


def task_of(
    out: Path,
    antenna_s: float = 900.0,
    rounds: int = 6,
    torque: dict[str, float] | None = None,
    travel: dict[str, tuple[float, float]] | None = None,
) -> Task:
    """A short improvement of the shipped model."""
    settings = shipped_settings()
    return Task(
        settings,
        shipped_model(),
        out,
        budgets_of(settings, antenna_s, rounds, torque or {}, travel or {}),
        SHORT_SURVEY_S,
        workers=1,
    )


def virtual(antenna: AntennaModel) -> CountingSite:
    """The site of an antenna."""
    return CountingSite(VirtualSite(shipped_settings(), antenna, 5))


def improved(task: Task, site: Site, resume: bool = False) -> Improvement:
    """One session, with its journal."""
    journal = Journal(task.out / "journal.jsonl", resume=resume)
    if not resume:
        journal.write(Started(session_of(task)))
    try:
        return improve(task, site, journal)
    finally:
        journal.close()
