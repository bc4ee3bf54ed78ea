"""Figures, and the look they have in common."""

from gimbal_hil.pages.plots.drawing import Drawing
from gimbal_hil.pages.plots.figures import (
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
    "Drawing",
    "figure",
    "figure_of_panels",
    "stacked",
    "thinned",
]
