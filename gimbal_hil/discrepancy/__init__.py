"""Find where a model is wrong, name what is missing, add it, and show the gap shrink."""

from gimbal_hil.discrepancy.contradictions import ramps_apart
from gimbal_hil.discrepancy.corrected import corrected_model, explained_by, recalibrated_model
from gimbal_hil.discrepancy.deciding import Kind, Status
from gimbal_hil.discrepancy.discrepancy_page import discrepancy_page
from gimbal_hil.discrepancy.evidence import command_residual
from gimbal_hil.discrepancy.families import families
from gimbal_hil.discrepancy.fit import Weighing, fit, prior_weights
from gimbal_hil.discrepancy.foreseen import ORDER, Foreseen, foreseen
from gimbal_hil.discrepancy.hypothesis import Hypothesis
from gimbal_hil.discrepancy.inquiry import State, refitted
from gimbal_hil.discrepancy.policy import LEAST_GAP, Policy
from gimbal_hil.discrepancy.preflight import check_logs
from gimbal_hil.discrepancy.prepare import scored_band
from gimbal_hil.discrepancy.record import record_of
from gimbal_hil.discrepancy.run import Request, Result, diagnose
from gimbal_hil.discrepancy.screening import respond
from gimbal_hil.discrepancy.separating import CHANCE, all_sequences, separating_runs, showing_sequences
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.standing import standing
from gimbal_hil.discrepancy.twin import Twin
from gimbal_hil.discrepancy.verdict import Verdict, entries_of, verdict_of

__all__ = [
    "CHANCE",
    "LEAST_GAP",
    "ORDER",
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
    "respond",
    "scored_band",
    "separating_runs",
    "showing_sequences",
    "standing",
    "verdict_of",
]
