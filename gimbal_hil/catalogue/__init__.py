"""Runs beside each other: what is there, what each was, and how two of them differ."""

from gimbal_hil.catalogue.comparison import Comparison, compare, comparison_page
from gimbal_hil.catalogue.summary import Measure, Summary, find_runs, measures_of, summary_of

__all__ = [
    "Comparison",
    "Measure",
    "Summary",
    "compare",
    "comparison_page",
    "find_runs",
    "measures_of",
    "summary_of",
]
