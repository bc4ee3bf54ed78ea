"""The common look of every figure; apart from the pages, because plotly is heavy."""

from gimbal_hil.plots.figures import (
    ALERT,
    AXIS_COLOURS,
    MEASURED,
    MODEL,
    REFERENCE,
    SECOND,
    figure,
    figure_of_panels,
    stacked,
    thinned,
)

__all__ = [
    "ALERT",
    "AXIS_COLOURS",
    "MEASURED",
    "MODEL",
    "REFERENCE",
    "SECOND",
    "figure",
    "figure_of_panels",
    "stacked",
    "thinned",
]
