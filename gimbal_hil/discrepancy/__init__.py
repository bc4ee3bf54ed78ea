"""Find where a model is wrong, name what is missing, add it, and show the gap shrink."""

from gimbal_hil.discrepancy.corrected import corrected_model, recalibrated_model
from gimbal_hil.discrepancy.discrepancy_page import discrepancy_page
from gimbal_hil.discrepancy.measured_torque import with_measured_torque
from gimbal_hil.discrepancy.verdict import verdict_of
from gimbal_hil.discrepancy.workflow import Diagnosis, diagnose, with_hold_out

__all__ = [
    "Diagnosis",
    "corrected_model",
    "diagnose",
    "discrepancy_page",
    "recalibrated_model",
    "verdict_of",
    "with_hold_out",
    "with_measured_torque",
]
