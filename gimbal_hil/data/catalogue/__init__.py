"""Recorded runs: list them, describe one, compare two."""

from gimbal_hil.data.catalogue.comparison import Comparison, compare, comparison_headline, comparison_page
from gimbal_hil.data.catalogue.summary import Measure, Summary, find_runs, measures_of, summary_of

__all__ = [
    "Comparison",
    "Measure",
    "Summary",
    "compare",
    "comparison_headline",
    "comparison_page",
    "find_runs",
    "measures_of",
    "summary_of",
]
