"""Plateaus below the Stribeck speed and reversals below break-away: tells the Stribeck bump from bristles and from
plain dry friction.
"""

from __future__ import annotations

import numpy as np

from gimbal_hil.knowledge.experiments import Experiment
from gimbal_hil.knowledge.experiments.sequences.options import SequenceOptions
from gimbal_hil.knowledge.experiments.sequences.reference_motion import (
    ROW_S,
    Floats,
    ReferencePath,
    both_or_held,
    motion_experiment,
)

LOWEST_RAD_S, HIGHEST_RAD_S, SPEEDS, SHORT_SPEEDS = 0.0008, 0.04, 7, 5
PASS_S, SHORT_PASS_S = 2.5, 2.0
#: sizes (rad) and frequency (Hz) of the reversals that follow, each for so many cycles: about the bristles' deflection
#: and below
REVERSALS_RAD, REVERSALS_HZ, CYCLES = (2e-3, 1e-3, 5e-4, 2.5e-4), 0.8, 3


def build(options: SequenceOptions) -> Experiment:
    """Slow passes there and back, then small reversals, on the axes asked for."""
    speeds = np.geomspace(LOWEST_RAD_S, HIGHEST_RAD_S, SHORT_SPEEDS if options.short else SPEEDS).tolist()
    seconds = SHORT_PASS_S if options.short else PASS_S
    paths = options.by_axis((_slow(speeds, seconds), _slow(speeds[::-1], seconds)))
    said = "A bump in friction over speed shows in the passes; stiffness and damping of bristles show in the reversals."
    return motion_experiment(
        "creep", "Below the Stribeck speed and below break-away", options, both_or_held(options, paths), said
    )


def _slow(speeds: list[float], seconds: float) -> Floats:
    # a first move makes the bristles forget how the log began
    path = ReferencePath.at(0.0).pass_at(0.1, 0.1)
    for number, speed in enumerate(speeds):
        path.pass_at(speed, seconds * speed * (1.0 if number % 2 == 0 else -1.0))
    slow = path.sampled(path.end_s, rounded_s=0.05)
    parts = [slow]
    t = np.arange(round(CYCLES / REVERSALS_HZ / ROW_S)) * ROW_S
    for size in REVERSALS_RAD:
        parts.append(slow[-1] + size * np.sin(2.0 * np.pi * REVERSALS_HZ * t))
    return np.concatenate([*parts, np.full(round(0.5 / ROW_S), slow[-1])])
