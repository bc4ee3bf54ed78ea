"""Find where a model is wrong, name what is missing, add it, and show the gap shrink."""

from gimbal_hil.discrepancy.contradictions import ramps_apart
from gimbal_hil.discrepancy.corrected import corrected_model, recalibrated_model
from gimbal_hil.discrepancy.deciding import Kind, Status
from gimbal_hil.discrepancy.discrepancy_page import discrepancy_page
from gimbal_hil.discrepancy.policy import LEAST_GAP, Policy
from gimbal_hil.discrepancy.preflight import check_logs
from gimbal_hil.discrepancy.run import Request, Result, diagnose
from gimbal_hil.discrepancy.verdict import Verdict, verdict_of

__all__ = [
    "LEAST_GAP",
    "Kind",
    "Policy",
    "Request",
    "Result",
    "Status",
    "Verdict",
    "check_logs",
    "corrected_model",
    "diagnose",
    "discrepancy_page",
    "ramps_apart",
    "recalibrated_model",
    "verdict_of",
]
