"""Find where a model is wrong, name what is missing, add it, and show the gap shrink."""

from gimbal_hil.knowledge.discrepancy.foreseen import ORDER, Foreseen, foreseen
from gimbal_hil.knowledge.discrepancy.hypotheses import (
    Cause,
    Hypothesis,
    Weighing,
    command_residual,
    families,
    fit,
    prior_weights,
)
from gimbal_hil.knowledge.discrepancy.inquiry import (
    LEAST_GAP,
    Policy,
    State,
    check_logs,
    effect_names,
    refitted,
    scored_band,
    standing,
)
from gimbal_hil.knowledge.discrepancy.judgement import Kind, Request, Result, Status
from gimbal_hil.knowledge.discrepancy.laws import effect_source
from gimbal_hil.knowledge.discrepancy.run import diagnose
from gimbal_hil.knowledge.discrepancy.search import respond
from gimbal_hil.knowledge.discrepancy.twin import Floats, Twin, record_of
from gimbal_hil.knowledge.discrepancy.verdict import (
    CHANCE,
    Verdict,
    all_sequences,
    corrected_model,
    discrepancy_page,
    entries_of,
    explained_by,
    ramps_apart,
    recalibrated_model,
    refusal,
    separating_runs,
    showing_sequences,
    verdict_of,
    with_torque_times,
)

__all__ = [
    "CHANCE",
    "LEAST_GAP",
    "ORDER",
    "Cause",
    "Floats",
    "Foreseen",
    "Hypothesis",
    "Kind",
    "Policy",
    "Request",
    "Result",
    "State",
    "Status",
    "Twin",
    "Verdict",
    "Weighing",
    "all_sequences",
    "check_logs",
    "command_residual",
    "corrected_model",
    "diagnose",
    "discrepancy_page",
    "effect_names",
    "effect_source",
    "entries_of",
    "explained_by",
    "families",
    "fit",
    "foreseen",
    "prior_weights",
    "ramps_apart",
    "recalibrated_model",
    "record_of",
    "refitted",
    "refusal",
    "respond",
    "scored_band",
    "separating_runs",
    "showing_sequences",
    "standing",
    "verdict_of",
    "with_torque_times",
]
