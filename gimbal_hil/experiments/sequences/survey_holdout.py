"""The survey's other trajectory, to judge on what was found with the first."""

from __future__ import annotations

from gimbal_hil.experiments.experiment import Experiment
from gimbal_hil.experiments.sequences.options import SequenceOptions
from gimbal_hil.experiments.sequences.survey import survey


def build(options: SequenceOptions) -> Experiment:
    """Survey number 1."""
    return survey(options, 1)
