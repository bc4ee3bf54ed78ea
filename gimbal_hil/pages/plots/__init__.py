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
    in_floors,
    logarithm,
    peaks_kept,
    stacked,
    thinned,
)
from gimbal_hil.pages.plots.picture_file import PICTURE_ENDINGS, write_picture

__all__ = [
    "ALERT",
    "AXIS_COLOURS",
    "MEASURED",
    "MODEL",
    "PICTURE_ENDINGS",
    "REFERENCE",
    "SECOND",
    "Drawing",
    "figure",
    "figure_of_panels",
    "in_floors",
    "logarithm",
    "peaks_kept",
    "stacked",
    "thinned",
    "write_picture",
]
