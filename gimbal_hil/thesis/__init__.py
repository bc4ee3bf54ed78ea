"""The thesis that this project grew from, run again: controller tables, unbalance, friction, and what does not hold."""

from gimbal_hil.thesis.asking import ask_for_kernels
from gimbal_hil.thesis.page import as_document
from gimbal_hil.thesis.text import as_text
from gimbal_hil.thesis.thesis_report import ThesisReport
from gimbal_hil.thesis.validation import run_thesis

__all__ = ["ThesisReport", "as_document", "as_text", "ask_for_kernels", "run_thesis"]
