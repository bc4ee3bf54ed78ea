"""Fitting, blocks and intervals: one place for identification, discrepancy and improvement."""

from gimbal_hil.knowledge.estimation.blocks import Paired, block_sums, decorrelation_rows, paired
from gimbal_hil.knowledge.estimation.bounded_fit import BoundedFit, bounded_fit

__all__ = ["BoundedFit", "Paired", "block_sums", "bounded_fit", "decorrelation_rows", "paired"]
