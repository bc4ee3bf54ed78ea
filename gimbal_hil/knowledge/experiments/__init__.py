"""Experiments: their steps, the runner that executes them, and the results."""

from gimbal_hil.knowledge.experiments.antenna import LockstepAntenna
from gimbal_hil.knowledge.experiments.checkpoint import CHECKPOINT_FILE
from gimbal_hil.knowledge.experiments.conducting import (
    antenna_for,
    conduct,
    conduct_through_daemon,
    embedded_model_of,
    run_header,
)
from gimbal_hil.knowledge.experiments.experiment import (
    Experiment,
    Row,
    Signals,
    Step,
    axes_of,
    move_to,
    position_hold,
    step_of,
)
from gimbal_hil.knowledge.experiments.frequency import (
    CLOSED_STARTS_DEG,
    OPEN_STARTS_DEG,
    FrequencyResponse,
    Lap,
    Margins,
    frequency_response,
    margins_of,
    phase_deg,
)
from gimbal_hil.knowledge.experiments.plan import AxisPlan, Plan, load_plan, plan_from_document
from gimbal_hil.knowledge.experiments.planned import experiment_of_file, experiment_of_plan
from gimbal_hil.knowledge.experiments.plateau import DirectionPair, pair_of, plateau_mean, pooled
from gimbal_hil.knowledge.experiments.references import SHAPES as REFERENCE_SHAPES
from gimbal_hil.knowledge.experiments.references import UNITS as REFERENCE_UNITS
from gimbal_hil.knowledge.experiments.response import SETTLING_BAND, step_response
from gimbal_hil.knowledge.experiments.runner import TEARDOWN_S, Outcome, ProgressSink, Silent, plan_hash, run_experiment
from gimbal_hil.knowledge.experiments.side_by_side import PARTS_FOLDER

__all__ = [
    "CHECKPOINT_FILE",
    "CLOSED_STARTS_DEG",
    "OPEN_STARTS_DEG",
    "PARTS_FOLDER",
    "REFERENCE_SHAPES",
    "REFERENCE_UNITS",
    "SETTLING_BAND",
    "TEARDOWN_S",
    "AxisPlan",
    "DirectionPair",
    "Experiment",
    "FrequencyResponse",
    "Lap",
    "LockstepAntenna",
    "Margins",
    "Outcome",
    "Plan",
    "ProgressSink",
    "Row",
    "Signals",
    "Silent",
    "Step",
    "antenna_for",
    "axes_of",
    "conduct",
    "conduct_through_daemon",
    "embedded_model_of",
    "experiment_of_file",
    "experiment_of_plan",
    "frequency_response",
    "load_plan",
    "margins_of",
    "move_to",
    "pair_of",
    "phase_deg",
    "plan_from_document",
    "plan_hash",
    "plateau_mean",
    "pooled",
    "position_hold",
    "run_experiment",
    "run_header",
    "step_of",
    "step_response",
]
