"""The verdict: what is reported, as a typed value, a model file, plain words and a page."""

from gimbal_hil.knowledge.discrepancy.verdict.attributed import attributed, found_numbers
from gimbal_hil.knowledge.discrepancy.verdict.contradictions import ramps_apart
from gimbal_hil.knowledge.discrepancy.verdict.corrected import corrected_model, explained_by, recalibrated_model
from gimbal_hil.knowledge.discrepancy.verdict.discrepancy_page import discrepancy_page
from gimbal_hil.knowledge.discrepancy.verdict.headlines import headline, is_brief
from gimbal_hil.knowledge.discrepancy.verdict.separating import (
    CHANCE,
    all_sequences,
    separating_runs,
    showing_sequences,
    why_not_testable,
)
from gimbal_hil.knowledge.discrepancy.verdict.shown_table import smallest_shown
from gimbal_hil.knowledge.discrepancy.verdict.torque_times import with_torque_times
from gimbal_hil.knowledge.discrepancy.verdict.verdict import Verdict, entries_of, refusal, verdict_of
from gimbal_hil.knowledge.discrepancy.verdict.wording import told_contradictions

__all__ = [
    "CHANCE",
    "Verdict",
    "all_sequences",
    "attributed",
    "corrected_model",
    "discrepancy_page",
    "entries_of",
    "explained_by",
    "found_numbers",
    "headline",
    "is_brief",
    "ramps_apart",
    "recalibrated_model",
    "refusal",
    "separating_runs",
    "showing_sequences",
    "smallest_shown",
    "told_contradictions",
    "verdict_of",
    "why_not_testable",
    "with_torque_times",
]
