"""The survey's other trajectory, to judge on what was found with the first."""

from gimbal_hil.experiments.sequences.survey import build_holdout as build

__all__ = ["build"]
