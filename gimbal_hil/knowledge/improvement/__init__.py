"""Experiment, diagnose and correct until the model is at the noise floor or nothing more can be found."""

from gimbal_hil.knowledge.improvement.budgets import Budgets, budgets_of, torques_of, travels_of
from gimbal_hil.knowledge.improvement.design import settling_run
from gimbal_hil.knowledge.improvement.journal import (
    JOURNAL_FILE,
    Journal,
    Measured,
    Resumed,
    Started,
    Stopped,
    read_journal,
)
from gimbal_hil.knowledge.improvement.loop import improve
from gimbal_hil.knowledge.improvement.page import improvement_page
from gimbal_hil.knowledge.improvement.rehearsal import rehearse
from gimbal_hil.knowledge.improvement.showing import showing_run
from gimbal_hil.knowledge.improvement.site import Site, VirtualSite, site_of
from gimbal_hil.knowledge.improvement.task import Ending, Improvement, Task, session_of

__all__ = [
    "JOURNAL_FILE",
    "Budgets",
    "Ending",
    "Improvement",
    "Journal",
    "Measured",
    "Resumed",
    "Site",
    "Started",
    "Stopped",
    "Task",
    "VirtualSite",
    "budgets_of",
    "improve",
    "improvement_page",
    "read_journal",
    "rehearse",
    "session_of",
    "settling_run",
    "showing_run",
    "site_of",
    "torques_of",
    "travels_of",
]
