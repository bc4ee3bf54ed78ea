"""Margins of the loops as implemented, and the gains with the least error that keep them."""

from gimbal_hil.knowledge.tuning.aims import Aim
from gimbal_hil.knowledge.tuning.assumed import AssumedNumber, assumed_numbers, caution, is_assumed
from gimbal_hil.knowledge.tuning.axis_cases import axis_cases, axis_inertias, told_wrong
from gimbal_hil.knowledge.tuning.choosing import LoopChoice, LoopFigures, TuningTask, figures
from gimbal_hil.knowledge.tuning.loops import (
    AxisDynamics,
    CascadeLaw,
    ObservedLaw,
    SampledLaw,
    crossing_rad_s,
    disk_margin,
    encirclements,
    errors,
    least_margin,
    margins,
)
from gimbal_hil.knowledge.tuning.predicting import PredictedJoint, natural_of, predicted_joint
from gimbal_hil.knowledge.tuning.rivals import as_array, linear_quadratic, loop_shaped, notched
from gimbal_hil.knowledge.tuning.stability import largest_pole
from gimbal_hil.knowledge.tuning.tuning import (
    MARGIN,
    AxisTuning,
    NoMarginError,
    Tuning,
    laws_of,
    regulated,
    tuned,
    tuning_task,
)

__all__ = [
    "MARGIN",
    "Aim",
    "AssumedNumber",
    "AxisDynamics",
    "AxisTuning",
    "CascadeLaw",
    "LoopChoice",
    "LoopFigures",
    "NoMarginError",
    "ObservedLaw",
    "PredictedJoint",
    "SampledLaw",
    "Tuning",
    "TuningTask",
    "as_array",
    "assumed_numbers",
    "axis_cases",
    "axis_inertias",
    "caution",
    "crossing_rad_s",
    "disk_margin",
    "encirclements",
    "errors",
    "figures",
    "is_assumed",
    "largest_pole",
    "laws_of",
    "least_margin",
    "linear_quadratic",
    "loop_shaped",
    "margins",
    "natural_of",
    "notched",
    "predicted_joint",
    "regulated",
    "told_wrong",
    "tuned",
    "tuning_task",
]
