"""The sequences that come with the project, by name; each file builds an experiment: its steps and its analysis."""

from __future__ import annotations

from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions, breakaway_torques
from gimbal_hil.knowledge.experiments.sequences.registry import SEQUENCES, build_experiment
from gimbal_hil.knowledge.experiments.sequences.survey import SHORT_SURVEY_S, SURVEY_S, survey_motion

__all__ = [
    "SEQUENCES",
    "SHORT_SURVEY_S",
    "SURVEY_S",
    "SequenceOptions",
    "breakaway_torques",
    "build_experiment",
    "survey_motion",
]
