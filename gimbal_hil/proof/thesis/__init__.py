"""The thesis on which this project is based, computed again: controller tables, unbalance, friction, and its errors."""

from gimbal_hil.proof.thesis.asking import ask_for_kernels
from gimbal_hil.proof.thesis.controller_tables import step_figures
from gimbal_hil.proof.thesis.inferred import LEVEL
from gimbal_hil.proof.thesis.page import as_document
from gimbal_hil.proof.thesis.printed import POSITION_GAINS, RATE_GAINS
from gimbal_hil.proof.thesis.text import as_text
from gimbal_hil.proof.thesis.thesis_report import ThesisReport
from gimbal_hil.proof.thesis.validation import run_thesis

__all__ = [
    "LEVEL",
    "POSITION_GAINS",
    "RATE_GAINS",
    "ThesisReport",
    "as_document",
    "as_text",
    "ask_for_kernels",
    "run_thesis",
    "step_figures",
]
