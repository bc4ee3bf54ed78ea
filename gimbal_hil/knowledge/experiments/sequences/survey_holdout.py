"""The survey's other trajectory, to judge on what was found with the first."""

from __future__ import annotations

from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.survey import survey_motion


def build(options: SequenceOptions) -> Experiment:
    """Survey number 1."""
    return survey_motion(options, 1)
