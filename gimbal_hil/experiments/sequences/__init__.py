"""The sequences that come with the project, by name; each file builds an experiment: its steps and its analysis."""

from __future__ import annotations

from gimbal_hil.experiments.sequences.options import SequenceOptions, breakaway_torques
from gimbal_hil.experiments.sequences.registry import SEQUENCES, build_experiment

__all__ = ["SEQUENCES", "SequenceOptions", "breakaway_torques", "build_experiment"]
