"""Hypotheses: effects added to a model, their evidence in the logs, and the fit of their numbers."""

from gimbal_hil.knowledge.discrepancy.hypotheses.axis_scales import present_in
from gimbal_hil.knowledge.discrepancy.hypotheses.evidence import (
    command_residual,
    families,
    noise_of_command,
    noise_of_motion,
    shares_of,
    torque_residual,
    with_shares,
)
from gimbal_hil.knowledge.discrepancy.hypotheses.families import Family
from gimbal_hil.knowledge.discrepancy.hypotheses.fit import (
    BROKEN,
    STEP,
    Fit,
    FitRule,
    Weighing,
    bounds_of,
    fit,
    prior_weights,
    weighed_cost,
)
from gimbal_hil.knowledge.discrepancy.hypotheses.hypothesis import (
    PLAUSIBLE,
    Cause,
    Hypothesis,
    KnownNumber,
    at_bound,
    has_no_bump,
    is_tied,
    known_numbers,
    parameters_of,
    plainer_of,
    values_of,
)
from gimbal_hil.knowledge.discrepancy.hypotheses.origin import aligned, placed

__all__ = [
    "BROKEN",
    "PLAUSIBLE",
    "STEP",
    "Cause",
    "Family",
    "Fit",
    "FitRule",
    "Hypothesis",
    "KnownNumber",
    "Weighing",
    "aligned",
    "at_bound",
    "bounds_of",
    "command_residual",
    "families",
    "fit",
    "has_no_bump",
    "is_tied",
    "known_numbers",
    "noise_of_command",
    "noise_of_motion",
    "parameters_of",
    "placed",
    "plainer_of",
    "present_in",
    "prior_weights",
    "shares_of",
    "torque_residual",
    "values_of",
    "weighed_cost",
    "with_shares",
]
