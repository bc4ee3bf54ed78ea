"""Margins of the loops as implemented, and the gains with the least error that keep them."""

from gimbal_hil.knowledge.tuning.aims import Aim
from gimbal_hil.knowledge.tuning.axis_cases import axis_cases, axis_inertias, told_wrong
from gimbal_hil.knowledge.tuning.choosing import LoopFigures, TuningTask, figures
from gimbal_hil.knowledge.tuning.loops import (
    AxisDynamics,
    CascadeLaw,
    ObservedLaw,
    crossing_rad_s,
    disk_margin,
    encirclements,
    errors,
    least_margin,
    margins,
)
from gimbal_hil.knowledge.tuning.stability import largest_pole
from gimbal_hil.knowledge.tuning.tuning import MARGIN, AxisTuning, NoMarginError, Tuning, laws_of, tuned, tuning_task

__all__ = [
    "MARGIN",
    "Aim",
    "AxisDynamics",
    "AxisTuning",
    "CascadeLaw",
    "LoopFigures",
    "NoMarginError",
    "ObservedLaw",
    "Tuning",
    "TuningTask",
    "axis_cases",
    "axis_inertias",
    "crossing_rad_s",
    "disk_margin",
    "encirclements",
    "errors",
    "figures",
    "largest_pole",
    "laws_of",
    "least_margin",
    "margins",
    "told_wrong",
    "tuned",
    "tuning_task",
]
