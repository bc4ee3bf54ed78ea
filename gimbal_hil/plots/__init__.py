"""The common look of every figure; apart from the pages, because plotly is heavy."""

from gimbal_hil.plots.figures import ALERT, AXIS_COLOURS, MEASURED, MODEL, REFERENCE, SECOND, figure, stacked, thinned

__all__ = [
    "ALERT",
    "AXIS_COLOURS",
    "MEASURED",
    "MODEL",
    "REFERENCE",
    "SECOND",
    "figure",
    "stacked",
    "thinned",
]
