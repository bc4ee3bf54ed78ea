"""Fitting, blocks and intervals: one place for identification, discrepancy and improvement."""

from gimbal_hil.knowledge.estimation.blocks import Paired, block_sums, decorrelation_rows, paired
from gimbal_hil.knowledge.estimation.bounded_fit import BoundedFit, bounded_fit
from gimbal_hil.knowledge.estimation.smoothing import Smoothing, SmoothingShape
from gimbal_hil.knowledge.estimation.time_shift import ShiftedFit, ShiftedProblem, fit_at, fit_shifted

__all__ = [
    "BoundedFit",
    "Paired",
    "ShiftedFit",
    "ShiftedProblem",
    "Smoothing",
    "SmoothingShape",
    "block_sums",
    "bounded_fit",
    "decorrelation_rows",
    "fit_at",
    "fit_shifted",
    "paired",
]
