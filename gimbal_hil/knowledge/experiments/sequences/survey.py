"""Rich motion of both axes, for finding what a model lacks: plateaus at many speeds, reversals, small and quick
motions.

Each variant follows another trajectory, so that what is found on one can be judged on another.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.reference_motion import ROW_S, Floats, ReferencePath, motion_experiment

#: largest excursion (rad) of each axis' slow and quick motion
SLOW_RAD, QUICK_RAD = (0.7, 0.6), (0.05, 0.05)
#: per variant and axis: times of a slow triangle's legs (s), frequencies of the quick sines (Hz)
LEGS_S = (
    ((3.0, 5.0, 8.0), (4.0, 7.0, 2.5), (2.2, 6.0, 4.0), (5.0, 2.7, 7.0)),
    ((2.5, 4.0, 9.0), (6.0, 3.0, 5.0), (3.5, 2.2, 7.0), (2.8, 6.5, 3.6)),
)
QUICK_HZ = (
    ((0.9, 2.3), (1.2, 2.9), (0.7, 3.3), (1.6, 2.6)),
    ((1.3, 3.1), (0.8, 2.6), (1.1, 3.6), (1.9, 3.3)),
)
VARIANTS = len(LEGS_S[0])
SURVEY_S, SHORT_SURVEY_S = 60.0, 24.0
_SAID = "Plateaus at several speeds in both directions, reversals, then quick motion on top."


def build(options: SequenceOptions) -> Experiment:
    """The trajectory that a search is made on."""
    return survey_motion(options, 0)


def survey_motion(options: SequenceOptions, number: int, duration_s: float | None = None) -> Experiment:
    """Survey number 0, 1, ...: the variants come round again with other heights. Without a duration (s) the options
    choose it.
    """
    duration_s = duration_s or (SHORT_SURVEY_S if options.short else SURVEY_S)
    references = options.by_axis((reference(0, duration_s, number), reference(1, duration_s, number)))
    name = "survey" if number == 0 else "survey_holdout" if number == 1 else f"survey_{number + 1}"
    return motion_experiment(name, "Survey motion of both axes", options, references, _SAID)


def reference(place: int, duration_s: float, number: int) -> Floats:
    """Position reference (rad) of an axis (0 carries 1), one value every `ROW_S`: a rounded triangle, then quick sines
    on top.
    """
    legs, quick_hz = LEGS_S[place][number % VARIANTS], QUICK_HZ[place][number % VARIANTS]
    smaller = 0.55 - 0.07 * (number // VARIANTS)
    path, side = ReferencePath.at(0.0), 1
    while path.end_s < duration_s:
        leg = len(path.times_s)
        path.to(SLOW_RAD[place] * side * (1.0 if leg % 3 else smaller), legs[(leg - 1) % len(legs)])
        side = -side
    slow = path.sampled(duration_s)
    t = np.arange(len(slow)) * ROW_S
    share = np.clip((t / duration_s - 0.5) / 0.05, 0.0, 1.0)
    quick = sum(np.sin(2.0 * np.pi * f * t + i) / len(quick_hz) for i, f in enumerate(quick_hz))
    return np.asarray(slow + share * QUICK_RAD[place] * quick, dtype=np.float64)
