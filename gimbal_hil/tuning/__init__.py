"""Margins of the loops as they are built."""

from gimbal_hil.tuning.loops import (
    AxisDynamics,
    CascadeLaw,
    ObservedLaw,
    compliance,
    disk_margin,
    encirclements,
    least_margin,
    margins,
)

__all__ = [
    "AxisDynamics",
    "CascadeLaw",
    "ObservedLaw",
    "compliance",
    "disk_margin",
    "encirclements",
    "least_margin",
    "margins",
]
